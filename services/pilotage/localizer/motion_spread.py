"""How odometry's uncertainty grows, gathered until it is worth a pass over the belief."""

from dataclasses import dataclass


@dataclass(frozen=True)
class MotionSpread:
    """How odometry's uncertainty grows; variances add up along the way.

    `translation`: [m per sqrt(m)] from the way; `translation_from_turn`: [m per sqrt(rad)];
    `rotation`: [rad per sqrt(rad)] from turning; `rotation_from_way`: [rad per sqrt(m)].
    """

    translation: float = 0.06
    translation_from_turn: float = 0.02
    rotation: float = 0.06
    rotation_from_way: float = 0.05

    def variances(self, way: float, turn: float) -> tuple[float, float]:
        """Return what a motion of `way` [m] and `turn` [rad], both positive, makes uncertain.

        Variances of x and y alike [m^2], and of the heading [rad^2].
        """
        along = self.translation**2 * way + self.translation_from_turn**2 * turn
        around = self.rotation**2 * turn + self.rotation_from_way**2 * way
        return along, around


LEAST_SHARE = 0.08
"""Spreading waits until each neighbour would get this share: fewer passes, the same variance."""

MOST_SHARE = 0.25


class SpreadDue:
    """Variance of cells and headings that the belief does not show yet, in steps squared."""

    def __init__(self, spread: MotionSpread, resolution: float, heading_step: float) -> None:
        self._spread = spread
        self._cell_area, self._heading_area = resolution**2, heading_step**2
        self.forget()

    def forget(self) -> None:
        """Nothing is due."""
        self.of_cells = self.of_headings = 0.0

    def add(self, way: float, turn: float) -> None:
        """Add what a motion of `way` [m] and `turn` [rad], both positive, makes uncertain."""
        along, around = self._spread.variances(way, turn)
        self.of_cells += along / self._cell_area
        self.of_headings += around / self._heading_area

    def take_cells(self) -> list[float]:
        """Return the shares of the passes over the cells that are due now."""
        shares, self.of_cells = _passes(self.of_cells)
        return shares

    def take_headings(self) -> list[float]:
        """Return the shares of the passes over the headings that are due now."""
        shares, self.of_headings = _passes(self.of_headings)
        return shares


def _passes(variance: float) -> tuple[list[float], float]:
    """Return the shares of passes that each add a variance of 2 share, and what is left."""
    shares = []
    while variance / 2.0 >= LEAST_SHARE:
        shares.append(min(variance / 2.0, MOST_SHARE))
        variance -= 2.0 * shares[-1]
    return shares, variance
