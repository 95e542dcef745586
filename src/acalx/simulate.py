"""``python -m acalx.simulate`` is the command; imported, ``acalx.simulate`` stays the function."""

import sys

if __name__ == "__main__":
    from acalx.commands.simulate import main

    sys.exit(main())
else:
    from acalx.simulation import simulate

    sys.modules[__name__] = simulate  # type: ignore[assignment]
