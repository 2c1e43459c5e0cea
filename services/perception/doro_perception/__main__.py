"""``python -m doro_perception`` and the command ``doro-perception``."""

from doro_perception.service import main

if __name__ == "__main__":
    main()
