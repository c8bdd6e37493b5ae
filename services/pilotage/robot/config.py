"""Settings of the robot service."""

from typing import Annotated, Any, Literal

from pydantic import ConfigDict, Field

from pilotage.bus.deployment import ConfigPath, Settings


class RobotSettings(Settings):
    """Which robot is driven, and what it may do.

    `driver`: simulator, replay, or `package.module:Class` of a robot of one's own, which is
    called with `driver_settings` as keyword arguments. `world`, `seed`: of the simulator (seed
    None: the world's). `log`, `speed`, `loop`: of the replay; `max` is as fast as the service can.
    `wander`: begin by going about; None: a simulated robot does. `max_linear` [m/s],
    `max_angular` [rad/s], `acceleration` [m/s^2]: no command exceeds them, nor the driver's own.
    `command_timeout` [s]: velocity commands hold that long.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    driver: Annotated[str, Field(pattern=r"^(simulator|replay|[\w.]+:\w+)$")] = "simulator"
    driver_settings: dict[str, Any] = Field(default_factory=dict)
    world: ConfigPath | None = None
    seed: Annotated[int, Field(ge=0)] | None = None
    log: ConfigPath | None = None
    speed: Annotated[float, Field(ge=1.0, le=1000.0)] | Literal["max"] = 1.0
    loop: bool = False
    wander: bool | None = None
    max_linear: Annotated[float, Field(gt=0.0, le=10.0)] = 0.6
    max_angular: Annotated[float, Field(gt=0.0, le=20.0)] = 1.6
    acceleration: Annotated[float, Field(gt=0.0, le=20.0)] = 0.8
    command_timeout: Annotated[float, Field(gt=0.0, le=0.5)] = 0.5
