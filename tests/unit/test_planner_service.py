"""The planner on a fake bus: a robot that goes, finds out, and obeys people first."""

from pathlib import Path

import numpy as np
import pytest

from drawing import draw
from pilotage.bus.fabric import RefusedError
from pilotage.planner.config import PlannerSettings
from pilotage_schemas.commands import Done, GoTo, LocalizeActively, Look, Nothing
from pilotage_schemas.geometry import Pose2
from pilotage_schemas.message import Part
from pilotage_schemas.planning import PlanningStatus
from planner_bench import Bench

FAR = GoTo(pose=Pose2(x=4.8, y=2.0, theta=1.57))
"""In the large room at the end of the corridor."""


@pytest.fixture
def bench() -> Bench:
    bench = Bench()
    bench.begin()
    return bench


def test_a_goal_is_reached(bench: Bench) -> None:
    reply = bench.ask("go_to", FAR)
    assert reply.detail.startswith("going to (4.80, 2.00), ")
    bench.run(1.0)
    assert bench.mode == "going"
    assert bench.status.goal == FAR.pose
    assert bench.status.distance_left == pytest.approx(2.3, abs=0.5)
    bench.run(25.0)
    assert (bench.status.mode, bench.status.outcome) == ("idle", "done")
    assert np.hypot(*(bench.pose[:2] - [4.8, 2.0])) < 0.10
    assert abs(bench.pose[2] - 1.57) < 0.0873
    assert bench.velocities[-1].then == "stand"
    assert bench.status.goal is None


def test_goal_and_path_are_shown_and_the_path_goes_with_the_goal(bench: Bench) -> None:
    bench.ask("go_to", FAR)
    bench.run(1.0)
    assert [goal.pose for goal in bench.heard["goal"]] == [FAR.pose]
    path = bench.heard["path"][-1].poses
    assert path[0, :2] == pytest.approx([3.0, 0.6], abs=0.6)
    assert path[-1, :2] == pytest.approx([4.8, 2.0])
    bench.run(25.0)
    assert len(bench.heard["path"][-1].poses) == 0
    assert len(bench.heard["path"]) < 15, "said when a corner is passed, not at every step"


@pytest.mark.parametrize(
    ("x", "y", "reason"),
    [(-3.0, 1.0, "off the map"), (0.0, 0.0, "wall"), (1.80, 2.0, "wall"), (99.0, 9.0, "off")],
)
def test_a_goal_where_no_robot_can_stand_is_refused(
    bench: Bench, x: float, y: float, reason: str
) -> None:
    for state in ("localized", "ambiguous"):
        bench.state = state
        bench.run(0.2)
        with pytest.raises(RefusedError, match=reason):
            bench.ask("go_to", GoTo(pose=Pose2(x=x, y=y, theta=0.0)))
    assert bench.mode == "idle"
    assert bench.velocities == []


def test_a_doubt_is_resolved_and_what_speaks_for_the_look_is_shown(bench: Bench) -> None:
    bench.pose = np.array([0.8, 2.0, -1.57])
    bench.places = [np.array([2.55, 2.0, -1.57])]
    bench.state = "ambiguous"
    bench.run(0.3)
    assert bench.ask("localize_actively", LocalizeActively()).detail == "finding out where it is"
    bench.run(2.0)
    assert bench.mode == "localizing"
    plan = bench.heard["plan"][0]
    assert plan.candidates[0].expected_gain > 0.3
    assert plan.reason == "Would tell place 1 from place 2"
    path = bench.heard["path"][0].poses
    assert path[0, :2] == pytest.approx(bench.pose[:2], abs=1.0)
    assert any(
        command.twist.vx != 0.0 or command.twist.omega != 0.0 for command in bench.velocities
    )
    bench.places, bench.state = [], "localized"
    bench.run(2.0)
    assert (bench.status.mode, bench.status.outcome) == ("idle", "done")
    assert bench.velocities[-1].then == "resume"
    assert bench.heard["plan"][-1].candidates == ()


def test_a_goal_of_a_robot_in_doubt_is_gone_to_when_the_doubt_is_resolved(bench: Bench) -> None:
    bench.state = "ambiguous"
    bench.places = [np.array([2.55, 2.0, -1.57])]
    bench.run(0.3)
    assert "finding out where it is" in bench.ask("go_to", FAR).detail
    bench.run(3.0)
    assert (bench.status.mode, bench.status.goal) == ("localizing", FAR.pose)
    bench.places, bench.state = [], "localized"
    bench.run(30.0)
    assert bench.status.outcome == "done"
    assert np.hypot(*(bench.pose[:2] - [4.8, 2.0])) < 0.10


def test_who_knows_where_it_is_has_nothing_to_resolve(bench: Bench) -> None:
    assert bench.ask("localize_actively", LocalizeActively()) == Done(
        detail="the pose is not in doubt"
    )
    bench.run(1.0)
    assert bench.mode == "idle"


def test_always_means_from_now_on(bench: Bench) -> None:
    bench.ask("localize_actively", LocalizeActively(always=True))
    bench.run(1.0)
    assert bench.status.always_localizes
    bench.state, bench.places = "lost", [np.array([2.55, 2.0, -1.57])]
    bench.run(2.0)
    assert bench.mode == "localizing"


def test_cancel_lets_the_robot_stand_and_ends_always(bench: Bench) -> None:
    bench.ask("localize_actively", LocalizeActively(always=True))
    bench.ask("go_to", FAR)
    bench.run(1.0)
    assert bench.ask("cancel", Nothing()).detail == "cancelled: going to (4.80, 2.00)"
    assert bench.velocities[-1].then == "stand"
    bench.run(1.0)
    assert bench.speeds == (0.0, 0.0)
    assert (bench.status.mode, bench.status.outcome) == ("idle", "cancelled")
    assert not bench.status.always_localizes
    bench.state = "ambiguous"
    bench.run(3.0)
    assert bench.mode == "idle"
    assert bench.ask("cancel", Nothing()).detail == "there was nothing to do"


def test_a_persons_stop_ends_the_task_and_is_not_fought(bench: Bench) -> None:
    bench.ask("localize_actively", LocalizeActively(always=True))
    bench.ask("go_to", FAR)
    bench.run(1.0)
    bench.orders, bench.is_held, bench.speeds = 1, True, (0.0, 0.0)
    bench.say_status()
    sent = len(bench.velocities)
    bench.state = "ambiguous"
    bench.run(3.0)
    assert (bench.status.mode, bench.status.outcome) == ("idle", "interrupted")
    assert "a person told the robot something else: stopped by command" in bench.status.reason
    assert len(bench.velocities) == sent, "always does not mean against a person's word"
    bench.ask("localize_actively", LocalizeActively())
    bench.run(1.0)
    assert bench.mode == "localizing"
    assert bench.velocities[-1].orders == 1


def test_a_robot_that_was_restarted_is_driven_on(bench: Bench) -> None:
    bench.orders = 3
    bench.say_status()
    bench.ask("go_to", FAR)
    bench.run(0.5)
    bench.orders = 0
    bench.say_status()
    bench.run(1.0)
    assert bench.mode == "going"
    assert bench.velocities[-1].orders == 0


def test_what_is_missing_is_waited_for_without_driving(bench: Bench) -> None:
    bench.ask("go_to", FAR)
    bench.run(1.0)
    bench.silent = {"pose"}
    bench.run(2.0)
    assert bench.mode == "waiting"
    assert bench.status.reason.startswith("no pose for")
    assert bench.speeds == (0.0, 0.0)
    bench.silent = set()
    bench.run(1.0)
    assert bench.mode == "going"


def without_map() -> Bench:
    bench = Bench()
    bench.map_id = ""
    bench.describe()
    bench.say_status()
    bench.run(0.3)
    return bench


def with_a_log() -> Bench:
    bench = Bench(source="replay")
    bench.begin()
    return bench


def without_wheels() -> Bench:
    bench = Bench(commands=())
    bench.begin()
    return bench


def while_mapping() -> Bench:
    bench = Bench()
    bench.begin()
    bench.say_mapping("mapping")
    return bench


def without_localizer() -> Bench:
    bench = Bench(silent={"pose"})
    bench.begin()
    return bench


def without_scan() -> Bench:
    bench = Bench()
    bench.begin()
    bench.silent = {"scan"}
    bench.run(2.0)
    return bench


@pytest.mark.parametrize(
    ("make", "reason"),
    [
        (Bench, "the robot has not been heard of yet"),
        (without_map, "there is no map yet"),
        (with_a_log, "a recorded log cannot be driven"),
        (without_wheels, "Toy has no command velocity"),
        (while_mapping, "a map is being made"),
        (without_localizer, "no pose has come yet"),
        (without_scan, "no scan for 2 s"),
    ],
)
def test_what_cannot_be_done_is_refused_with_the_reason(make: type[Bench], reason: str) -> None:
    bench = make()
    requests: list[tuple[str, Part]] = [("go_to", FAR), ("localize_actively", LocalizeActively())]
    for query, request in requests:
        with pytest.raises(RefusedError, match=reason):
            bench.ask(query, request)


@pytest.mark.parametrize("news", ["mapping", "another map"])
def test_a_task_ends_with_the_map_it_was_planned_on(bench: Bench, news: str) -> None:
    bench.ask("go_to", FAR)
    bench.run(1.0)
    if news == "mapping":
        bench.say_mapping("mapping")
    else:
        bench.put_map("another")
    bench.run(0.5)
    assert (bench.status.mode, bench.status.outcome) == ("idle", "interrupted")
    assert bench.velocities[-1].then == "stand"


def test_the_same_map_again_changes_nothing(bench: Bench) -> None:
    bench.ask("go_to", FAR)
    bench.run(1.0)
    bench.put_map()
    bench.put_map("growing", in_progress=True)
    bench.map_id = "twins"
    bench.run(1.0)
    assert bench.mode == "going"
    assert len(bench.heard["potential"]) == 1


def test_a_camera_is_pointed_where_there_is_one() -> None:
    bench = Bench(commands=("velocity", "look"))
    bench.begin()
    assert bench.ask("look", Look(pan=0.5)).detail == "looking 29 degrees to the left"
    bench.nodes["gateway"].step()
    assert [gaze.pan for gaze in bench.heard["gaze"]] == [0.5]


def test_a_robot_without_a_camera_cannot_look(bench: Bench) -> None:
    with pytest.raises(RefusedError, match="no camera"):
        bench.ask("look", Look(pan=0.5))


def test_the_status_can_be_asked_for(bench: Bench) -> None:
    status = bench.ask("planner_status", Nothing())
    assert isinstance(status, PlanningStatus)
    assert (status.mode, status.reason) == ("idle", "nothing to do")


def test_a_planner_that_was_killed_says_what_it_was_doing_and_does_not_go_on(
    tmp_path: Path,
) -> None:
    bench = Bench(folder=tmp_path)
    bench.begin()
    bench.ask("localize_actively", LocalizeActively(always=True))
    bench.ask("go_to", FAR)
    bench.run(1.0)
    bench.begin_planner()
    bench.begin()
    assert (bench.status.mode, bench.status.outcome) == ("idle", "interrupted")
    assert bench.status.reason == "the planner was restarted while going to (4.80, 2.00)"
    assert bench.status.always_localizes
    bench.state, bench.places = "ambiguous", [np.array([2.55, 2.0, -1.57])]
    bench.run(2.0)
    assert bench.mode == "localizing"


def test_a_setting_makes_it_resolve_every_doubt() -> None:
    bench = Bench(settings=PlannerSettings(always_localizes=True))
    bench.state, bench.places = "ambiguous", [np.array([2.55, 2.0, -1.57])]
    bench.begin()
    bench.run(2.0)
    assert bench.mode == "localizing"


def test_a_map_that_nobody_can_plan_on_is_refused_with_the_reason(bench: Bench) -> None:
    bench.world = draw("###", resolution=0.25)
    bench.put_map("solid")
    bench.run(0.3)
    with pytest.raises(RefusedError, match="no free ground"):
        bench.ask("go_to", FAR)
    bench.world = draw("...", resolution=2.0)
    bench.put_map("coarse")
    with pytest.raises(RefusedError, match="cells of 2 m are too coarse"):
        bench.ask("go_to", FAR)


def test_a_search_by_landmarks_points_the_camera(tmp_path: Path) -> None:
    file = tmp_path / "landmarks.yaml"
    file.write_text("landmarks:\n  - {class: post, x: 4.8, y: 2.0}\n", encoding="utf-8")
    bench = Bench(settings=PlannerSettings(landmarks=file))
    bench.begin()
    bench.places, bench.state = [np.array([2.55, 2.0, -1.57])], "ambiguous"
    bench.run(0.3)
    assert bench.heard["gaze"] == []
    bench.ask("localize_actively", LocalizeActively())
    bench.run(1.0)
    assert bench.heard["gaze"]
    assert abs(bench.heard["gaze"][-1].pan) <= np.pi / 2.0
    bench.places, bench.state = [], "localized"
    bench.run(2.0)
    count = len(bench.heard["gaze"])
    bench.run(1.0)
    assert len(bench.heard["gaze"]) == count, "who knows where it is leaves the camera alone"
