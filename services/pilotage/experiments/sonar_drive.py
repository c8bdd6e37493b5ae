"""MORCS-2 on its way (Li 2008): what it was told, did, counted and heard; pure.

It goes straight or turns, never both. Its figures are the thesis's own: how far odometry is off
(table 5-1 and 5-3, the plain rows), and how far the orders are (the corrected rows: in the
thesis the correction ends up as good as the orders are obeyed, and no better).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.core.angles import wrap
from pilotage.core.motion import arc
from pilotage.experiments.sonar_echoes import EchoParams, sonar_ranges

Floats = NDArray[np.float64]

TICK = 0.1
"""s between two readings of odometry and compass."""

TICKS_PER_ROUND = 2
"""Eight sonars one after the other, 25 ms each: the time of an echo from 4 m."""

PAUSE = 0.5
"""s of rest after each order, until the robot really stands (the thesis waits 0.2 s)."""

DIRECTIONS = np.deg2rad([90.0, 44.0, 12.0, -12.0, -44.0, -90.0, -144.0, 144.0])
"""Of the sonars 0 to 7 (Li 2008, 3.1)."""

RIM = 0.165
"""Radius of the robot, m."""

MOUNTS = np.stack([RIM * np.cos(DIRECTIONS), RIM * np.sin(DIRECTIONS), DIRECTIONS], axis=1)
"""Poses (8, 3) of the sonars on the rim, in base_link."""


@dataclass(frozen=True)
class Order:
    """Go `way` m, backwards if negative, or turn by `turn` rad, left if positive."""

    way: float = 0.0
    turn: float = 0.0


@dataclass(frozen=True)
class Wheels:
    """How a measure of ways and turns errs, as shares of these.

    `way`, `left`, `right`: the same in all runs; `way_of_run`, `turn_of_run`: standard
    deviations, drawn for a run; `way_of_order`: drawn for an order (slip as it starts and stops).
    `curve`: rad per metre; walks as in DisplacementNoise.
    """

    way: float
    left: float
    right: float
    way_of_run: float
    turn_of_run: float
    way_of_order: float
    curve: float = 0.0
    way_walk: float = 0.003
    turn_walk: float = 0.005
    drift_walk: float = 0.003

    def drawn(self, order: Order, shares: Floats, rng: np.random.Generator) -> "Scales":
        """Return by how much this order's ways and turns are off in a run with these shares."""
        side = self.left if order.turn > 0.0 else self.right
        slip = self.way_of_order * float(rng.standard_normal())
        return Scales(
            self.way + self.way_of_run * float(shares[0]) + slip,
            side + self.turn_of_run * float(shares[1]),
        )


@dataclass(frozen=True)
class Scales:
    """By which share ways and turns are too long."""

    way: float
    turn: float


@dataclass(frozen=True)
class Morcs2:
    """The robot's parts."""

    odometry: Wheels = field(
        default_factory=lambda: Wheels(
            way=0.048,
            left=-0.058,
            right=-0.085,
            way_of_run=0.008,
            turn_of_run=0.01,
            way_of_order=0.005,
            curve=0.004,
        )
    )
    """176 mm along and 25 mm across in 3.67 m; 5.25 degrees in a quarter turn left, 7.67 right."""
    obedience: Wheels = field(
        default_factory=lambda: Wheels(
            way=0.0,
            left=0.0,
            right=0.0,
            way_of_run=0.008,
            turn_of_run=0.015,
            way_of_order=0.003,
        )
    )
    """How the robot carries orders out: 43 mm in 3.64 m; turns to 1.5 %."""
    speed: float = 0.2
    """m/s."""
    turn_speed: float = 0.6
    """rad/s."""
    lag: float = 0.1
    """Time constant in s with which it takes a speed on."""
    compass_sigma: float = float(np.deg2rad(2.0))
    """rad, of one reading."""
    compass_deviation: float = float(np.deg2rad(1.0))
    """rad, by the robot's own iron: a sine of the heading, its phase drawn for a run."""
    echoes: EchoParams = field(default_factory=EchoParams)


@dataclass(frozen=True, eq=False)
class SonarDrive:
    """A run of n ticks and k sonar rounds.

    `truth` (n + 1, 3) in the map, the first before the first tick; `counted` (n, 3) increments of
    odometry; `orders` (n, 2) m/s and rad/s; `yaws` (n,) of the compass; `is_turning` (n,);
    `rounds` (k,) the ticks at whose end sonars were read, `ranges` (k, 8) what they said.
    """

    truth: Floats
    counted: Floats
    orders: Floats
    yaws: Floats
    is_turning: NDArray[np.bool_]
    rounds: NDArray[np.int64]
    ranges: Floats


def drive(
    walls: Floats, start: Floats, orders: Sequence[Order], robot: Morcs2, rng: np.random.Generator
) -> SonarDrive:
    """Return what happens when the robot at `start` (3,) carries out the orders among walls."""
    ticks = list(_ticks(orders, robot, rng))
    truth = [np.asarray(start, float)]
    for tick in ticks:
        truth.append(se2.compose(truth[-1], tick.moved))
    path = np.array(truth)
    rounds = np.arange(TICKS_PER_ROUND - 1, len(ticks), TICKS_PER_ROUND)
    sonars = se2.compose(path[rounds + 1][:, None], MOUNTS[None]).reshape(-1, 3)
    ranges = sonar_ranges(walls, sonars, robot.echoes, rng)
    return SonarDrive(
        truth=path,
        counted=np.array([tick.counted for tick in ticks]),
        orders=np.array([tick.ordered for tick in ticks]),
        yaws=_yaws(path[1:, 2], robot, rng),
        is_turning=np.array([tick.is_turning for tick in ticks]),
        rounds=rounds,
        ranges=ranges.reshape(len(rounds), len(MOUNTS)),
    )


@dataclass(frozen=True, eq=False)
class _Tick:
    ordered: tuple[float, float]
    moved: Floats
    counted: Floats
    is_turning: bool


def _ticks(orders: Sequence[Order], robot: Morcs2, rng: np.random.Generator) -> Iterator[_Tick]:
    """Yield what happens in each tick."""
    of_odometry, of_obedience = rng.standard_normal((2, 2))
    for order in orders:
        counting = robot.odometry.drawn(order, of_odometry, rng)
        obeying = robot.obedience.drawn(order, of_obedience, rng)
        speed = np.zeros(2)
        for ordered in _speeds(order, robot):
            speed = ordered + (speed - ordered) * np.exp(-TICK / robot.lag)
            meant = speed * TICK
            did = _off(meant, obeying, robot.obedience, rng)
            seen = _off(did, counting, robot.odometry, rng)
            moved, counted = (arc(np.zeros(3), one[0], one[1], 1.0) for one in (did, seen))
            told = float(ordered[0]), float(ordered[1])
            yield _Tick(told, moved, counted, order.turn != 0.0)


def _speeds(order: Order, robot: Morcs2) -> Iterator[Floats]:
    """Yield the speeds (2,) ordered in each tick, and then rest."""
    seconds = abs(order.way) / robot.speed + abs(order.turn) / robot.turn_speed
    whole = np.array([order.way, order.turn]) / seconds
    full, rest = divmod(seconds, TICK)
    for _ in range(int(full)):
        yield whole
    yield whole * rest / TICK
    for _ in range(round(PAUSE / TICK)):
        yield np.zeros(2)


def _off(motion: Floats, scales: Scales, wheels: Wheels, rng: np.random.Generator) -> Floats:
    """Return way and turn (2,) as they come out with all their errors."""
    way, turn = (float(value) for value in motion)
    noise = rng.standard_normal(3)
    far = way * (1.0 + scales.way) + wheels.way_walk * np.sqrt(abs(way)) * noise[0]
    about = turn * (1.0 + scales.turn) + wheels.curve * way
    about += wheels.turn_walk * np.sqrt(abs(turn)) * noise[1]
    about += wheels.drift_walk * np.sqrt(abs(way)) * noise[2]
    return np.array([far, about])


def _yaws(thetas: Floats, robot: Morcs2, rng: np.random.Generator) -> Floats:
    """Return what the compass shows; nobody told it where the map's x axis points."""
    north, phase = rng.uniform(-np.pi, np.pi, 2)
    own_iron = robot.compass_deviation * np.sin(thetas + phase)
    noise = robot.compass_sigma * rng.standard_normal(len(thetas))
    return wrap(thetas - north + own_iron + noise)
