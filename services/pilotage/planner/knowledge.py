"""What has been heard of the robot, put together for this moment; pure.

A belief is older than what is planned on it: the localizer says where the robot could have been
when a scan was taken. Odometry says how it has moved since.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.core.laser_view import View
from pilotage.core.odometry_buffer import OdometryBuffer
from pilotage.core.odometry_watch import OdometrySample, restart_between
from pilotage.planner.situation import Hypotheses, Situation, State

SILENT_AFTER = {"odometry": 0.5, "view": 0.6, "pose": 1.5}
"""s of silence after which one does not drive: of the robot, of what it sees, of the localizer."""

EXTRAPOLATION_NS = 100_000_000


@dataclass(frozen=True)
class Estimate:
    """The best pose (3,) of base_link in map at a time, and what the localizer says of it."""

    stamp_ns: int
    pose: NDArray[np.float64]
    state: State


@dataclass(frozen=True)
class PastBelief:
    """Where the robot could be on map `map_id` at a time."""

    stamp_ns: int
    map_id: str
    hypotheses: Hypotheses


class Knowledge:
    """The newest of everything; times `now` are seconds of a clock that never goes backwards."""

    def __init__(self) -> None:
        self._odometry = OdometryBuffer()
        self._newest: OdometrySample | None = None
        self._estimate: Estimate | None = None
        self._belief: PastBelief | None = None
        self._view: View | None = None
        self._heard: dict[str, float] = {}

    def hear_odometry(self, sample: OdometrySample, now: float) -> None:
        """Take odometry; counted anew, it says nothing of what was before."""
        if self._newest is not None and restart_between(self._newest, sample) is not None:
            self._odometry.clear()
            self._estimate = self._belief = None
        self._newest = sample
        self._odometry.append(sample.stamp_ns, sample.pose)
        self._heard["odometry"] = now

    def hear_view(self, view: View, now: float) -> None:
        """Take what a laser or a sonar ring sees."""
        self._view = view
        self._heard["view"] = now

    def hear_estimate(self, estimate: Estimate, now: float) -> None:
        """Take the localizer's pose."""
        self._estimate = estimate
        self._heard["pose"] = now

    def hear_belief(self, belief: PastBelief) -> None:
        """Take the localizer's belief; it may be old, for one that stands learns nothing new."""
        self._belief = belief

    def forget_place(self) -> None:
        """Forget where the robot is: another map is in use."""
        self._estimate = self._belief = None

    @property
    def state(self) -> State:
        """What the localizer said last."""
        return "unknown" if self._estimate is None else self._estimate.state

    def missing(self, now: float, map_id: str) -> str | None:
        """Say in words what one would have to hear before one drives; None: nothing."""
        for name, words in (("odometry", "odometry"), ("view", "scan"), ("pose", "pose")):
            heard = self._heard.get(name)
            if heard is None:
                return f"no {words} has come yet"
            if now - heard > SILENT_AFTER[name]:
                return f"no {words} for {now - heard:.0f} s"
        if self._estimate is None or self._belief is None:
            return "nobody has said yet where the robot could be"
        if self._belief.map_id != map_id:
            return "the localizer is not on this map"
        return None if self._moved_since() is not None else "no odometry from the time of the pose"

    def situation(self, now: float, map_id: str) -> Situation | None:
        """Return what is known now; None while something is missing."""
        moved = None if self.missing(now, map_id) else self._moved_since()
        if moved is None or self._view is None or self._newest is None:
            return None
        return Situation(now, self._newest.pose, self._view, moved, self.state)

    def _moved_since(self) -> Hypotheses | None:
        """Return where the robot could be now: of a localized one the refined pose alone."""
        estimate, belief = self._estimate, self._belief
        if estimate is None or belief is None:
            return None
        if estimate.state == "localized":
            sure = Hypotheses(estimate.pose[None], np.ones(1))
            return self._moved(sure, estimate.stamp_ns)
        return self._moved(belief.hypotheses, belief.stamp_ns)

    def _moved(self, then: Hypotheses, stamp_ns: int) -> Hypotheses | None:
        latest = self._odometry.latest()
        start = self._odometry.pose_at(stamp_ns, EXTRAPOLATION_NS)
        if latest is None or start is None:
            return None
        return then.moved(se2.between(start, latest[1]))
