"""Progress of a search, shown when it takes longer than a couple of seconds."""

from __future__ import annotations

import sys
from dataclasses import dataclass, field
from typing import TextIO

from acalx.search.account import Account

__all__ = ["Progress"]

_QUIET_SECONDS = 2.0


@dataclass
class Progress:
    """Writes a line about a running search: on a terminal in place, elsewhere now and then.

    The time left is what it takes to use all starts or restarts; most searches end earlier.
    """

    stream: TextIO = field(default_factory=lambda: sys.stderr)
    shown: float = 0.0
    width: int = 0

    def __call__(self, account: Account) -> None:
        """Show the account if it is time to."""
        seconds = account.seconds
        terminal = self.stream.isatty()
        if seconds < _QUIET_SECONDS or (self.shown and seconds - self.shown < (0.3 if terminal else 10.0)):
            return
        self.shown = seconds
        found = f"best loss {'none yet' if account.best is None else f'{account.best.loss:.6f}'}"
        if account.front is not None:
            found = f"{len(account.front[1])} points on the front"
        left = ""
        if account.fraction > 0:
            left = f", at most {_duration(seconds * (1 - account.fraction) / account.fraction)} left"
        text = f"{_duration(seconds)}: {found}, {account.evaluations} evaluations{left}"
        if terminal:
            self.stream.write("\r" + text.ljust(self.width))
            self.width = len(text)
        else:
            self.stream.write(text + "\n")
        self.stream.flush()

    def close(self) -> None:
        """Take the line off a terminal."""
        if self.width:
            self.stream.write("\r" + " " * self.width + "\r")
            self.stream.flush()
            self.width = 0


def _duration(seconds: float) -> str:
    if seconds < 90:
        return f"{seconds:.0f} s"
    minutes = seconds / 60
    return f"{minutes:.0f} min" if minutes < 90 else f"{minutes / 60:.1f} h"
