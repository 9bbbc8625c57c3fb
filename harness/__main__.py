"""``python -m esfem`` is the command ``esfem``."""

from esfem.cli import main

if __name__ == "__main__":
    main()
