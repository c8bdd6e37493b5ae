"""Places followed from scan to scan, each with its probability.

The belief over all states proposes places; a grid of 0.10 m and 5 degrees cannot tell like ones
apart. Each place that it proposes is followed from then on as a pose between the cells: moved by
odometry, refined on every scan, and weighed by it (`evidence`), each surface counting less
the oftener it was seen (`novelty`). That is Wu & Bell's M2 (eq. 8) over places instead of states:
the floor keeps any place from becoming impossible.

A place that is proposed late is held against the last scans first, backwards along odometry, so
that it competes on equal terms.
"""

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, fields, replace

import numpy as np
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.localizer.evidence import Weighed, chosen_beams, weigh
from pilotage.localizer.measurement import Beams
from pilotage.localizer.novelty import SeenSurfaces
from pilotage.localizer.obstacles import Obstacles
from pilotage.localizer.places import (
    CORRELATED,
    KEPT_SCANS,
    SAME_TURN,
    SAME_WAY,
    Places,
    apart_from,
    near,
)

FLOOR = -25.0
"""No place falls farther below the best one [nat]: what a change of place has to make good."""

LATE, LATE_IN_NEED = -10.0, -6.0
"""Log-probability [nat] that the robot was carried to a new place; and while the best place is not
supported either."""

HARDLY_WORSE = -0.5
"""A place that is worse than the best by more [nat] at every look is not taken up."""

IN_NEED, NEED_SCANS = -0.6, 3
"""Evidence [nat] of so many last scans that contradicts a place."""

HOPELESS = 16.0
"""A place with so much less evidence [nat] from the last scans is no longer followed ..."""

MOST_PLACES = 150
"""... nor are more than this."""

MOST_NEW = 40
"""Proposed places that are held against the last scans: those that this one says most for."""

SLIPPED_WAY, SLIPPED_TURN = 1.5, 0.4
"""A place may have slipped so far [m, rad] from where the robot is."""

SLIPPED = -3.0
"""Log-probability [nat] of that: wheels do not often slip so far."""

USUAL_BEAMS = 100.0
"""Beams for which the usual fit stands in where little was new."""

MISFIT = 0.2
"""A scan whose beams fit a place by so much less [nat] than usual may need a longer search ..."""

MOST_SOUGHT = 8
"""... at this many of the likeliest places ..."""

BETTER = 0.02
"""... which has to be so much better [nat a beam] to be believed ..."""

AROUND = np.array(
    [
        [x, y, turn]
        for turn in (0.0, -0.2, 0.2)
        for x in (0.0, -0.25, 0.25)
        for y in (0.0, -0.25, 0.25)
    ]
)
"""... and at these poses about them [m, rad]."""

Witness = Callable[[NDArray[np.float64]], NDArray[np.float64]]
"""What others than the laser say of poses (n, 3): log-likelihoods (n,)."""


@dataclass(frozen=True)
class Seen:
    """A scan of the last ones: where odometry put it, its beams and how new they were."""

    odom_from_base: NDArray[np.float64]
    beams: Beams
    novelty: NDArray[np.float64]
    witness: Witness | None


class Hypotheses:
    """The places that are followed, by falling probability."""

    def __init__(self, around: Obstacles) -> None:
        self.places = Places()
        self._around = around
        self._surfaces = SeenSurfaces()
        self._last: deque[Seen] = deque(maxlen=KEPT_SCANS)

    def forget(self) -> None:
        """Follow nothing."""
        self.places = Places()
        self.forget_odometry()

    def forget_odometry(self) -> None:
        """Odometry counts anew: what was seen before has no place in it."""
        self._surfaces = SeenSurfaces()
        self._last.clear()

    def follow(
        self,
        odom_from_base: NDArray[np.float64],
        beams: Beams,
        proposed: NDArray[np.float64],
        witness: Witness | None = None,
    ) -> None:
        """Move on to a scan taken at `odom_from_base` (3,), and take up proposed poses (m, 3)."""
        chosen = chosen_beams(beams)
        novelty = self._surfaces.novelty(odom_from_base, chosen)
        seen = Seen(odom_from_base, beams, novelty, witness)
        self._surfaces.keep(odom_from_base, chosen)
        if self._last and len(self.places):
            increment = se2.between(self._last[-1].odom_from_base, odom_from_base)
            moved = se2.compose(self.places.poses, increment)
            self.places.add(self._sought(moved, self._weigh(moved, seen), seen))
            self.places.log_share = self.places.log_share + self.places.recent[:, 0]
        self._last.append(seen)
        self._take_up(apart_from(proposed, self.places.poses))
        self._thin_out()
        self._normalize()

    def support(self) -> NDArray[np.float64]:
        """Return the mean evidence (n,) [nat] of a beam that saw something new of late.

        The less there was that was new, the more counts how well all beams usually fit.
        """
        return self.support_of(self.places)

    def support_of(self, places: Places) -> NDArray[np.float64]:
        """Return the support (n,) of some places."""
        new = np.array([seen.novelty.sum() for seen in reversed(self._last)])
        recent = places.recent[:, : len(new)].sum(axis=1) / CORRELATED
        support: NDArray[np.float64] = (recent + USUAL_BEAMS * places.fit) / (
            new.sum() + USUAL_BEAMS
        )
        return support

    def fit_at(self, poses: NDArray[np.float64], beams: Beams) -> Weighed:
        """Return how well a scan fits poses (n, 3), each surface counted in full."""
        return weigh(poses, beams, np.ones(len(chosen_beams(beams).ranges)), self._around)

    def _weigh(self, poses: NDArray[np.float64], seen: Seen) -> Weighed:
        """Return what a scan says of poses, and what others say of them at the same time.

        These repeat their errors too as long as nothing new is seen.
        """
        weighed = weigh(poses, seen.beams, seen.novelty, self._around)
        if seen.witness is None:
            return weighed
        word = seen.witness(weighed.poses) * float(seen.novelty.mean()) / CORRELATED
        return replace(weighed, evidence=weighed.evidence + word)

    def _sought(self, moved: NDArray[np.float64], weighed: Weighed, seen: Seen) -> Weighed:
        """Look around the likeliest places where a scan fits much worse than usual.

        Wheels slip: the right place may lie beyond what a pose is refined by.
        """
        is_poor = weighed.fit < self.places.fit - MISFIT
        for index in np.nonzero(is_poor[:MOST_SOUGHT])[0]:
            around = se2.compose(moved[index], AROUND)
            found = self._weigh(around, seen)
            best = int(np.argmax(found.fit))
            if found.fit[best] > weighed.fit[index] + BETTER:
                for part in fields(weighed):
                    getattr(weighed, part.name)[index] = getattr(found, part.name)[best]
        return weighed

    def _take_up(self, poses: NDArray[np.float64]) -> None:
        """Follow new places (m, 3) of now, with the evidence of the last scans."""
        if not len(poses):
            return
        first = self._weigh(poses, self._last[-1])
        if len(self._last) > 1:
            first = _best_of(first, MOST_NEW)
        history = [first]
        now, at = self._last[-1].odom_from_base, first.poses
        for seen in list(reversed(self._last))[1:]:
            at = se2.compose(at, se2.between(now, seen.odom_from_base))
            history.append(self._weigh(at, seen))
            at, now = history[-1].poses, seen.odom_from_base
        zeros = np.zeros(len(first.poses))
        new = Places(first.poses, zeros, np.zeros((len(zeros), KEPT_SCANS)), *[zeros] * 3)
        oldest = history[-1]
        new.met, new.fit = oldest.met, oldest.fit
        for weighed in reversed(history):
            new.add(weighed)
        if len(self.places):
            better = [index for index in range(len(new)) if self._compare(new, index)]
            new = new.chosen(np.array(better, np.int64))
        else:
            new.log_share = new.recent.sum(axis=1)
        self.places = self.places.with_others(new)

    def _compare(self, new: Places, index: int) -> bool:
        """Put a new place beside the old one that it branched off from; say if it is worth it.

        The robot may have slipped or been carried there, after the scans that speak more for the
        old place than for this one. Or it was there all along, if nothing older speaks for the old.
        """
        old, slipped = self._branch(new.poses[index])
        places, recent = self.places, new.recent[index]
        count = min(len(self._last), int(places.scans[old]))
        gains = np.cumsum(recent[:count] - places.recent[old, :count])
        since = int(np.argmax(gains))
        late = LATE_IN_NEED if self.is_in_need else LATE
        gain = gains[since] + (SLIPPED if slipped else late)
        if places.scans[old] <= len(self._last) and not slipped and gains[-1] >= gain:
            gain = gains[-1]
        else:
            recent[since + 1 :] = places.recent[old, since + 1 :]
        new.log_share[index] = places.log_share[old] + gain
        return bool(slipped or gains[since] > HARDLY_WORSE or gain == gains[-1])

    def _branch(self, pose: NDArray[np.float64]) -> tuple[int, bool]:
        """Return which old place a new one comes from, and whether by slipping."""
        places = self.places
        is_near = near(places.poses, pose, SLIPPED_WAY, SLIPPED_TURN)
        slipped = bool(is_near.any())
        share = np.where(is_near, places.log_share, -np.inf) if slipped else places.log_share
        return int(np.argmax(share)), slipped

    @property
    def is_in_need(self) -> bool:
        """Whether the likeliest place is not supported, or the last scans contradict it."""
        if not len(self.places):
            return False
        return self.is_contradicted(self.places) or bool(self.support()[0] <= 0.0)

    def is_contradicted(self, places: Places) -> bool:
        """Say whether the last scans contradict the first of some places."""
        return bool(places.recent[0, :NEED_SCANS].sum() < IN_NEED)

    def _thin_out(self) -> None:
        """Order the places by probability; drop the hopeless and what has become one."""
        order = np.argsort(-self.places.log_share, kind="stable")[: 2 * MOST_PLACES]
        places = self.places.chosen(order)
        recent = places.recent.sum(axis=1)
        least = recent.max(initial=-np.inf) - HOPELESS
        kept: list[int] = []
        for index, pose in enumerate(places.poses):
            if len(kept) == MOST_PLACES:
                break
            known = near(places.poses[kept], pose, SAME_WAY, SAME_TURN).any()
            if recent[index] >= least and not known:
                kept.append(index)
        self.places = places.chosen(np.array(kept, np.int64))

    def _normalize(self) -> None:
        share = self.places.log_share
        if len(share):
            share = np.maximum(share - share.max(), FLOOR)
            self.places.log_share = share - np.log(np.exp(share).sum())


def _best_of(weighed: Weighed, most: int) -> Weighed:
    """Return the `most` poses that a scan says most for."""
    order = np.argsort(-weighed.evidence, kind="stable")[:most]
    return Weighed(*(getattr(weighed, part.name)[order] for part in fields(weighed)))
