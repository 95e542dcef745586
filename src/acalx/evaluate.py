"""``python -m acalx.evaluate``: figures of merit of a program."""

import sys

from acalx.commands.evaluate import main

if __name__ == "__main__":
    sys.exit(main())
