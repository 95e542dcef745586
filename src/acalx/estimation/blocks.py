"""Sums over short blocks of a recording: what static intervals are found from and made of."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from acalx.numerics.arrays import Array

__all__ = ["Blocks", "Interval", "Run"]


@dataclass(frozen=True, eq=False)
class Interval:
    """A static interval: its time, and mean and standard deviation of the samples of each axis.

    Parameters
    ----------
    start_s, end_s : float
    count : int
        Number of samples.
    mean, deviation : array (3,)
    """

    start_s: float
    end_s: float
    count: int
    mean: Array
    deviation: Array


@dataclass(frozen=True, eq=False)
class Blocks:
    """Successive blocks of as many samples: their times, means and sums of squared deviations.

    Parameters
    ----------
    start_s, end_s : array (b,)
    mean, squares : array (b, 3)
    """

    start_s: Array
    end_s: Array
    mean: Array
    squares: Array

    @classmethod
    def of(cls, times: Array, samples: Array) -> Blocks:
        """From times (b, size) and samples (b, size, 3)."""
        mean = samples.mean(axis=1)
        return cls(times[:, 0], times[:, -1], mean, ((samples - mean[:, None]) ** 2).sum(axis=1))

    def __len__(self) -> int:
        return len(self.mean)

    def part(self, part: slice) -> Blocks:
        """The blocks of a slice, such as those that a window is centered on."""
        return Blocks(self.start_s[part], self.end_s[part], self.mean[part], self.squares[part])

    def followed_by(self, other: Blocks) -> Blocks:
        """These blocks with later ones of the same recording behind them."""
        pairs = ((getattr(self, name), getattr(other, name)) for name in ("start_s", "end_s", "mean", "squares"))
        return Blocks(*(np.concatenate(pair) for pair in pairs))

    def variance(self, size: int, width: int) -> Array:
        """Variance of the samples over every `width` successive blocks of `size`, summed over the axes."""
        views = np.lib.stride_tricks.sliding_window_view
        means = views(self.mean, width, axis=0)
        inside = views(self.squares, width, axis=0).sum(axis=-1)
        between = size * ((means - means.mean(axis=-1, keepdims=True)) ** 2).sum(axis=-1)
        return np.asarray((inside + between).sum(axis=-1) / (size * width))


class Run:
    """Sums over a run of quiet blocks without its first and its last."""

    def __init__(self, size: int) -> None:
        self.size = size
        self._clear()

    def _clear(self) -> None:
        self.count, self.mean, self.squares = 0, np.zeros(3), np.zeros(3)
        self.start_s = self.end_s = 0.0
        self.last: Blocks | None = None
        self.begun = False

    def extend(self, blocks: Blocks) -> None:
        """Add the sums of blocks that come next and are quiet too."""
        if not self.begun:
            self.begun = True
            blocks = blocks.part(slice(1, None))
        if len(blocks) == 0:
            return
        whole = blocks if self.last is None else self.last.followed_by(blocks)
        self._add(whole.part(slice(None, -1)))
        self.last = whole.part(slice(-1, None))

    def _add(self, blocks: Blocks) -> None:
        m = len(blocks)
        if m == 0:
            return
        if self.count == 0:
            self.start_s = float(blocks.start_s[0])
        self.end_s = float(blocks.end_s[-1])
        mean = blocks.mean.mean(axis=0)
        squares = blocks.squares.sum(axis=0) + self.size * ((blocks.mean - mean) ** 2).sum(axis=0)
        count, total = m * self.size, self.count + m * self.size
        shift = mean - self.mean
        self.squares = self.squares + squares + shift**2 * (self.count * count / total)
        self.mean = self.mean + shift * (count / total)
        self.count = total

    def close(self) -> Interval | None:
        """The interval, if there is anything in it, and a new beginning."""
        count, mean, squares, start_s, end_s = self.count, self.mean, self.squares, self.start_s, self.end_s
        self._clear()
        if count == 0:
            return None
        return Interval(start_s, end_s, count, mean, np.sqrt(squares / (count - 1)))
