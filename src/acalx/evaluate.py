"""``python -m acalx.evaluate`` is the command; imported, ``acalx.evaluate`` stays the function."""

import sys

if __name__ == "__main__":
    from acalx.commands.evaluate import main

    sys.exit(main())
else:
    from acalx.planning.evaluation import evaluate

    sys.modules[__name__] = evaluate  # type: ignore[assignment]
