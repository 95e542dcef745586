"""``python -m acalx.calibrate`` is the command; imported, ``acalx.calibrate`` stays the function."""

import sys

if __name__ == "__main__":
    from acalx.commands.calibrate import main

    sys.exit(main())
else:
    from acalx.estimation import calibrate

    sys.modules[__name__] = calibrate  # type: ignore[assignment]
