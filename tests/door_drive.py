"""A robot carried through a simulated building: which of its doors are seen, and how exactly."""

from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.core.angles import wrap
from pilotage.robot.simulator.people import People
from pilotage.robot.simulator.picture import Painter
from pilotage.robot.simulator.picture_params import PictureParams
from pilotage.robot.simulator.range_sensors import LaserParams, Surroundings, scan
from pilotage.robot.simulator.walls import Walls
from pilotage.robot.vertical_edges import vertical_edges
from pilotage.topology.features import KINDS, Features
from pilotage.topology.seeing.door_edges import SeenEdges
from pilotage.topology.seeing.scan_view import ScanView
from pilotage.topology.seeing.seen_doors import seen_doors

DOOR = KINDS.index("door")
MOUNT = np.array([0.05, 0.0, 0.0])
LASER = LaserParams()
FIELD_OF_VIEW = float(np.deg2rad(60.0))
NEAR_M, WIDTH_M = 0.3, 0.3
"""A door is right if its middle and its width are this near to those of one of the world."""
REACH_M, WITHIN = 4.0, float(np.deg2rad(123.0))
"""A door must be seen if both jambs are, this near and not at the edge of the laser's view."""


@dataclass
class Account:
    """What was counted. `errors`, `squares`: of widths, m, and of middles along walls, in sigma."""

    right: int = 0
    wrong: int = 0
    in_view: int = 0
    seen: int = 0
    in_picture: int = 0
    seen_there: int = 0
    ever_in_view: set[int] = field(default_factory=set)
    ever_seen: set[int] = field(default_factory=set)
    width_errors: list[float] = field(default_factory=list)
    squares: list[float] = field(default_factory=list)

    @property
    def precision(self) -> float:
        """Share of the doors reported that are there."""
        return self.right / max(self.right + self.wrong, 1)

    @property
    def recall(self) -> float:
        """Share of the doors in view that were reported, scan by scan."""
        return self.seen / max(self.in_view, 1)

    @property
    def recall_in_picture(self) -> float:
        """The same of doors that lie in the camera's picture."""
        return self.seen_there / max(self.in_picture, 1)


class Carried:
    """A robot with laser and camera among people in a world with doors."""

    def __init__(self, walls: Walls, people: int, *, has_camera: bool, seed: int = 1) -> None:
        self.walls = walls
        self.rng = np.random.default_rng(seed)
        self.people = People(walls, people, self.rng)
        self.painter = Painter(PictureParams(), FIELD_OF_VIEW) if has_camera else None
        self.jambs = walls.doors.jambs
        self.middles = self.jambs.mean(axis=1)
        self.widths = np.hypot(*(self.jambs[:, 1] - self.jambs[:, 0]).T)

    def account(self, poses: Iterable[NDArray[np.float64]]) -> Account:
        """Look about at each of the poses."""
        account = Account()
        for pose in poses:
            self.people.walk(pose, 0.5, self.rng)
            around = Surroundings(self.walls, self.people.discs)
            self._compare(account, self._look(around, pose).moved(pose), (around, pose))
        return account

    def _look(self, around: Surroundings, pose: NDArray[np.float64]) -> Features:
        bearings = LASER.bearings
        angles = float(bearings[0]), float(bearings[1] - bearings[0])
        view = ScanView.of(scan(around, pose, LASER, self.rng), angles, MOUNT)
        if self.painter is None:
            return seen_doors(view)
        picture = self.painter.picture(around, se2.compose(pose, MOUNT), self.rng)
        found = vertical_edges(picture, self.painter.lens)
        return seen_doors(view, SeenEdges.of(MOUNT, found.bearings, found.sigma))

    def _compare(
        self,
        account: Account,
        found: Features,
        place: tuple[Surroundings, NDArray[np.float64]],
    ) -> None:
        doors = found.chosen(found.kinds == DOOR)
        hits = [self._which(doors, i) for i in range(len(doors))]
        account.right += sum(hit is not None for hit in hits)
        account.wrong += sum(hit is None for hit in hits)
        for i, hit in enumerate(hits):
            if hit is not None:
                self._measure(account, doors.chosen(np.array([i])), hit)
        for number in range(len(self.jambs)):
            is_in_view, is_in_picture = self._in_view(number, *place)
            account.in_view += is_in_view
            account.seen += is_in_view and number in hits
            account.in_picture += is_in_picture
            account.seen_there += is_in_picture and number in hits
            account.ever_in_view |= {number} if is_in_view else set()
        account.ever_seen |= {hit for hit in hits if hit is not None}

    def _which(self, doors: Features, i: int) -> int | None:
        """Which door of the world one of the reported is."""
        off = np.hypot(*(self.middles - doors.poses[i, :2]).T)
        nearest = int(np.argmin(off))
        fits = abs(self.widths[nearest] - doors.widths[i]) < WIDTH_M
        return nearest if off[nearest] < NEAR_M and fits else None

    def _measure(self, account: Account, door: Features, which: int) -> None:
        account.width_errors.append(float(door.widths[0] - self.widths[which]))
        heading = float(door.poses[0, 2])
        along = np.array([-np.sin(heading), np.cos(heading)])
        off = float((self.middles[which] - door.poses[0, :2]) @ along)
        account.squares.append(off**2 / float(along @ door.covariances[0] @ along))

    def _in_view(
        self, number: int, around: Surroundings, pose: NDArray[np.float64]
    ) -> tuple[bool, bool]:
        """Say whether the laser sees both jambs, and whether they lie in the picture, too."""
        sensor = se2.compose(pose, MOUNT)
        offset = self.jambs[number] - sensor[:2]
        distances = np.hypot(*offset.T)
        bearings = wrap(np.arctan2(offset[:, 1], offset[:, 0]) - sensor[2])
        is_free = around.ranges(sensor, bearings, REACH_M + 1.0) >= distances - 0.25
        near = (distances < REACH_M).all() and (np.abs(bearings) < WITHIN).all()
        is_in_view = bool(is_free.all() and near)
        is_ahead = bool((np.abs(bearings) < FIELD_OF_VIEW / 2.0 - 0.02).all())
        return is_in_view, is_in_view and is_ahead
