"""Commands and compass correct dead reckoning, unless they disagree with it beyond chance."""

import numpy as np
import pytest

from pilotage.core import se2
from pilotage.core.motion import arc
from pilotage.mapper.displacement import DisplacementNoise, fuse_increments, measured
from pilotage.mapper.obedience import Obedience
from pilotage.mapper.pose_correction import PoseCorrection, PoseCorrectionParams

DT = 0.1
AHEAD = (0.2, 0.0)
LEFT = (0.0, 0.6)
NORTH_IS_X = PoseCorrectionParams(compass_offset=0.0)


def drive(
    correction: PoseCorrection,
    steps: int,
    moved: tuple[float, float],
    ordered: tuple[float, float] | None,
) -> None:
    """Let odometry count one motion, while another was ordered."""
    for _ in range(steps):
        correction.step(arc(np.zeros(3), *moved, DT), DT, ordered)


def test_without_commands_and_compass_it_is_dead_reckoning() -> None:
    correction = PoseCorrection(start=(1.0, 2.0, np.pi / 2.0))
    drive(correction, 50, AHEAD, None)
    assert correction.pose == pytest.approx([1.0, 3.0, np.pi / 2.0])


def test_odometry_of_a_wheel_too_large_is_set_right_by_commands() -> None:
    correction = PoseCorrection()
    drive(correction, 200, (0.21, 0.0), AHEAD)
    assert correction.pose[0] == pytest.approx(4.0, abs=0.03)
    plain = PoseCorrection()
    drive(plain, 200, (0.21, 0.0), None)
    assert plain.pose[0] == pytest.approx(4.2)
    assert correction.covariance[0, 0] < plain.covariance[0, 0] / 10.0


def test_steps_of_another_length_weigh_commands_alike() -> None:
    ends = []
    for parts in (1, 5):
        correction = PoseCorrection()
        for _ in range(20 * parts):
            correction.step((0.21 / parts, 0.0, 0.0), 1.0 / parts, AHEAD)
        ends.append(correction.pose[0])
    assert ends[0] == pytest.approx(ends[1], abs=0.02)


def test_a_command_to_blocked_wheels_moves_nothing() -> None:
    correction = PoseCorrection()
    drive(correction, 50, (0.0, 0.0), AHEAD)
    assert correction.pose == pytest.approx(np.zeros(3), abs=1e-9)


def test_a_robot_pushed_while_told_to_stand_is_followed() -> None:
    correction = PoseCorrection()
    drive(correction, 50, AHEAD, (0.0, 0.0))
    assert correction.pose[0] == pytest.approx(1.0, abs=1e-6)


@pytest.mark.parametrize("dt", [0.02, 0.05, 0.1])
@pytest.mark.parametrize("acceleration", [0.5, 1.0])
def test_a_robot_that_gathers_speed_is_followed_by_odometry(dt: float, acceleration: float) -> None:
    """Odometry is exact here; orders are ahead of the wheels after every change of them."""
    correction, truth, rng = PoseCorrection(), np.zeros(3), np.random.default_rng(0)
    speeds, order = np.zeros(2), np.zeros(2)
    for step in range(round(30.0 / dt)):
        if step % round(1.0 / dt) == 0:
            order = rng.uniform((0.0, -1.0), (0.5, 1.0))
        most = np.array([1.0, 3.0]) * acceleration * dt
        speeds = speeds + np.clip(order - speeds, -most, most)
        counted = arc(np.zeros(3), speeds[0], speeds[1], dt)
        truth = se2.compose(truth, counted)
        correction.step(counted, dt, (float(order[0]), float(order[1])))
    assert np.hypot(*(correction.pose - truth)[:2]) < 0.03
    assert correction.pose[2] == pytest.approx(truth[2], abs=0.02)


def test_an_order_counts_only_after_the_robot_had_time_to_obey() -> None:
    params = PoseCorrectionParams()
    watch = Obedience(params.obedience, params.odometry, params.command)
    step = arc(np.zeros(3), *AHEAD, DT)
    heard = [watch.order(step, DT, AHEAD) is not None for _ in range(6)]
    assert heard == [False, False, False, True, True, True]
    assert watch.order(step, DT, (0.4, 0.0)) is None
    assert watch.order(step, DT, None) is None


def test_an_order_that_hardly_varies_is_the_same_order() -> None:
    params = PoseCorrectionParams()
    watch = Obedience(params.obedience, params.odometry, params.command)
    orders = [(0.2 + 0.005 * (step % 3), 0.0) for step in range(20)]
    heard = [watch.order(arc(np.zeros(3), *one, DT), DT, one) is not None for one in orders]
    assert all(heard[3:])


def test_a_robot_stopped_on_its_way_is_noticed_within_a_moment() -> None:
    correction = PoseCorrection()
    drive(correction, 50, AHEAD, AHEAD)
    before = correction.pose[0]
    drive(correction, 50, (0.0, 0.0), AHEAD)
    assert correction.pose[0] == pytest.approx(before, abs=0.045)


def test_a_compass_holds_the_heading_over_many_turns() -> None:
    correction, rng = PoseCorrection(), np.random.default_rng(1)
    theta = 0.0
    for step in range(400):
        turn = 0.06 * (step >= 100)
        theta += turn
        yaw = theta + 0.7 + 0.035 * rng.standard_normal()
        correction.step((0.02 * (turn == 0.0), 0.0, 1.04 * turn), DT, None, (yaw, 0.035))
    assert np.sin(correction.pose[2] - theta) == pytest.approx(0.0, abs=0.02)
    assert np.sqrt(correction.covariance[2, 2]) < 0.025


def test_a_known_compass_sets_an_unknown_start_right() -> None:
    correction = PoseCorrection(NORTH_IS_X, start_covariance=np.diag([1e-6, 1e-6, 3.0]))
    correction.step(np.zeros(3), DT, None, (2.5, 0.02))
    assert correction.pose[2] == pytest.approx(2.5, abs=0.01)


def test_an_unknown_north_leaves_the_heading_of_the_start_alone() -> None:
    correction = PoseCorrection()
    correction.step(np.zeros(3), DT, None, (2.5, 0.02))
    assert correction.pose[2] == pytest.approx(0.0, abs=1e-3)


def test_a_compass_near_iron_is_left_out() -> None:
    correction = PoseCorrection(NORTH_IS_X)
    drive(correction, 20, AHEAD, AHEAD)
    before = correction.pose
    pose, _ = correction.step(np.zeros(3), DT, None, (0.9, 0.035))
    assert pose[2] == pytest.approx(before[2], abs=1e-9)


def test_a_compass_across_the_wrap_pulls_the_shorter_way() -> None:
    correction = PoseCorrection(
        NORTH_IS_X, start=(0.0, 0.0, np.pi - 0.01), start_covariance=np.eye(3) * 0.04
    )
    pose, _ = correction.step(np.zeros(3), DT, None, (-np.pi + 0.03, 0.035))
    assert abs(pose[2]) > np.pi - 0.03


def test_a_lasting_error_spreads_with_the_way_and_not_with_its_root() -> None:
    noise = DisplacementNoise(0.05, 0.0, 0.0, 0.0, 0.0)
    correction = PoseCorrection(PoseCorrectionParams(odometry=noise))
    drive(correction, 100, AHEAD, None)
    assert np.sqrt(correction.covariance[0, 0]) == pytest.approx(0.05 * 2.0, rel=0.01)
    drive(correction, 100, (-0.2, 0.0), None)
    # Back at the start a wheel of the wrong size has made good all its errors.
    assert np.sqrt(correction.covariance[0, 0]) < 0.01


def test_what_was_remembered_goes_on_alike() -> None:
    one, other = PoseCorrection(), PoseCorrection()
    drive(one, 30, LEFT, LEFT)
    other.resume(one.remember())
    for correction in (one, other):
        correction.step((0.02, 0.0, 0.0), DT, AHEAD, (1.0, 0.04))
    assert np.array_equal(one.pose, other.pose)
    assert np.array_equal(one.covariance, other.covariance)


@pytest.mark.parametrize("missing", ["mean", "random", "lasting"])
def test_a_memory_that_does_not_fit_is_refused(missing: str) -> None:
    memory = PoseCorrection().remember()
    with pytest.raises(ValueError, match=missing):
        PoseCorrection().resume(memory | {missing: np.zeros(2)})
    del memory[missing]
    with pytest.raises(ValueError, match=missing):
        PoseCorrection().resume(memory)


@pytest.mark.parametrize(("name", "value"), [("way_share", -0.1), ("turn_floor", 0.0)])
def test_a_noise_that_cannot_be_is_refused(name: str, value: float) -> None:
    with pytest.raises(ValueError, match=name):
        DisplacementNoise(**({"way_share": 0.1, "turn_share": 0.1} | {name: value}))


def test_two_equal_measurements_meet_in_the_middle_across_the_wrap() -> None:
    noise = DisplacementNoise(0.05, 0.05)
    one = measured(np.array([0.0, 0.0, np.pi - 0.1]), noise)
    other = measured(np.array([0.0, 0.0, -np.pi + 0.1]), noise)
    fused = fuse_increments(one, other)
    assert abs(fused.increment[2]) == pytest.approx(np.pi, abs=1e-3)


def test_a_covariance_says_how_far_off_the_poses_really_are() -> None:
    """Normalised squared errors of drives whose errors are drawn as the parameters say."""
    params = PoseCorrectionParams()
    rng = np.random.default_rng(0)
    squares = [_squared_error(params, rng) for _ in range(40)]
    assert 1.5 < np.mean(squares) < 6.0, squares


def _squared_error(params: PoseCorrectionParams, rng: np.random.Generator) -> float:
    """Return the squared Mahalanobis error after a way, a turn and a way."""
    correction, truth = PoseCorrection(params), np.zeros(3)
    odometry, command = params.odometry, params.command
    shares = rng.standard_normal(4)
    for step in range(300):
        v, w = (0.0, 0.6) if 100 <= step < 126 else (0.2, 0.0)
        did = v * DT * (1.0 + command.way_share * shares[0])
        turned = w * DT * (1.0 + command.turn_share * shares[1])
        did += command.way_walk * np.sqrt(abs(did)) * rng.standard_normal()
        turned += (
            np.hypot(
                command.turn_walk * np.sqrt(abs(turned)), command.drift_walk * np.sqrt(abs(did))
            )
            * rng.standard_normal()
        )
        truth = arc(truth, did, turned, 1.0)
        seen = did * (1.0 + odometry.way_share * shares[2])
        seen_turn = turned * (1.0 + odometry.turn_share * shares[3])
        seen += odometry.way_walk * np.sqrt(abs(seen)) * rng.standard_normal()
        seen_turn += (
            np.hypot(
                odometry.turn_walk * np.sqrt(abs(turned)), odometry.drift_walk * np.sqrt(abs(did))
            )
            * rng.standard_normal()
        )
        heading = (truth[2] + 0.3 + 0.035 * rng.standard_normal(), 0.035)
        correction.step(arc(np.zeros(3), seen, seen_turn, 1.0), DT, (v, w), heading)
    off = truth - correction.pose
    return float(off @ np.linalg.solve(correction.covariance, off))
