"""From a belief and a scan to an estimate: which place, how exactly, how surely.

The same for every method: a belief over states, or particles, proposes places; they are followed
and weighed between the cells (`hypotheses`), and what speaks for the best one becomes its
confidence. Where there is no laser scan to weigh places by, the mass of the belief must do.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.core.grid import OccupancyMap
from pilotage.core.landmark_map import LandmarkMap
from pilotage.localizer.compass import compass_likelihood
from pilotage.localizer.confidence import Signs, confidence_of, confidence_of_mass
from pilotage.localizer.dead_reckoning import reckoned, says_nothing
from pilotage.localizer.estimate import Estimate
from pilotage.localizer.evidence import ends_in_base
from pilotage.localizer.hypotheses import Hypotheses, Witness
from pilotage.localizer.landmark_model import landmark_likelihoods
from pilotage.localizer.landmark_surprise import LandmarkSurprise
from pilotage.localizer.measurement import Beams, Measurement
from pilotage.localizer.modes import Mode, apart, find_modes, is_within
from pilotage.localizer.motion_spread import MotionSpread
from pilotage.localizer.obstacles import obstacles
from pilotage.localizer.peaks import find_peaks
from pilotage.localizer.place_modes import States, modes_of, with_belief
from pilotage.localizer.places import Places
from pilotage.localizer.verdict import Verdict, VerdictParams

LEAST_BEAMS = 8
"""Fewer beams than this cannot tell places apart."""

FIRST_PLACES, MORE_PLACES = 300, 60
"""Summits of the belief that are taken up as places: of a new belief, and later."""

SEARCHED_BELOW = 0.15
"""If even the best place is supported less [nat a beam], new ones are looked for everywhere."""

YOUNG = 3
"""Scans for which a belief is new."""

DOUBT = 0.6
"""Confidence in a place that the last scans contradict, at most."""

NO_RIVAL = 1.0
"""By how much [nat a beam] a place is better than none."""

WORSE = 0.35
"""A scan whose beams speak for the place by so much less [nat] than usual is a surprise."""

SLIP = 0.2
"""Error of odometry [rad] between two scans that is no surprise."""

LITTLE_MASS, MOST_DISSENTS = 0.02, 8
"""A best place with less than this share of the belief, so many times in a row, is in dispute."""

CONFIRMED = 3
"""Measurements in a row that must agree where mass alone has to do."""

AGREE_WAY, AGREE_TURN = 0.6, 0.35
"""A place may move by so much beyond odometry [m, rad]."""


class Judge:
    """Judges beliefs by scans; `estimate` is its last word."""

    def __init__(
        self,
        world: OccupancyMap,
        params: VerdictParams | None = None,
        landmarks: LandmarkMap | None = None,
    ) -> None:
        self._landmarks = landmarks
        self._sightings = LandmarkSurprise(landmarks)
        self._around = obstacles(world)
        self._hypotheses = Hypotheses(self._around)
        self._verdict = Verdict(params or VerdictParams())
        width, height = world.geometry.size_m
        middle = se2.compose(world.geometry.origin, [width / 2.0, height / 2.0, 0.0])
        spread = np.diag([width**2 / 12.0, height**2 / 12.0, np.pi**2 / 3.0])
        self._nothing = Estimate(middle, spread, "unknown", 0.0, [], None)
        self.estimate = self._nothing
        self._odom_from_base: NDArray[np.float64] | None = None
        self._agreeing = 0
        self._judged = self._dissents = 0

    def begin(self, modes: list[Mode], *, was_localized: bool = False) -> None:
        """Begin anew with what is believed before any measurement."""
        self._hypotheses.forget()
        self._sightings.forget()
        self._verdict.begin(was_localized=was_localized)
        self._odom_from_base = None
        self._agreeing = CONFIRMED - 1 if was_localized else 0
        self._judged = self._dissents = 0
        self.estimate = self._nothing
        if modes:
            best = modes[0]
            self.estimate = Estimate(best.pose, best.covariance, "unknown", 0.0, modes, None)

    def restart_odometry(self) -> None:
        """Odometry counts from a new origin; the places stay where they are."""
        self._hypotheses.forget_odometry()
        self._odom_from_base = None

    def is_surprised(self, odom_from_base: NDArray[np.float64], seen: Measurement) -> bool:
        """Say whether all places should compete anew.

        A scan or landmarks contradict the pose where odometry puts a localized robot; or places
        and belief have contradicted each other for so long that one of them must be in a rut.
        """
        if self._dissents >= MOST_DISSENTS:
            return True
        if self.estimate.state != "localized" or self._odom_from_base is None:
            return False
        beams, expected = _telling(seen), self._expected(odom_from_base)
        if self._sightings.is_surprised(expected, self.estimate.covariance, seen.landmarks):
            return True
        if beams is None or not len(self._hypotheses.places):
            return False
        limit = min(0.0, self._hypotheses.places.fit[0] - WORSE)
        if self._hypotheses.fit_at(expected[None], beams).fit[0] >= limit:
            return False
        # Wheels slip: the robot may only have turned more or less than they said.
        turned = expected + np.array([[0.0, 0.0, -SLIP], [0.0, 0.0, SLIP]])
        return bool(self._hypotheses.fit_at(turned, beams).fit.max() < limit)

    @property
    def is_searching(self) -> bool:
        """Whether the robot may well be elsewhere than at all places that are followed."""
        if not len(self._hypotheses.places):
            return False
        if self.estimate.state == "localized":
            return self._hypotheses.is_in_need
        return bool(self._hypotheses.support()[0] < SEARCHED_BELOW)

    def judge(
        self,
        odom_from_base: NDArray[np.float64],
        states: States,
        seen: Measurement,
        *,
        surprise: bool,
    ) -> Estimate:
        """Return the estimate after a measurement.

        Args:
            odom_from_base: (3,) at the measurement.
            states: the heaviest of the belief, poses (n, 3) and their shares (n,) of it.
            seen: the measurement.
            surprise: whether it contradicts what was believed.
        """
        if says_nothing(seen):
            return self._move_on(odom_from_base)
        if surprise or self.estimate.state != "localized":
            self._sightings.forget()
        else:
            expected = self._expected(odom_from_base)
            self._sightings.note(expected, self.estimate.covariance, seen.landmarks)
        beams = _telling(seen)
        if beams is None:
            self.estimate = self._by_mass(odom_from_base, states, surprise=surprise)
        else:
            self._follow(odom_from_base, states, seen, surprise=surprise)
            self.estimate = self._by_places(odom_from_base, states, beams, surprise=surprise)
        self._odom_from_base = odom_from_base.copy()
        self._judged += 1
        return self.estimate

    def _move_on(self, odom_from_base: NDArray[np.float64]) -> Estimate:
        """Return the last estimate moved on; odometry alone makes nobody localized."""
        here = self._odom_from_base
        increment = np.zeros(3) if here is None else se2.between(here, odom_from_base)
        self.estimate = moved = reckoned(self.estimate, increment, MotionSpread())
        if moved.state == "localized":
            masses = [mode.mass for mode in moved.modes]
            state = self._verdict.judge(moved.confidence, masses, surprise=False)
            self.estimate = replace(moved, state=state)
        self._odom_from_base = odom_from_base.copy()
        return self.estimate

    def _follow(
        self,
        odom_from_base: NDArray[np.float64],
        states: States,
        seen: Measurement,
        *,
        surprise: bool,
    ) -> None:
        """Follow the places to this measurement; after a surprise all compete anew."""
        if surprise:
            self._hypotheses.forget()
            self._judged = self._dissents = 0
        most = FIRST_PLACES if self._judged < YOUNG or self.is_searching else MORE_PLACES
        proposed = find_peaks(*states, most)
        if surprise:
            proposed = np.concatenate([proposed, self._expected(odom_from_base)[None]])
        beams = seen.beams
        if beams is not None:
            self._hypotheses.follow(odom_from_base, beams, proposed, self._witness(seen))

    def _witness(self, seen: Measurement) -> Witness | None:
        """Return what compass and landmarks say of poses."""
        compass, sightings, known = seen.compass, seen.landmarks, self._landmarks
        if compass is None and (sightings is None or known is None):
            return None

        def words(poses: NDArray[np.float64]) -> NDArray[np.float64]:
            total = np.zeros(len(poses))
            if compass is not None:
                total += np.log(compass_likelihood(poses[:, 2], *compass))
            if sightings is not None and known is not None:
                total += landmark_likelihoods(poses, sightings, known)
            return total

        return words

    def _by_places(
        self,
        odom_from_base: NDArray[np.float64],
        states: States,
        beams: Beams,
        *,
        surprise: bool,
    ) -> Estimate:
        """Judge by the places that are followed."""
        places = self._hypotheses.places
        if not len(places):
            state = self._verdict.judge(0.0, [], surprise=surprise)
            return Estimate(self.estimate.pose, self.estimate.covariance, state, 0.0, [], None)
        places = with_belief(places, states)
        modes = modes_of(places, states, ends_in_base(beams), self._around)
        signs = self._signs(places, states)
        if self._is_held(places.poses[0], odom_from_base):
            signs = replace(signs, better=NO_RIVAL)
        dissents = signs.mass < LITTLE_MASS and signs.ahead > 0.0
        self._dissents = self._dissents + 1 if dissents else 0
        confidence = confidence_of(signs)
        if self._hypotheses.is_contradicted(places):
            confidence = min(confidence, DOUBT)
        masses = [mode.mass for mode in modes]
        state = self._verdict.judge(confidence, masses, surprise=surprise)
        self._agreeing = CONFIRMED if state == "localized" else 0
        best = modes[0]
        return Estimate(
            best.pose, best.covariance, state, confidence, modes, float(places.met[0]), signs
        )

    def _is_held(self, pose: NDArray[np.float64], odom_from_base: NDArray[np.float64]) -> bool:
        """Say whether a place is the one where the robot was localized.

        It was told from its rivals then, and need not be again: a corridor may repeat itself.
        """
        if self.estimate.state != "localized":
            return False
        return bool(is_within(pose[None], self._expected(odom_from_base))[0])

    def _expected(self, odom_from_base: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the last estimated pose (3,) moved on by odometry."""
        if self._odom_from_base is None:
            return self.estimate.pose
        increment = se2.between(self._odom_from_base, odom_from_base)
        return se2.compose(self.estimate.pose, increment)

    def _signs(self, places: Places, states: States) -> Signs:
        """Return what speaks for the best place."""
        share = np.exp(places.log_share)
        elsewhere = ~is_within(places.poses, places.poses[0])
        others = share[elsewhere].sum()
        poses, weights = states
        support = self._hypotheses.support_of(places)
        rivals = support[elsewhere & (places.scans >= YOUNG)]
        return Signs(
            ahead=float(np.log(share[0]) - np.log(max(others, 1e-9))),
            support=float(support[0]),
            mass=float(weights[is_within(poses, places.poses[0])].sum()),
            better=float(support[0] - rivals.max()) if len(rivals) else NO_RIVAL,
        )

    def _by_mass(
        self,
        odom_from_base: NDArray[np.float64],
        states: States,
        *,
        surprise: bool,
    ) -> Estimate:
        """Judge by the mass of the modes, which must stay where odometry expects them."""
        modes = find_modes(*states)
        if not modes:
            state = self._verdict.judge(0.0, [], surprise=surprise)
            return Estimate(self.estimate.pose, self.estimate.covariance, state, 0.0, [], None)
        best = modes[0]
        self._agreeing = self._agreeing + 1 if self._is_steady(best, odom_from_base) else 0
        confidence = confidence_of_mass(best.mass) * min(1.0, self._agreeing / CONFIRMED)
        masses = [mode.mass for mode in modes]
        state = self._verdict.judge(confidence, masses, surprise=surprise)
        return Estimate(best.pose, best.covariance, state, confidence, modes, None)

    def _is_steady(self, best: Mode, odom_from_base: NDArray[np.float64]) -> bool:
        if self._odom_from_base is None:
            return self._agreeing > 0
        way, turn = apart(best.pose, self._expected(odom_from_base))
        return way <= AGREE_WAY and turn <= AGREE_TURN


def _telling(seen: Measurement) -> Beams | None:
    """Return the laser's beams if they are enough to tell places apart."""
    beams = seen.beams
    if beams is None or np.count_nonzero(np.isfinite(beams.ranges)) < LEAST_BEAMS:
        return None
    return beams
