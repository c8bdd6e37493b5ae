"""How the simulated robot is built, as it tells the bus."""

from collections.abc import Iterator

import numpy as np

from pilotage.robot.simulator.simulation import Simulation
from pilotage_schemas.geometry import Pose2
from pilotage_schemas.sensors import RobotDescription, SensorMount

COMMANDS = ("forward", "backward", "turn", "velocity", "stop", "wander", "kidnap")
LOOK = "look"
"""The command of a robot with a camera on a joint: it heeds `gaze_command`."""

RIM_CORNERS = 24


def description_of(simulation: Simulation) -> RobotDescription:
    """Return body, sensors, limits and commands; unstamped."""
    drive = simulation.params.drive
    corners = np.linspace(0.0, 2.0 * np.pi, RIM_CORNERS, endpoint=False)
    footprint = drive.radius * np.stack([np.cos(corners), np.sin(corners)], axis=1)
    return RobotDescription(
        stamp_ns=0,
        frame_id="base_link",
        name="Simulated robot",
        driver="simulator",
        footprint=footprint.astype(np.float32),
        mounts=tuple(_mounts(simulation)),
        max_linear=drive.max_linear,
        max_angular=drive.max_angular,
        commands=COMMANDS if simulation.camera is None else (*COMMANDS, LOOK),
    )


def _mounts(simulation: Simulation) -> Iterator[SensorMount]:
    yield SensorMount(frame_id="laser", kind="laser", pose=_ahead(simulation.params.laser.mount_x))
    yield SensorMount(frame_id="base_link", kind="sonar", pose=_ahead(0.0))
    yield SensorMount(frame_id="base_link", kind="compass", pose=_ahead(0.0))
    yield SensorMount(frame_id="base_link", kind="bumper", pose=_ahead(0.0))
    if simulation.camera is not None:
        # The joint, not the lens: its pose on the robot is the same wherever the camera points.
        mount_x = simulation.camera.params.mount_x
        yield SensorMount(frame_id="camera", kind="camera", pose=_ahead(mount_x))


def _ahead(x: float) -> Pose2:
    return Pose2(x=x, y=0.0, theta=0.0)
