"""Whether two checkouts design the same programs: each command line of commands.txt, program.csv byte by byte.

    python benchmarks/same_programs.py OTHER_PYTHON

OTHER_PYTHON is the interpreter of an environment in which the other checkout is installed. The
certificate and figures are left out, since they don't change a program. Ends with exit status 1
where a program differs.
"""

from __future__ import annotations

import hashlib
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

COMMANDS = Path(__file__).with_name("commands.txt")


def command_lines() -> list[str]:
    """Those of the file, without its comments."""
    lines = COMMANDS.read_text(encoding="utf-8").splitlines()
    return [line for line in lines if line and not line.startswith("#")]


def digest(python: str, line: str, folder: Path) -> str:
    """What a command line leaves as program.csv, or what it says where it fails."""
    directory = folder / "run"
    command = [python, "-m", "acalx.run", *line.split(), "figures=false", f"hydra.run.dir={directory}"]
    if "objectives=" not in line:
        command.append("certificate=false")
    outcome = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    program = directory / "program.csv"
    if not program.exists():
        return outcome.stderr.strip().splitlines()[-1] if outcome.stderr.strip() else f"exit {outcome.returncode}"
    return hashlib.sha256(program.read_bytes()).hexdigest()[:16]


def compared(line: str, other: str) -> bool:
    """Run a command line under both interpreters and say whether it gives the same."""
    with tempfile.TemporaryDirectory() as first, tempfile.TemporaryDirectory() as second:
        ours, theirs = digest(sys.executable, line, Path(first)), digest(other, line, Path(second))
    print(f"{'same     ' if ours == theirs else 'DIFFERENT'}  {ours:16}  {theirs:16}  {line}", flush=True)
    return ours == theirs


def main() -> int:
    """Compare all of them, two at a time."""
    if len(sys.argv) != 2:
        print(__doc__)
        return 2
    lines, other = command_lines(), str(Path(sys.argv[1]).absolute())
    with ThreadPoolExecutor(2) as pool:
        same = list(pool.map(lambda line: compared(line, other), lines))
    print(f"{sum(same)} of {len(lines)} the same")
    return 0 if all(same) else 1


if __name__ == "__main__":
    sys.exit(main())
