"""What the readers of line formats share: a table of parsers, and checked numbers."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from pilotage.core.angles import wrap
from pilotage.core.logs.records import Pose, Record

FARTHEST_POSE = 1e7
"""No robot is farther from its start than a quarter of the equator, m: the line is damaged."""

Parser = Callable[[list[bytes]], Record]
"""Takes the words of a line; raises ValueError, saying what is wrong, if it is damaged."""


@dataclass(frozen=True)
class LineFormat:
    """A format whose lines begin with a word that says what they hold."""

    name: str
    parsers: Mapping[bytes, Parser]
    alternatives: tuple[bytes, ...] = ()
    """Words for one measurement in several shapes; only the first that a log has is read."""

    def parsers_for(self, present: set[bytes]) -> dict[bytes, Parser]:
        """Return the parsers of a log in which these words occur."""
        unused = [word for word in self.alternatives if word in present][1:]
        return {word: parse for word, parse in self.parsers.items() if word not in unused}


def numbers(words: list[bytes], first: int, count: int) -> list[float]:
    """Return `count` finite numbers from word `first` on; ValueError if there are fewer."""
    if len(words) < first + count:
        raise ValueError("too few values")
    values = list(map(float, words[first : first + count]))
    if not math.isfinite(sum(values)):
        raise ValueError("values that are not finite")
    return values


def pose_of(x: float, y: float, theta: float) -> Pose:
    """Return a pose with its heading wrapped; ValueError if it is impossibly far away."""
    if max(abs(x), abs(y)) > FARTHEST_POSE:
        raise ValueError("a pose that is impossibly far away")
    return x, y, wrap(theta)
