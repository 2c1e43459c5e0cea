"""``python -m doro_mapper`` and the command ``doro-mapper``."""

from doro_mapper.service import main

if __name__ == "__main__":
    main()
