"""``python -m acalx.calibrate``: parameters of a sensor from measurements."""

import sys

from acalx.commands.calibrate import main

if __name__ == "__main__":
    sys.exit(main())
