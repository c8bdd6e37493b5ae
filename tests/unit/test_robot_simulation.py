"""A robot among walls and people."""

from dataclasses import replace

import numpy as np
import pytest

from pilotage.robot.simulator.drive import SlipParams
from pilotage.robot.simulator.simulation import NoPlaceError, Simulation
from robot_world import EXACT, ROOM, simulation_in


def run(simulation: Simulation, seconds: float) -> None:
    for _ in range(round(seconds / 0.01)):
        simulation.tick()


def test_it_drives_straight_on() -> None:
    simulation = simulation_in()
    simulation.want(0.5, 0.0)
    run(simulation, 2.0)
    assert simulation.pose == pytest.approx([1.5 + 0.5 * 2.0 - 0.5**2 / 2.0, 1.75, 0.0], abs=0.01)
    assert simulation.twist == (0.5, 0.0)


def test_it_turns_on_the_spot() -> None:
    simulation = simulation_in()
    simulation.want(0.0, 1.0)
    run(simulation, 4.0)
    assert simulation.pose[:2] == pytest.approx([1.5, 1.75])
    assert simulation.pose[2] == pytest.approx(4.0 - 0.12 - 2.0 * np.pi, abs=0.02)


def test_it_stops_at_a_wall_and_presses_its_bumper() -> None:
    simulation = simulation_in()
    simulation.want(0.6, 0.0)
    run(simulation, 10.0)
    assert simulation.pose[0] == pytest.approx(5.5 - 0.165, abs=0.01)
    assert simulation.contact == pytest.approx(0.0, abs=0.1)
    assert simulation.twist[0] == 0.0


def test_its_wheels_stand_while_it_is_blocked() -> None:
    simulation = simulation_in()
    simulation.want(0.6, 0.0)
    run(simulation, 10.0)
    simulation.count_wheels()
    assert simulation.odometry.pose[0] == pytest.approx(simulation.pose[0] - 1.5)


def test_it_can_turn_at_a_wall_and_leave() -> None:
    simulation = simulation_in()
    simulation.want(0.6, 0.0)
    run(simulation, 10.0)
    simulation.want(0.0, 1.0)
    run(simulation, 3.1)
    assert abs(simulation.pose[2]) > 2.0
    simulation.want(0.5, 0.0)
    run(simulation, 1.0)
    assert simulation.contact is None
    assert simulation.pose[0] < 5.0


def test_a_contact_behind_is_felt_behind() -> None:
    simulation = simulation_in()
    simulation.want(-0.6, 0.0)
    run(simulation, 5.0)
    assert simulation.contact is not None
    assert abs(simulation.contact) == pytest.approx(np.pi, abs=0.1)


def test_wheels_that_slip_count_more_than_the_robot_goes() -> None:
    slippery = replace(EXACT, slip=SlipParams(rate=1e6, share=0.5, yaw_rate=0.0))
    simulation = simulation_in(params=slippery)
    simulation.want(0.5, 0.0)
    run(simulation, 3.0)
    simulation.count_wheels()
    went = simulation.pose[0] - 1.5
    assert simulation.odometry.pose[0] > 1.5 * went


def test_a_kidnapped_robot_stands_and_its_odometry_does_not_notice() -> None:
    simulation = simulation_in()
    simulation.want(0.5, 0.0)
    run(simulation, 1.0)
    simulation.count_wheels()
    believed = simulation.odometry.pose.copy()
    simulation.put(np.array([4.0, 1.0, 2.0]))
    run(simulation, 1.0)
    simulation.count_wheels()
    assert simulation.pose == pytest.approx([4.0, 1.0, 2.0])
    assert simulation.odometry.pose == pytest.approx(believed)


def test_a_kidnapped_robot_no_longer_touches_what_it_touched() -> None:
    simulation = simulation_in()
    simulation.want(0.6, 0.0)
    run(simulation, 10.0)
    simulation.put(np.array([3.0, 1.75, 0.0]))
    assert simulation.contact is None


def test_a_random_place_is_free_and_two_metres_away() -> None:
    simulation = simulation_in()
    for _ in range(50):
        before = simulation.pose
        simulation.put_anywhere()
        assert np.hypot(*(simulation.pose - before)[:2]) >= 2.0
        assert not simulation.walls.overlaps(simulation.pose[0], simulation.pose[1], 0.165)


@pytest.mark.parametrize(
    ("place", "reason"),
    [
        ((0.2, 1.0), "lies in a wall"),
        ((-4.0, 1.0), "lies outside of the map"),
        ((0.6, 1.0), "would touch a wall"),
    ],
)
def test_where_the_robot_cannot_stand_it_is_not_put(
    place: tuple[float, float], reason: str
) -> None:
    simulation = simulation_in()
    with pytest.raises(NoPlaceError, match=reason):
        simulation.put(np.array([*place, 0.0]))
    assert simulation.pose == pytest.approx([1.5, 1.75, 0.0])


def test_a_room_too_small_has_no_random_place() -> None:
    small = ROOM.cells[:, :5].copy()
    small[:, -1] = 100
    room = replace(ROOM, geometry=replace(ROOM.geometry, cols=5), cells=small)
    simulation = simulation_in(room, pose=(1.25, 1.75, 0.0))
    with pytest.raises(NoPlaceError, match="2 m away"):
        simulation.put_anywhere()


def test_a_person_in_the_way_stops_the_robot(monkeypatch: pytest.MonkeyPatch) -> None:
    simulation = simulation_in(people=1)
    simulation.people._poses[:] = [[3.0, 1.75, 0.0]]
    monkeypatch.setattr(simulation.people, "walk", lambda *_: None)
    simulation.want(0.5, 0.0)
    run(simulation, 5.0)
    assert simulation.pose[0] == pytest.approx(3.0 - 0.22 - 0.165, abs=0.01)
    assert simulation.contact == pytest.approx(0.0, abs=0.01)


def test_the_same_seed_gives_the_same_run() -> None:
    ends = []
    for _ in range(2):
        simulation = simulation_in(people=2, seed=9)
        simulation.want(0.4, 0.3)
        run(simulation, 3.0)
        ends.append((simulation.pose, simulation.people.discs))
    assert ends[0][0] == pytest.approx(ends[1][0])
    assert ends[0][1] == pytest.approx(ends[1][1])
