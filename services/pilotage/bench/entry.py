"""One measured line of the benchmark."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Literal

import numpy as np


@dataclass(frozen=True)
class Size:
    """How much work: so many `states` or `particles`, and `beams` each is weighed by.

    Of a map, so many `cells`, and `beams` of a scan; or so many `lines` found in a scan.
    """

    count: int
    beams: int
    kind: Literal["states", "particles", "cells", "lines"] = "states"


@dataclass(frozen=True)
class Entry:
    """Processor time in ms of the product and of its plain twin.

    `reference_cpu_ms` is for the whole: what the twin took on `reference_fraction` of the work,
    divided by that. `extra` are further figures, by name and unit.
    """

    name: str
    size: Size
    cpu_ms: float
    reference_cpu_ms: float
    reference_fraction: float
    extra: dict[str, float] = field(default_factory=dict)

    def as_json(self) -> dict[str, object]:
        """Return the entry as it stands in the file."""
        return {
            "name": self.name,
            self.size.kind: self.size.count,
            "beams": self.size.beams,
            "cpu_ms": self.cpu_ms,
            "reference_cpu_ms": self.reference_cpu_ms,
            "reference_fraction": self.reference_fraction,
            **self.extra,
        }


@dataclass(frozen=True)
class Stopwatch:
    """Measures processor time by `clock` [s], which is handed in: here is no clock."""

    clock: Callable[[], float]

    def ms(self, work: Callable[[], object]) -> float:
        """Return what one call takes [ms]."""
        begun = self.clock()
        work()
        return (self.clock() - begun) * 1e3

    def median_ms(
        self, work: Callable[[], object], runs: int, prepare: Callable[[], object] | None = None
    ) -> float:
        """Return the median of some calls [ms] after one that is not counted (compiling, caches).

        `prepare` is called before each and not counted either.
        """
        spent = []
        for _ in range(runs + 1):
            if prepare is not None:
                prepare()
            spent.append(self.ms(work))
        return float(np.median(spent[1:]))
