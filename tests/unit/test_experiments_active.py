"""The experiments of Liu et al. 2008: fields, robot, filter, and who finds out first."""

import json
from itertools import pairwise

import numpy as np
import pytest

from pilotage.experiments.active_comparison import (
    FIXED_PATH,
    POLICIES,
    Setting,
    Trial,
    Trials,
    compare,
    comparison_report,
    conduct_trial,
    convergence_step,
    method_for,
)
from pilotage.experiments.active_filter import LandmarkFilter, mean_place
from pilotage.experiments.active_plots import error_figure, field_figure
from pilotage.experiments.active_policies import STEP, FixedPolicy, RandomPolicy
from pilotage.experiments.active_robot import Luck, luck_of, recognised_landmarks, walked
from pilotage.experiments.catalogue import CATALOGUE
from pilotage.experiments.landmark_field import (
    CARPET,
    START,
    LandmarkField,
    robocup_field,
    similar_field,
)
from pilotage.experiments.outcome import Request
from pilotage.planner.landmark_views import Camera, sighting_log_likelihoods
from pilotage.planner.situation import Hypotheses

CAMERA = Camera()
ALL_AROUND = (0.0, float(np.pi))


def run(field: LandmarkField, particles: int, steps: int, runs: int) -> Trials:
    setting = Setting(field, particles, steps)
    return compare(setting, method_for(field), Request(runs, 0), lambda _: None)


@pytest.fixture(scope="module")
def robocup() -> Trials:
    return run(robocup_field(), 1_000, 20, 3)


@pytest.fixture(scope="module")
def similar() -> Trials:
    return run(similar_field(), 3_000, 40, 3)


def last_errors(trials: Trials) -> dict[str, float]:
    return {
        name: float(np.mean([one.errors[-5:] for one in runs])) for name, runs in trials.items()
    }


def test_on_the_robocup_field_active_beats_the_fixed_path(robocup: Trials) -> None:
    errors = last_errors(robocup)
    assert errors["active"] < 0.2
    assert errors["active"] < errors["fixed"]


def test_where_halves_look_the_same_only_active_knows_soon(similar: Trials) -> None:
    errors = last_errors(similar)
    assert errors["active"] < 0.3
    assert errors["fixed"] > 1.0
    assert errors["random"] > 1.0


def test_nobody_knows_where_the_robot_starts(robocup: Trials, similar: Trials) -> None:
    for trials in (robocup, similar):
        for name in POLICIES:
            assert trials[name][0].errors[0] == pytest.approx(2.4, abs=0.15)


def test_nobody_steps_farther_than_the_robot_can(similar: Trials) -> None:
    for name in POLICIES:
        for trial in similar[name]:
            steps = np.hypot(*np.diff(trial.path[:, :2], axis=0).T)
            assert steps.max() < STEP * 1.5


def test_the_paper_has_eight_corners_six_crossings_and_seven_unique_landmarks() -> None:
    sources = robocup_field().sources
    shares, counts = np.unique(np.round(sources.strengths, 6), return_counts=True)
    assert dict(zip(shares.tolist(), counts.tolist(), strict=True)) == {
        0.125: 8,
        round(1 / 6, 6): 6,
        1.0: 7,
    }


def test_all_landmarks_lie_on_the_carpet() -> None:
    half = np.array(CARPET) / 2.0
    for field in (robocup_field(), similar_field()):
        assert (np.abs(field.landmarks.positions) <= half).all()


def test_every_place_of_the_similar_field_has_a_twin_as_far_as_cones_tell() -> None:
    rng = np.random.default_rng(1)
    sources = similar_field().sources
    is_cone = sources.strengths < 1.0
    cones = sources._replace(falls=np.where(is_cone, sources.falls, 1e-3), reaches=np.where(
        is_cone, sources.reaches, -10.0))  # fmt: skip
    poses = rng.uniform(-2.0, 2.0, (20, 3))
    twins = poses * (-1.0, -1.0, 1.0) + (0.0, 0.0, np.pi)
    cone = np.array([int(sources.kinds[is_cone][0])])
    seen = cone, np.array([[0.7, 0.4]])
    ways = [
        sighting_log_likelihoods(cones, at, seen, ALL_AROUND, CAMERA.sharpness)
        for at in (poses, twins)
    ]
    assert ways[0] == pytest.approx(ways[1])


def test_the_unique_landmarks_are_out_of_sight_from_the_start() -> None:
    sources = similar_field().sources
    away = np.hypot(*(sources.positions[sources.strengths == 1.0] - START[:2]).T)
    assert (away > 2.3).all()


def test_policies_share_their_luck() -> None:
    one, other = (luck_of(np.random.default_rng([0, 3, 1, 7]), 5) for _ in range(2))
    assert one.walk == pytest.approx(other.walk)
    assert one.sight == pytest.approx(other.sight)


def test_a_run_can_be_repeated() -> None:
    field = similar_field()
    setting, method = Setting(field, 300, 5), method_for(field)
    paths = [
        conduct_trial(setting, method, RandomPolicy(np.random.default_rng(5)), [0, 0]).path
        for _ in range(2)
    ]
    assert paths[0] == pytest.approx(paths[1])


def test_ranges_and_bearings_err_as_in_the_paper() -> None:
    field = robocup_field()
    sources, rng = field.sources, np.random.default_rng(3)
    pose = np.array([1.7, 0.0, 0.0])
    goal = int(np.nonzero((sources.positions == (2.7, 0.0)).all(axis=1))[0][0])
    seen = []
    for _ in range(2000):
        luck = luck_of(rng, len(sources.kinds))
        kinds, values = recognised_landmarks(sources, pose, 0.0, CAMERA, luck)
        seen += [value for kind, value in zip(kinds, values, strict=True)
                 if kind == sources.kinds[goal]]  # fmt: skip
    values = np.array(seen)
    assert len(values) > 1950
    assert values.mean(axis=0) == pytest.approx([1.0, 0.0], abs=0.02)
    assert values.std(axis=0) == pytest.approx([0.1, np.deg2rad(10.0)], rel=0.08)


def test_what_the_camera_does_not_point_to_is_not_seen() -> None:
    sources = robocup_field().sources
    luck = luck_of(np.random.default_rng(0), len(sources.kinds))
    pose = np.array([2.5, 0.0, 0.0])
    kinds, values = recognised_landmarks(sources, pose, np.pi, CAMERA, luck)
    assert len(kinds) == len(values)
    assert (np.abs(np.abs(values[:, 1]) - np.pi) < CAMERA.half_view + 0.7).all()


def test_walking_errs_by_a_tenth() -> None:
    rng = np.random.default_rng(0)
    ends = [
        walked(np.array([0.0, 0.0, 0.0]), np.array([0.1, 0.0]), luck_of(rng, 1))
        for _ in range(3000)
    ]
    assert np.mean(ends, axis=0) == pytest.approx([0.1, 0.0, 0.0], abs=1e-3)
    assert np.std(ends, axis=0) == pytest.approx([0.01, 0.01, 0.0], rel=0.06)


def test_the_fixed_path_leads_past_its_corners_looking_ahead() -> None:
    policy = FixedPolicy.along(np.array(START), FIXED_PATH)
    belief = Hypotheses(np.zeros((1, 3)), np.ones(1))
    pose, places = np.array(START), [START[:2]]
    for number in range(len(policy.moves)):
        move, gaze = policy.step(belief, number)
        assert np.hypot(*move) <= STEP + 1e-9
        assert np.arctan2(move[1], move[0]) == pytest.approx(gaze)
        pose = walked(pose, move, Luck(np.zeros(2), np.zeros((0, 3))))
        places.append((float(pose[0]), float(pose[1])))
    for corner in FIXED_PATH:
        assert np.hypot(*(np.array(places) - corner).T).min() < 1e-6


def test_at_the_end_of_its_path_the_robot_stands() -> None:
    policy = FixedPolicy.along(np.array(START), FIXED_PATH[:1])
    move, _ = policy.step(Hypotheses(np.zeros((1, 3)), np.ones(1)), 1_000)
    assert move == pytest.approx([0.0, 0.0])


def test_sightings_of_the_own_place_make_the_filter_sure() -> None:
    sources, pose = robocup_field().sources, np.array([1.0, 0.5, 0.3])
    localizer = LandmarkFilter(sources, CAMERA, 2_000, [0])
    rng = np.random.default_rng(8)
    for step in range(24):
        gaze = step * 2.0 * np.pi / 8.0
        luck = luck_of(rng, len(sources.kinds))
        seen = recognised_landmarks(sources, pose, gaze, CAMERA, luck)
        localizer.update(np.zeros(2), gaze, seen, step)
    assert localizer.estimate == pytest.approx(pose[:2], abs=0.25)
    assert localizer.belief.weights.sum() == pytest.approx(1.0)


def test_the_mean_place_counts_weights() -> None:
    belief = Hypotheses(np.array([[0.0, 0.0, 0.0], [4.0, 2.0, 1.0]]), np.array([0.75, 0.25]))
    assert mean_place(belief) == pytest.approx([1.0, 0.5])


@pytest.mark.parametrize(
    ("errors", "step"),
    [
        ((2.0, 1.0, 0.2, 0.1), 2),
        ((0.1, 0.1), 0),
        ((2.0, 0.2, 0.5, 0.1), 3),
        ((2.0, 0.1, 0.31), None),
    ],
)
def test_a_policy_has_converged_when_its_error_stays_small(
    errors: tuple[float, ...], step: int | None
) -> None:
    assert convergence_step(np.array(errors)) == step


def test_the_report_has_the_keys_that_others_rely_on(robocup: Trials) -> None:
    report = comparison_report(robocup)
    json.dumps(report, allow_nan=False)
    for key in ("convergence_step", "final_error_m", "curves"):
        figures = report[key]
        assert isinstance(figures, dict)
        assert set(figures) == set(POLICIES)


def test_active_is_called_best_from_where_it_stays_so() -> None:
    def trials(*errors: float) -> list[Trial]:
        return [Trial(np.zeros((len(errors), 3)), np.array(errors))]

    report = comparison_report(
        {"active": trials(3, 1, 2, 1), "fixed": trials(3, 2, 2, 2), "random": trials(3, 3, 3, 3)}
    )
    assert report["active_is_best_from_step"] == 3


def test_the_figures_show_every_policy(robocup: Trials) -> None:
    field = robocup_field()
    (axes,) = error_figure(field, robocup).axes
    legend = axes.get_legend()
    assert legend is not None
    said = [text.get_text() for text in legend.get_texts()]
    assert all(any(name in text for text in said) for name in POLICIES)
    picture = field_figure(field, method_for(field).field, robocup)
    assert picture.axes[0].get_title() == field.name


def test_both_experiments_run_a_hundred_times_unless_told_otherwise() -> None:
    assert CATALOGUE["robocup"].usual_runs == 100
    assert CATALOGUE["similar-rooms"].usual_runs == 100


def test_lanes_of_the_fixed_path_run_along_the_fields_axes() -> None:
    for (x, y), (next_x, next_y) in pairwise((START[:2], *FIXED_PATH)):
        assert x == next_x or y == next_y
