"""``python -m doro_viewer`` and the command ``doro-viewer``."""

from doro_viewer.service import main

if __name__ == "__main__":
    main()
