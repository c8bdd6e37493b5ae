"""The simulated robot's upright edges: when they come, in whose frame, and where they point."""

import subprocess
import sys
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from drawing import draw
from pilotage.robot.simulator.doors import doors_of
from pilotage.robot.simulator.picture_params import PictureParams
from pilotage.robot.simulator.simulation import RobotParams, Simulation
from pilotage.robot.simulator.simulator import Simulator
from pilotage.robot.simulator.walls import Walls
from pilotage_schemas.codec import decode, encode
from pilotage_schemas.sensors import LaserScan, VerticalEdges
from pilotage_schemas.topics import TOPICS
from robot_world import EXACT, simulation_in

START_NS, STEP_NS = 1_000_000_000_000, 20_000_000

ROOM_WITH_A_DOOR = draw(
    "\n".join(
        [
            *["#" * 120] * 4,
            *["#" * 4 + "." * 112 + "#" * 4] * 52,
            *["#" * 50 + "." * 20 + "#" * 50] * 4,
            *["#" * 4 + "." * 112 + "#" * 4] * 60,
        ]
    ),
    resolution=0.05,
)
"""Two rooms and a door between them, from x = 2.5 to 3.5 in the wall from y = 3.0 to 3.2."""
DOORS = doors_of([{"ends": [[2.5, 3.075], [3.5, 3.075]], "state": "closed"}])
TOWARDS_THE_DOOR = (3.0, 1.0, float(np.pi / 2.0))


def simulator(
    pose: tuple[float, float, float] = TOWARDS_THE_DOOR, params: RobotParams = EXACT
) -> Simulator:
    walls = Walls.of(ROOM_WITH_A_DOOR, (), DOORS)
    simulation = Simulation(walls, params, 0, np.random.default_rng(1))
    simulation.put(np.array(pose))
    return Simulator(simulation)


def messages(driver: Simulator, seconds: float) -> Counter[str]:
    return Counter(m.topic for m in measured(driver, seconds))


def measured(driver: Simulator, seconds: float, start_ns: int = START_NS) -> list:  # type: ignore[type-arg]
    driver.sense(start_ns)
    steps = range(1, round(seconds / 0.02) + 1)
    return [m for step in steps for m in driver.sense(start_ns + step * STEP_NS)]


def edges(driver: Simulator, seconds: float = 0.5, start_ns: int = START_NS) -> VerticalEdges:
    found = [m.message for m in measured(driver, seconds, start_ns)]
    return next(m for m in reversed(found) if isinstance(m, VerticalEdges))


def jamb_bearings(pose: tuple[float, float, float]) -> NDArray[np.float64]:
    """Bearings of the jambs from the camera's joint, off the robot's x axis."""
    x = pose[0] + 0.05 * np.cos(pose[2]) - np.array([2.5, 3.5])
    y = pose[1] + 0.05 * np.sin(pose[2]) - 3.0
    bearings: NDArray[np.float64] = np.arctan2(-y, -x) - pose[2]
    return bearings


def test_where_there_are_doors_edges_come_at_the_rate_of_the_registry_and_no_landmarks() -> None:
    counts = messages(simulator(), 4.0)
    assert counts["vertical_edges"] == 20 == 4.0 * (TOPICS["vertical_edges"].rate_hz or 0.0)
    assert "landmarks" not in counts


def test_without_doors_there_are_no_pictures_unless_they_are_asked_for() -> None:
    plain = Simulator(simulation_in())
    assert "vertical_edges" not in messages(plain, 1.0)
    asked = Simulator(simulation_in(params=replace(EXACT, picture=PictureParams())))
    assert messages(asked, 1.0)["vertical_edges"] == 5


def test_a_picture_is_taken_at_the_time_of_a_scan() -> None:
    found = [m.message for m in measured(simulator(), 2.0)]
    scans = {m.stamp_ns for m in found if isinstance(m, LaserScan)}
    pictures = {m.stamp_ns for m in found if isinstance(m, VerticalEdges)}
    assert pictures
    assert pictures <= scans


def test_the_jambs_of_a_door_ahead_are_among_the_edges() -> None:
    message = edges(simulator())
    off = np.abs(jamb_bearings(TOWARDS_THE_DOOR)[:, None] - message.bearings).min(axis=1)
    assert off.max() < 4.0 * message.sigma
    assert 0.0005 < message.sigma < 0.005


@pytest.mark.parametrize("pan", [-0.6, 0.4, 1.2])
def test_a_camera_that_looks_aside_says_bearings_off_the_robots_axis(pan: float) -> None:
    x, y, theta = TOWARDS_THE_DOOR
    pose = (x, y, theta - pan)
    driver = simulator(pose)
    driver.look(pan)
    measured(driver, 2.0)
    message = edges(driver, start_ns=START_NS + 10_000_000_000)
    off = np.abs(jamb_bearings(pose)[:, None] - message.bearings).min(axis=1)
    assert off.max() < 4.0 * message.sigma
    (mount,) = (m for m in driver.describe().mounts if m.kind == "camera")
    assert message.frame_id == mount.frame_id


def test_pictures_disturb_no_other_sensor() -> None:
    def scans(driver: Simulator) -> list[NDArray[np.float32]]:
        return [m.message.ranges for m in measured(driver, 1.0) if m.topic == "scan"]

    noisy = RobotParams()
    plain = Simulator(simulation_in(params=noisy))
    seeing = Simulator(simulation_in(params=replace(noisy, picture=PictureParams())))
    for one, other in zip(scans(plain), scans(seeing), strict=True):
        assert np.array_equal(one, other)


def test_edges_survive_the_wire() -> None:
    message = edges(simulator())
    assert encode(decode(VerticalEdges, encode(message))) == encode(message)


def test_opencv_is_loaded_only_where_there_are_pictures() -> None:
    program = (
        "import sys; from pilotage.robot.simulator import simulator, config;"
        "assert 'cv2' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", program], check=True, timeout=60)
