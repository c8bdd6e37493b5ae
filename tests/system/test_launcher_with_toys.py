"""The launcher with real processes that do nothing but live."""

import os
import signal
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

import processes
from pilotage.bus.fabric import RefusedError
from pilotage_schemas.commands import Restart
from runs import Run, Watch, figure, lives
from waiting import eventually, never

pytestmark = pytest.mark.system


def toys(folder: Path, endpoint: str = "", **moods: str) -> tuple[Run, str]:
    """Return a run of toys, not yet started, and its endpoint."""
    endpoint = endpoint or f"tcp/127.0.0.1:{processes.free_port()}"
    lines = [f"  {name}: {{mood: {mood}}}" for name, mood in moods.items()]
    path = folder / "toys.yaml"
    path.write_text("\n".join([f"endpoint: {endpoint}", "services:", *lines]), encoding="utf-8")
    return Run("toys.up", [str(path)], folder), endpoint


@pytest.fixture(scope="module")
def endpoint_of_steady_run(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    run, endpoint = toys(tmp_path_factory.mktemp("steady"), ann="steady", ben="steady")
    with run:
        run.says("ann        ready after")
        run.says("ben        ready after")
        yield endpoint


@pytest.fixture
def steady(endpoint_of_steady_run: str) -> Iterator[Watch]:
    """The topic `deployment` of a run that the tests of this module share."""
    with Watch(endpoint_of_steady_run) as watch:
        watch.until("ann", "ready")
        watch.until("ben", "ready")
        yield watch


def forgiven(watch: Watch, name: str) -> int:
    """Let earlier tests' failures of a process not count; return its restarts so far."""
    before = watch.until(name, "ready").restarts
    watch.node.ask("restart", Restart(service=name))
    return watch.until(name, "ready", restarts=before + 1).restarts


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGSTOP])
@pytest.mark.parametrize("name", ["ann", "router"])
def test_a_process_that_dies_or_hangs_is_replaced(
    steady: Watch, name: str, number: signal.Signals
) -> None:
    restarts = forgiven(steady, "ann") if name == "ann" else steady.processes()[name].restarts
    victim, began = steady.pid(name), time.monotonic()
    os.kill(victim, number)
    again = steady.until(name, "ready", restarts=restarts + 1)
    assert again.pid != victim
    assert not lives(victim)
    if name == "ann":
        noticed = steady.delay_of(name, began, ready=False)
        figure(f"{name} {number.name}: noticed after {noticed:.2f} s")
    figure(f"{name} {number.name}: back after {time.monotonic() - began:.2f} s")
    assert steady.until("ben", "ready").restarts == 0


def test_a_restart_can_be_asked_for(steady: Watch) -> None:
    before = steady.until("ann", "ready")
    steady.node.ask("restart", Restart(service="ann"))
    after = steady.until("ann", "ready", restarts=before.restarts + 1)
    assert after.pid != before.pid
    assert after.try_number == 0


def test_a_restart_of_what_does_not_exist_is_refused(steady: Watch) -> None:
    with pytest.raises(RefusedError, match="no process 'eve' in this run"):
        steady.node.ask("restart", Restart(service="eve"))


def test_ctrl_c_leaves_no_process(tmp_path: Path) -> None:
    run, _ = toys(tmp_path, ann="steady", ben="steady")
    with run:
        run.says("ben        ready")
        run.says("ann        ready")
        run.says("ann        | I am ann and steady")
        children, began = run.descendants(), time.monotonic()
        run.send(signal.SIGINT)
        assert run.ended() == 0
        figure(f"stopped after {time.monotonic() - began:.2f} s")
        assert "stopping (SIGINT); a second signal kills at once" in run.lines
        assert len(children) == 4
        assert not any(lives(pid) for pid in children)


def test_a_launcher_that_is_told_to_end_says_so_in_one_line(tmp_path: Path) -> None:
    run, _ = toys(tmp_path, ann="steady")
    with run:
        run.says("ann        ready")
        run.send(signal.SIGTERM)
        assert run.ended() == 0
        assert [line for line in run.lines if line.startswith("stopping")] == [
            "stopping (SIGTERM); a second signal kills at once"
        ]


def test_a_closed_terminal_ends_even_what_does_not_listen(tmp_path: Path) -> None:
    run, _ = toys(tmp_path, ann="deaf")
    with run:
        run.says("ann        ready")
        children = run.descendants()
        run.send(signal.SIGHUP)
        assert run.ended() == 0
        assert not any(lives(pid) for pid in children)


def test_the_second_ctrl_c_forces(tmp_path: Path) -> None:
    run, _ = toys(tmp_path, ann="deaf")
    with run:
        run.says("ann        ready")
        children = run.descendants()
        run.send(signal.SIGINT)
        run.send(signal.SIGTERM)
        assert run.ended() == 128 + signal.SIGTERM
        eventually(lambda: not any(lives(pid) for pid in children), 10.0, "the end of all")


@pytest.mark.parametrize("mood", ["steady", "deaf"])
def test_nothing_outlives_a_killed_launcher(tmp_path: Path, mood: str) -> None:
    run, _ = toys(tmp_path, ann=mood, ben="steady")
    with run:
        run.says("ann        ready")
        run.says("ben        ready")
        children = run.descendants()
        assert len(children) == 4
        run.send(signal.SIGKILL)
        eventually(lambda: not any(lives(pid) for pid in children), 10.0, "the end of all")


def test_a_held_process_does_not_outlive_a_killed_launcher(tmp_path: Path) -> None:
    run, endpoint = toys(tmp_path, ann="steady")
    with run:
        run.says("ann        ready")
        with Watch(endpoint) as watch:
            held = watch.pid("ann")
        os.kill(held, signal.SIGSTOP)
        run.send(signal.SIGKILL)
        eventually(lambda: not lives(held), 10.0, "the end of the held process")


def test_a_router_that_answers_already_is_used(tmp_path: Path) -> None:
    with processes.RouterProcess(tmp_path) as zenohd:
        run, _ = toys(tmp_path, zenohd.endpoint, ann="steady")
        with run, Watch(zenohd.endpoint) as watch:
            before = watch.until("ann", "ready")
            assert set(watch.processes()) == {"ann"}
            zenohd.kill()
            zenohd.start()
            watch.seen.clear()
            assert watch.until("ann", "ready") == before


def test_a_launcher_that_stood_still_blames_nobody(tmp_path: Path) -> None:
    run, endpoint = toys(tmp_path, ann="steady")
    with run, Watch(endpoint) as watch:
        victim = watch.pid("ann")
        os.kill(run.pid, signal.SIGSTOP)
        never(lambda: not lives(victim), during=2.0, what="the end of ann")
        watch.node.step()
        os.kill(run.pid, signal.SIGCONT)
        watch.seen.clear()
        assert watch.until("ann", "ready", "late", "down").state == "ready"
        assert watch.pid("ann") == victim


def test_a_service_whose_loop_hangs_is_replaced(tmp_path: Path) -> None:
    run, endpoint = toys(tmp_path, ann="silent")
    with run:
        run.says("ann        ready")
        with Watch(endpoint) as watch:
            watch.until("ann", "late")
            watch.until("ann", "starting", "down", restarts=1)
        run.says("no heartbeat for 3.")


def test_a_slow_start_is_no_hang(tmp_path: Path) -> None:
    run, endpoint = toys(tmp_path, ann="slow")
    with run:
        run.says("ann        ready")
        with Watch(endpoint) as watch:
            assert watch.until("ann", "ready").restarts == 0
        assert "late" not in run.text


def test_a_process_that_keeps_failing_is_given_up_loudly(tmp_path: Path) -> None:
    run, endpoint = toys(tmp_path, ann="crashing", ben="steady")
    with run:
        run.says("ben        ready")
        with Watch(endpoint) as watch:
            lost = watch.until("ann", "given_up")
        assert (lost.try_number, lost.max_tries) == (5, 5)
        run.says("ann        GIVEN UP (failure 5 of 5 within a minute): ended with code 1")
        assert run.descendants()


def test_refused_settings_end_the_run_with_one_line(tmp_path: Path) -> None:
    run, _ = toys(tmp_path, ann="refusing", ben="steady")
    with run:
        assert run.ended() == 2
        assert run.lines[-1] == (
            "pilotage up: ann ended with code 2: this toy refuses its settings"
        )
        assert "Traceback" not in run.text
