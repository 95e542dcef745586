"""``python -m acalx.run``: design a calibration program."""

import sys

from acalx.commands.run import main

if __name__ == "__main__":
    sys.exit(main())
