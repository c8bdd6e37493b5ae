"""One scan as the search for features takes it: its ranges and the lines in them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pilotage.core.line_extraction import LineParams, extract_lines
from pilotage.core.lines import Lines


@dataclass(frozen=True)
class ScanView:
    """A scan of a laser at `mount` (3,) in base_link.

    `ranges` (n,) m, infinite or NaN without return; `angles`: bearing of the first beam and step,
    rad; `lines` in the laser's frame.
    """

    ranges: NDArray[np.float64]
    angles: tuple[float, float]
    mount: NDArray[np.float64]
    lines: Lines

    @classmethod
    def of(
        cls,
        ranges: ArrayLike,
        angles: tuple[float, float],
        mount: ArrayLike = (0.0, 0.0, 0.0),
        params: LineParams | None = None,
    ) -> "ScanView":
        """Return a scan with the lines that are found in it."""
        measured = np.asarray(ranges, float)
        lines = extract_lines(measured, angles, params or LineParams())
        return cls(measured, angles, np.asarray(mount, float), lines)

    @property
    def directions(self) -> NDArray[np.float64]:
        """Unit vectors (n, 2) of the beams in the laser's frame."""
        first, step = self.angles
        bearings = first + step * np.arange(len(self.ranges))
        return np.stack([np.cos(bearings), np.sin(bearings)], axis=1)
