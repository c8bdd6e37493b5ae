"""Features seen again and again while driving: associated, averaged and counted."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pilotage.topology.features import KINDS, Features

CORNER, PASSAGE = KINDS.index("corner"), KINDS.index("passage")


@dataclass(frozen=True)
class LandmarkParams:
    """When two sightings are of one feature, and when it is there at all."""

    corner_apart: float = 0.3
    """m up to which two corners are one."""
    opening_apart: float = 0.4
    """m along a wall, or half a width if that is more, up to which two openings are one."""
    thickest_wall: float = 0.6
    """m between the faces of a wall, on which the two sides of an opening are seen."""
    turned: float = 0.6
    """rad up to which two sightings of a feature may differ in direction."""
    width_tolerance: float = 0.5
    """m between two sightings of an opening."""
    least_sightings: int = 4
    """From different places; what is seen less often may be a person or a shadow."""
    least_passages: int = 8
    """Sightings of a passage: it is wide and seen from afar, and shadows look like one."""
    least_sigma: float = 0.02
    """m; sightings from nearby err alike, so their mean does not get better without end."""


class Landmarks:
    """All features met so far, in map; they never go away, but only those seen often count."""

    def __init__(self, params: LandmarkParams | None = None) -> None:
        self.params = params or LandmarkParams()
        self._all = Features.none()
        self._votes = np.empty((0, len(KINDS)), np.int64)

    def __len__(self) -> int:
        return len(self._all)

    @property
    def counts(self) -> NDArray[np.int64]:
        """How often each (n,) was seen."""
        counts: NDArray[np.int64] = self._votes.sum(axis=1)
        return counts

    @property
    def features(self) -> Features:
        """All of them (n), each of the kind that it was mostly seen as."""
        mine = self._all
        kinds = np.asarray(np.argmax(self._votes, axis=1), np.int64) if len(self) else mine.kinds
        return Features(kinds, mine.poses, mine.widths, mine.covariances)

    @property
    def is_certain(self) -> NDArray[np.bool_]:
        """Say which (n,) were seen often enough, and are not another one again."""
        is_passage = self.features.kinds == PASSAGE
        least = np.where(is_passage, self.params.least_passages, self.params.least_sightings)
        often = np.asarray(self.counts >= least, np.bool_)
        return often & ~self._shadowed(often)

    def add(self, seen: Features) -> NDArray[np.int64]:
        """Take in the features (k) of one scan, in map; return which landmark (k,) each is."""
        which = self._associated(seen)
        for index in np.flatnonzero(which >= 0):
            self._update(int(which[index]), seen, int(index))
        fresh = np.flatnonzero(which < 0)
        which[fresh] = len(self) + np.arange(len(fresh))
        new = seen.chosen(fresh)
        self._all = Features.joined([self._all, new])
        votes = np.eye(len(KINDS), dtype=np.int64)[new.kinds]
        self._votes = np.concatenate([self._votes, votes])
        return which

    def keep(self, which: NDArray[np.bool_]) -> None:
        """Forget all but those that a mask (n,) chooses."""
        self._all = self._all.chosen(which)
        self._votes = self._votes[which]

    def _associated(self, seen: Features) -> NDArray[np.int64]:
        """Return the landmark (k,) that each seen feature is, -1 if none; the nearest first."""
        which = np.full(len(seen), -1)
        apart, fits = self._alike(seen, self._all)
        # A width that nobody knows forbids nothing.
        unlike = np.abs(seen.widths[:, None] - self._all.widths[None]) > self.params.width_tolerance
        fits &= ~unlike
        apart = np.where(fits, apart, np.inf)
        while apart.size and np.isfinite(best := apart.min()):
            one, other = np.argwhere(apart == best)[0]
            which[one] = other
            apart[one, :] = apart[:, other] = np.inf
        return which

    def _alike(
        self, ones: Features, others: Features
    ) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
        """Return how far apart (k, n) two are, 1 being too far, and whether they may be the same.

        An opening may lie a wall's thickness before or behind another view of it, and aside by
        half of its width: of a wide one a part may be hidden.
        """
        params = self.params
        offset = ones.poses[:, None, :2] - others.poses[None, :, :2]
        heading = others.poses[None, :, 2]
        through = offset[..., 0] * np.cos(heading) + offset[..., 1] * np.sin(heading)
        aside = offset[..., 1] * np.cos(heading) - offset[..., 0] * np.sin(heading)
        is_corner = ones.kinds[:, None] == CORNER
        widths = np.nan_to_num(np.fmax(ones.widths[:, None], others.widths[None]))
        deep = np.where(is_corner, params.corner_apart, params.thickest_wall)
        broad = np.where(
            is_corner, params.corner_apart, np.fmax(0.5 * widths, params.opening_apart)
        )
        apart = np.hypot(through / deep, aside / broad)
        period = np.where(is_corner, 2.0 * np.pi, np.pi)
        turned = np.abs(_turn(heading, ones.poses[:, None, 2], period))
        fits = (is_corner == (others.kinds[None] == CORNER)) & (turned < params.turned)
        return apart, fits & (apart < 1.0)

    def _update(self, index: int, seen: Features, one: int) -> None:
        mine, params = self._all, self.params
        self._votes[index, seen.kinds[one]] += 1
        spread = mine.covariances[index] + params.least_sigma**2 * np.eye(2)
        gain = spread @ np.linalg.inv(spread + seen.covariances[one])
        mine.poses[index, :2] += gain @ (seen.poses[one, :2] - mine.poses[index, :2])
        mine.covariances[index] = spread - gain @ spread
        share = 1.0 / min(int(self._votes[index].sum()), 20)
        period = 2.0 * np.pi if mine.kinds[index] == CORNER else np.pi
        mine.poses[index, 2] += share * _turn(mine.poses[index, 2], seen.poses[one, 2], period)
        known = np.array([mine.widths[index], seen.widths[one]])
        if np.isfinite(known).all():
            mine.widths[index] += share * (known[1] - known[0])

    def _shadowed(self, often: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Say which (n,) are another one, seen more often, again: their means grew together."""
        features, counts = self.features, self.counts
        _, fits = self._alike(features, features)
        rank = np.lexsort((np.arange(len(counts)), -counts))
        place = np.empty(len(counts), np.int64)
        place[rank] = np.arange(len(counts))
        is_better = (place[None, :] < place[:, None]) & often[None, :]
        return np.asarray((fits & is_better).any(axis=1), np.bool_)


def _turn(
    origin: NDArray[np.float64], target: NDArray[np.float64], period: NDArray[np.float64] | float
) -> NDArray[np.float64]:
    """Return the shortest turn between directions that repeat after `period` rad."""
    turn: NDArray[np.float64] = (target - origin + period / 2.0) % period - period / 2.0
    return turn
