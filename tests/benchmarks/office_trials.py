"""How soon the demo knows where it is: the real services on a fake bus, faster than real time.

    .venv/bin/python tests/benchmarks/office_trials.py [TRIALS] [DEPLOYMENT]

Each trial starts at a random place of the office, unknown to the localizer, wanders until it is
localized, is kidnapped to another random place, and wanders until it is localized again. Printed
per trial: seconds of robot time to both, and the share of estimates that were wrong (off by more
than 1 m or 30 degrees) while they said `localized`.
"""

import sys
import time
from pathlib import Path

import numpy as np

from pilotage.bus.clock import HandClock
from pilotage.bus.deployment import Deployment, read_deployment, service_settings
from pilotage.bus.fake import FakeFabric
from pilotage.bus.node import Node
from pilotage.localizer.config import LocalizerSettings
from pilotage.localizer.service import LocalizerService
from pilotage.mapper.config import MapperSettings
from pilotage.mapper.service import MapperService
from pilotage.robot.config import RobotSettings
from pilotage.robot.service import RobotService
from pilotage_schemas.commands import Kidnap
from pilotage_schemas.localization import PoseEstimate
from pilotage_schemas.sensors import GroundTruth

STEP_S = 0.02
PATIENCE_S = 180.0
DEMO = Path(__file__).resolve().parents[2] / "deploy" / "config" / "demo.yaml"


class Trial:
    """The demo's services on a fake bus, and what the localizer says beside the truth."""

    def __init__(self, deployment: Deployment, seed: int) -> None:
        self.clock = HandClock()
        self.fabric = FakeFabric()
        self.errors: list[tuple[float, float]] = []
        self._estimate: PoseEstimate | None = None
        self._truth: dict[int, GroundTruth] = {}
        self._deployment = deployment
        self.robot = self._node("robot")
        self._localizer_node = self._node("localizer")
        self.watcher = self._node("watcher_of_trials")
        LocalizerService(
            service_settings(deployment, "localizer", LocalizerSettings),
            self._localizer_node,
            deployment,
        )
        mapper = self._node("mapper")
        MapperService(service_settings(deployment, "mapper", MapperSettings), mapper, deployment)
        settings = service_settings(deployment, "robot", RobotSettings)
        self._service = RobotService(
            settings.model_copy(update={"seed": seed}), self.robot, deployment
        )
        self._service.driver.__enter__()
        self._service.begin()
        self.watcher.subscribe("pose", self._take_estimate)
        self.watcher.subscribe("ground_truth", self._take_truth)

    def run_until_localized(self, patience: float) -> float | None:
        """Return the seconds until the estimate is localized and right, None if it never is."""
        begun = self.clock.monotonic()
        while self.clock.monotonic() - begun < patience:
            self._step()
            if self.errors and self._is_right(*self.errors[-1]):
                return self.clock.monotonic() - begun
        return None

    def run_for(self, seconds: float) -> None:
        """Let the robot wander on."""
        until = self.clock.monotonic() + seconds
        while self.clock.monotonic() < until:
            self._step()

    def kidnap(self) -> None:
        """Carry the robot to a random place; what was believed before no longer counts."""

        def answer() -> None:
            self.robot.step()

        self.fabric.pump = answer
        self.watcher.ask("kidnap", Kidnap())
        self.fabric.pump = lambda: None
        self.errors.append((np.inf, np.inf))

    def wrong_share(self) -> float:
        """Return the share of localized estimates that are off by more than 1 m or 30 degrees."""
        told = [e for e in self.errors if np.isfinite(e[0])]
        return float(np.mean([d > 1.0 or t > np.pi / 6.0 for d, t in told])) if told else 0.0

    @staticmethod
    def _is_right(distance: float, turn: float) -> bool:
        return distance < 0.5 and turn < np.deg2rad(15.0)

    def _step(self) -> None:
        self.clock.advance(STEP_S)
        for node in (self.robot, self._localizer_node, self.watcher):
            node.step()

    def _node(self, name: str) -> Node:
        return Node(name, "demo", self.fabric, self.clock)

    def _take_truth(self, truth: GroundTruth) -> None:
        self._truth = {truth.stamp_ns: truth}

    def _take_estimate(self, estimate: PoseEstimate) -> None:
        truth = self._truth.get(estimate.stamp_ns)
        if truth is None or estimate.state != "localized":
            return
        distance = np.hypot(estimate.pose.x - truth.pose.x, estimate.pose.y - truth.pose.y)
        turn = abs((estimate.pose.theta - truth.pose.theta + np.pi) % (2.0 * np.pi) - np.pi)
        self.errors.append((float(distance), float(turn)))


def main() -> None:
    """Run the trials and print a line for each and one for all."""
    trials = int(sys.argv[1]) if len(sys.argv) > 1 else 10
    deployment = read_deployment(Path(sys.argv[2]) if len(sys.argv) > 2 else DEMO)
    firsts, seconds, wrong = [], [], []
    for seed in range(trials):
        started = time.process_time()
        trial = Trial(deployment, seed)
        firsts.append(trial.run_until_localized(PATIENCE_S) or np.inf)
        trial.run_for(10.0)
        trial.kidnap()
        seconds.append(trial.run_until_localized(PATIENCE_S) or np.inf)
        trial.run_for(10.0)
        wrong.append(trial.wrong_share())
        robot_time = trial.clock.monotonic() - HandClock().seconds
        print(
            f"{seed}: localized after {firsts[-1]:.1f} s, after the kidnapping {seconds[-1]:.1f} s,"
            f" wrong while localized {wrong[-1]:.4f},"
            f" processor {100 * (time.process_time() - started) / robot_time:.0f} % of robot time",
            flush=True,
        )
    for name, values in (("unknown start", firsts), ("kidnapping", seconds)):
        print(f"{name}: median {np.median(values):.1f} s, most {np.max(values):.1f} s")
    print(f"wrong while localized: {np.mean(wrong):.4f} of the estimates")


if __name__ == "__main__":
    main()
