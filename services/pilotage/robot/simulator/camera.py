"""The simulated camera on a pan joint that recognises landmarks (Liu et al. 2008); pure."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pilotage.core import se2
from pilotage.core.angles import wrap
from pilotage.core.landmark_map import LandmarkMap
from pilotage.robot.simulator.parameter_checks import refuse_negative, refuse_zero
from pilotage.robot.simulator.range_sensors import Surroundings

POST_RADIUS = 0.15
"""m: a landmark in occupied cells (a post, a sign on a wall) is not hidden by what is as near."""

FACE = 1e-6
"""m: a landmark right on the face of a wall is not behind it."""


@dataclass(frozen=True)
class RecognitionParams:
    """At d m a landmark is recognised with probability 1 / (1 + exp((d - d0) / T)).

    The paper's rule for its potential (eq. 1), here what the camera does.
    """

    half_distance: float = 4.0
    """d0: where one of two is recognised, m."""
    width: float = 0.6
    """T: how gradually recognition falls around there, m."""

    def __post_init__(self) -> None:
        """Refuse what no camera has (ValueError)."""
        refuse_negative(self)
        refuse_zero(self, "half_distance", "width")

    def probability(self, distance: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return how likely landmarks at distances (n,) m are recognised."""
        steepness = np.minimum((distance - self.half_distance) / self.width, 700.0)
        recognised: NDArray[np.float64] = 1.0 / (1.0 + np.exp(steepness))
        return recognised


@dataclass(frozen=True)
class CameraParams:
    """A camera whose pan joint stands `mount_x` m ahead of the robot's centre.

    The errors are the paper's. Bearings are measured from the robot's x axis, pan included.
    """

    field_of_view: float = float(np.deg2rad(60.0))
    """Full opening angle, rad."""
    pan_limit: float = float(np.deg2rad(90.0))
    """How far the joint turns to either side, rad."""
    pan_speed: float = 2.0
    """rad/s."""
    mount_x: float = 0.05
    """m ahead of the robot's centre."""
    range_min: float = 0.1
    """Nearer landmarks are below the picture, m."""
    range_share: float = 0.1
    """Standard deviation of a range as a share of it."""
    bearing_sigma: float = float(np.deg2rad(10.0))
    """Standard deviation of a bearing, rad."""
    recognition: RecognitionParams = field(default_factory=RecognitionParams)
    """How far landmarks are recognised."""
    recognition_by_class: dict[str, RecognitionParams] = field(default_factory=dict)
    """The same of classes that differ."""
    reads_identities: bool = True
    """Whether it tells a landmark that has an identity from its likes."""
    false_sightings: float = 0.0
    """Probability that a picture shows a landmark that is not there."""

    def __post_init__(self) -> None:
        """Refuse what no camera has (ValueError)."""
        refuse_negative(self)
        refuse_zero(self, "field_of_view", "range_min", "range_share", "bearing_sigma")
        if self.field_of_view > 2.0 * np.pi:
            raise ValueError("field_of_view must be a full turn at most; it is in rad")
        if self.pan_limit > np.pi:
            raise ValueError("pan_limit must be half a turn at most; it is in rad")
        if self.false_sightings > 1.0:
            raise ValueError(f"false_sightings must be 1 at most, it is {self.false_sightings:g}")

    def recognition_of(self, kind: str) -> RecognitionParams:
        """Return how far a class is recognised."""
        return self.recognition_by_class.get(kind, self.recognition)


@dataclass(frozen=True)
class Picture:
    """What was recognised: which landmark (n,), its range m and bearing rad from the pan joint."""

    landmarks: NDArray[np.int64]
    ranges: NDArray[np.float64]
    bearings: NDArray[np.float64]


class Camera:
    """A camera in a world of landmarks; `pan` is where it points, rad off the robot's x axis."""

    def __init__(self, params: CameraParams, landmarks: LandmarkMap) -> None:
        self.params = params
        self.landmarks = landmarks
        self.pan = 0.0
        self._wanted = 0.0

    def look(self, pan: float) -> None:
        """Turn towards `pan` from now on, as far as the joint goes."""
        limit = self.params.pan_limit
        self._wanted = float(np.clip(wrap(pan), -limit, limit))

    def turn(self, dt: float) -> None:
        """Let the joint move for `dt` s."""
        step = self.params.pan_speed * dt
        self.pan += float(np.clip(self._wanted - self.pan, -step, step))

    def picture(self, around: Surroundings, pose: ArrayLike, rng: np.random.Generator) -> Picture:
        """Return what is recognised from a robot at `pose` (3,).

        As many random numbers are drawn whatever is in view, so that runs can be compared.
        """
        ranges, bearings = self._seen_from(pose)
        is_seen = self._in_view(ranges, bearings) & (rng.random(len(ranges)) < self._odds(ranges))
        noise = rng.standard_normal((2, len(ranges)))
        chosen = np.flatnonzero(is_seen & ~_hidden(around, self._joint(pose), self.landmarks))
        true = Picture(
            chosen,
            (ranges * (1.0 + self.params.range_share * noise[0]))[chosen],
            wrap(bearings + self.params.bearing_sigma * noise[1])[chosen],
        )
        return self._with_least_range(_joined(true, self._mistaken(rng)))

    def _joint(self, pose: ArrayLike) -> NDArray[np.float64]:
        return se2.compose(pose, (self.params.mount_x, 0.0, 0.0))

    def _seen_from(self, pose: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return true distances and bearings (n,) of all landmarks from the pan joint."""
        joint_from_map = se2.inverse(self._joint(pose))
        x, y = se2.transform_points(joint_from_map, self.landmarks.positions).T
        return np.hypot(x, y), np.arctan2(y, x)

    def _in_view(
        self, ranges: NDArray[np.float64], bearings: NDArray[np.float64]
    ) -> NDArray[np.bool_]:
        off = np.abs(wrap(bearings - self.pan))
        is_in: NDArray[np.bool_] = off <= self.params.field_of_view / 2.0
        return is_in & (ranges >= self.params.range_min)

    def _odds(self, ranges: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return how likely each landmark (n,) is recognised, if nothing is in the way."""
        kinds = self.landmarks.classes
        of_each = [
            self.params.recognition_of(kind).probability(ranges[i : i + 1])
            for i, kind in enumerate(kinds)
        ]
        return np.concatenate([np.empty(0), *of_each])

    def _mistaken(self, rng: np.random.Generator) -> Picture:
        """Return something that was taken for a landmark, or nothing."""
        chance, lot, aside, ahead = rng.random(4)
        if chance >= self.params.false_sightings or not self.landmarks.classes:
            return Picture(np.empty(0, np.int64), np.empty(0), np.empty(0))
        which = int(lot * len(self.landmarks.classes))
        reach = self.params.recognition_of(self.landmarks.classes[which]).half_distance
        bearing = self.pan + (aside - 0.5) * self.params.field_of_view
        return Picture(np.array([which]), np.array([ahead * reach]), np.array([wrap(bearing)]))

    def _with_least_range(self, picture: Picture) -> Picture:
        ranges = np.maximum(picture.ranges, self.params.range_min)
        return Picture(picture.landmarks, ranges, picture.bearings)


def _joined(one: Picture, other: Picture) -> Picture:
    return Picture(
        np.concatenate([one.landmarks, other.landmarks]),
        np.concatenate([one.ranges, other.ranges]),
        np.concatenate([one.bearings, other.bearings]),
    )


def _hidden(
    around: Surroundings, joint: NDArray[np.float64], landmarks: LandmarkMap
) -> NDArray[np.bool_]:
    """Say which landmarks (n,) walls or people hide from a pose (3,)."""
    offset = landmarks.positions - joint[:2]
    distances = np.hypot(offset[:, 0], offset[:, 1])
    bearings = np.arctan2(offset[:, 1], offset[:, 0]) - joint[2]
    free = around.ranges(joint, bearings, float(distances.max(initial=0.0)) + 1.0)
    slack = np.where(around.walls.is_wall_at(landmarks.positions), POST_RADIUS, FACE)
    is_hidden: NDArray[np.bool_] = free < distances - slack
    return is_hidden
