"""Messages as what the mathematics takes, and what it makes as messages."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pilotage.core import se2
from pilotage.core.angles import wrap
from pilotage.core.grid import GridGeometry, OccupancyMap
from pilotage.core.laser_view import View
from pilotage.planner.active_localization import Decision, Look
from pilotage.planner.knowledge import Estimate, PastBelief
from pilotage.planner.mission import Target
from pilotage.planner.obstacle_view import echo_view
from pilotage.planner.robot_facts import RobotBuild, RobotSaid, radius_of
from pilotage.planner.sight import Potential
from pilotage.planner.situation import Hypotheses, Speeds
from pilotage_schemas.geometry import Pose2, Twist2
from pilotage_schemas.localization import Belief, PoseEstimate
from pilotage_schemas.mapping import OccupancyGrid
from pilotage_schemas.planning import (
    ActivePlan,
    Candidate,
    GazeCommand,
    Goal,
    Path,
    PotentialField,
    VelocityCommand,
)
from pilotage_schemas.sensors import LaserScan, RobotDescription, RobotStatus, SonarScan

BESIDE = 0.75
"""m within which a look is as good as the better one beside it."""
MOST_SHOWN = 200
SAME_PLACE = 1.0
"""m within which a place of the planner is one of the localizer's."""
LEAST_TOLD = 0.02
"""bit: what tells less tells nothing."""


def pose_of(pose: ArrayLike) -> Pose2:
    """Return a pose (3,) as a message part."""
    x, y, theta = (float(value) for value in np.asarray(pose, float))
    return Pose2(x=x, y=y, theta=theta if abs(theta) <= np.pi else float(wrap(theta)))


def pose_array(pose: Pose2) -> NDArray[np.float64]:
    """Return a message part as a pose (3,)."""
    return np.array([pose.x, pose.y, pose.theta])


def world_of(grid: OccupancyGrid) -> OccupancyMap:
    """Return a map message as a map."""
    rows, cols = grid.cells.shape
    origin = (grid.origin.x, grid.origin.y, grid.origin.theta)
    return OccupancyMap(GridGeometry(rows, cols, grid.resolution, origin), grid.cells)


def build_of(description: RobotDescription) -> RobotBuild:
    """Return how a robot is built."""
    return RobotBuild(
        name=description.name or "the robot",
        radius=radius_of(description.footprint),
        max_linear=description.max_linear,
        max_angular=description.max_angular,
        commands=frozenset(description.commands),
        lasers={m.frame_id: pose_array(m.pose) for m in description.mounts if m.kind == "laser"},
    )


def said_by(status: RobotStatus) -> RobotSaid:
    """Return what a robot says of itself."""
    is_log = status.source == "replay"
    return RobotSaid(is_log, status.orders, status.is_held, status.reason)


def laser_view(scan: LaserScan, mount: NDArray[np.float64]) -> View | None:
    """Return what a laser at `mount` (3,) sees; None of a scan without beams to speak of."""
    if len(scan.ranges) < 2 or scan.angle_increment == 0.0:
        return None
    bearings = scan.angle_min + scan.angle_increment * np.arange(len(scan.ranges))
    ranges = np.where(scan.ranges > scan.range_min, scan.ranges, np.inf)
    return View.of(ranges, bearings, mount)


def sonar_view(sonar: SonarScan) -> View | None:
    """Return what a sonar ring sees; None of a ring without sonars."""
    if len(sonar.mounts) == 0:
        return None
    ranges = np.where(sonar.ranges < sonar.range_max, sonar.ranges, np.inf)
    return echo_view(ranges, sonar.mounts, sonar.cone)


def estimate_of(message: PoseEstimate) -> Estimate:
    """Return what the localizer thinks best."""
    return Estimate(message.stamp_ns, pose_array(message.pose), message.state)


def belief_of(message: Belief) -> PastBelief | None:
    """Return where the robot could be; None if the belief says nothing."""
    samples = message.samples.astype(float)
    weights = np.maximum(samples[:, 3], 0.0)
    if not 0.0 < weights.sum() < np.inf:
        return None
    poses = samples[:, :3].copy()
    poses[:, 2] = wrap(poses[:, 2])
    hypotheses = Hypotheses(poses, weights / weights.sum())
    return PastBelief(message.stamp_ns, message.map_id, hypotheses)


def velocity_message(speeds: Speeds, stamp_ns: int, orders: int, then: str) -> VelocityCommand:
    """Return the wanted speeds, and what follows them."""
    return VelocityCommand.model_validate(
        {
            "stamp_ns": stamp_ns,
            "frame_id": "base_link",
            "twist": Twist2(vx=float(speeds[0]), vy=0.0, omega=float(speeds[1])),
            "orders": orders,
            "then": then,
        }
    )


def gaze_message(pan: float, stamp_ns: int) -> GazeCommand:
    """Return where the camera shall point [rad]."""
    return GazeCommand(stamp_ns=stamp_ns, frame_id="base_link", pan=pan)


def goal_message(target: Target, stamp_ns: int) -> Goal:
    """Return where the robot goes."""
    return Goal(
        stamp_ns=stamp_ns,
        frame_id="map",
        pose=pose_of(target.pose),
        position_tolerance=target.position_tolerance,
        heading_tolerance=target.heading_tolerance,
    )


def path_message(points_map: NDArray[np.float64], stamp_ns: int) -> Path:
    """Return a way through points (n, 2), each with the direction that it is left in."""
    points = np.asarray(points_map, float).reshape(-1, 2)
    steps = np.diff(points, axis=0)
    headings = np.arctan2(steps[:, 1], steps[:, 0])
    headings = np.concatenate([headings, headings[-1:] if len(headings) else np.zeros(len(points))])
    poses = np.column_stack([points, headings]).astype(np.float32)
    return Path(stamp_ns=stamp_ns, frame_id="map", poses=poses)


def plan_message(decision: Decision, places: NDArray[np.float64], stamp_ns: int) -> ActivePlan:
    """Return a decision as the page shows it; `places` (k, 2): the belief's, in its order."""
    best = decision.places.best
    looks = _spread(decision.looks)[:MOST_SHOWN]
    seen = se2.transform_points(best, np.array([look.point for look in looks]))
    heading = best[2] if decision.heading is None else best[2] + decision.heading
    return ActivePlan(
        stamp_ns=stamp_ns,
        frame_id="map",
        candidates=tuple(
            Candidate(
                pose=pose_of([*point, heading if i == 0 else best[2]]),
                expected_gain=look.gain,
                travel=look.travel,
                kind=look.kind,
            )
            for i, (look, point) in enumerate(zip(looks, seen, strict=True))
        ),
        reason=sentence(decision, places),
    )


def _spread(looks: Sequence[Look]) -> list[Look]:
    """Return the looks, best first, without those right beside a better one: the same to watch."""
    kept: list[Look] = []
    for look in looks:
        if all(np.hypot(*(look.point - other.point)) >= BESIDE for other in kept):
            kept.append(look)
    return kept


def no_plan(stamp_ns: int) -> ActivePlan:
    """Return that nothing is looked for."""
    return ActivePlan(stamp_ns=stamp_ns, frame_id="map", candidates=(), reason="")


def potential_message(potential: Potential, stamp_ns: int) -> PotentialField:
    """Return the environment potential of a map."""
    geometry = potential.geometry
    return PotentialField(
        stamp_ns=stamp_ns,
        frame_id="map",
        resolution=geometry.resolution,
        origin=pose_of(geometry.origin),
        potential=np.ascontiguousarray(potential.bits, np.float32),
    )


def sentence(decision: Decision, places: NDArray[np.float64]) -> str:
    """Say why the first look was chosen, the places numbered as the belief numbers them."""
    numbers = [_number(decision.places.poses[i, :2], places) for i in decision.told_apart]
    if decision.looks[0].gain < LEAST_TOLD:
        return "Nothing near tells the places apart: goes where more can be seen"
    if None in numbers or numbers[0] == numbers[1]:
        return "Would show more than is seen from here"
    one, other = sorted(number for number in numbers if number is not None)
    return f"Would tell place {one} from place {other}"


def _number(point: NDArray[np.float64], places: NDArray[np.float64]) -> int | None:
    """Return the number, from 1, of the place nearest to a point; None if none is near."""
    if len(places) == 0:
        return None
    distances = np.hypot(*(places - point).T)
    nearest = int(np.argmin(distances))
    return nearest + 1 if distances[nearest] < SAME_PLACE else None
