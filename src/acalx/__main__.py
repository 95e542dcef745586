"""The console script: ``acalx run ...``, ``acalx evaluate ...``, with TAB completion."""

from __future__ import annotations

import importlib
import os
import sys

from acalx import __version__

__all__ = ["main"]

_COMMANDS = {
    "run": "design a calibration program",
    "evaluate": "figures of merit of a program that someone already uses",
    "simulate": "what a program is worth: simulated calibrations with everything that goes wrong",
    "calibrate": "parameters of a sensor from measurements, and readings made right",
    "validate": "how right a calibration is on positions that it has not seen",
}
_QUERY = "query="


def main() -> int:
    """Hand over to the entry point that the first argument names."""
    arguments = sys.argv[1:]
    if any(argument.startswith(_QUERY) for argument in arguments):
        return _complete()
    if arguments and arguments[0] in _COMMANDS:
        return _hand_over(arguments[0], arguments[1:])
    if arguments and (arguments[0] in ("-sc", "--shell-completion")):
        return _hand_over("run", arguments, program="acalx")
    if arguments and arguments[0] == "--version":
        print(__version__)
        return 0
    print(_help())
    if arguments and arguments[0] not in ("-h", "--help"):
        from acalx.commands.explain import suggestion

        print(f"acalx: no command {arguments[0]!r}{suggestion(arguments[0], _COMMANDS)}", file=sys.stderr)
        return 2
    return 0


def _hand_over(command: str, arguments: list[str], program: str = "") -> int:
    sys.argv = [program or f"acalx {command}", *arguments]
    status: int = importlib.import_module(f"acalx.commands.{command}").main()
    return status


def _complete() -> int:
    """Answer the shell: commands for the first word, Hydra's own completion behind it."""
    line = os.environ.get("COMP_LINE", "")
    program, *words = line.split(" ")
    if len(words) <= 1:
        print("\n".join(command for command in _COMMANDS if command.startswith("".join(words))))
        return 0
    command = words[0] if words[0] in _COMMANDS else "run"
    rest = f"{program} {' '.join(words[1:])}"
    os.environ["COMP_LINE"], os.environ["COMP_POINT"] = rest, str(len(rest))
    return _hand_over(command, sys.argv[1:])


def _help() -> str:
    commands = "\n".join(f"  acalx {name:<10} {text}" for name, text in _COMMANDS.items())
    return (
        f"acalx designs calibration programs for inertial sensors.\n\n{commands}\n\n"
        "For example: acalx run criterion=d_fair optimizer=de n=9\n"
        "All options of a command: acalx run --help. "
        'TAB completion in bash: eval "$(acalx -sc install=bash)"'
    )


if __name__ == "__main__":
    sys.exit(main())
