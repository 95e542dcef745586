"""``python -m acalx.validate`` is the command; imported, ``acalx.validate`` stays the function."""

import sys

if __name__ == "__main__":
    from acalx.commands.validate import main

    sys.exit(main())
else:
    from acalx.validation import validate

    sys.modules[__name__] = validate  # type: ignore[assignment]
