"""``python -m doro_dialogue`` and ``doro-dialogue``."""

from doro_dialogue.service import main

__all__ = ["main"]

if __name__ == "__main__":
    main()
