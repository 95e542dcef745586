"""``python -m acalx.validate``: how right a calibration is."""

import sys

from acalx.commands.validate import main

if __name__ == "__main__":
    sys.exit(main())
