"""``python -m acalx.simulate``: simulated calibrations."""

import sys

from acalx.commands.simulate import main

if __name__ == "__main__":
    sys.exit(main())
