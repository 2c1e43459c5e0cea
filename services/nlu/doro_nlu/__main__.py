"""``python -m doro_nlu`` and ``doro-nlu``."""

from doro_nlu.service import main

if __name__ == "__main__":
    main()
