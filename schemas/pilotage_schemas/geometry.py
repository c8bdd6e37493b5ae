"""Poses and twists of the plane: metres, radians, seconds; x forward, y left (REP 103)."""

from typing import Annotated

from pydantic import Field

from pilotage_schemas.message import Finite, Part

Heading = Annotated[float, Field(ge=-3.1415926535897936, le=3.1415926535897936)]


class Pose2(Part):
    """A pose in the message's frame; `theta` counter-clockwise from +x, in [-pi, pi]."""

    x: Finite
    y: Finite
    theta: Heading


class Twist2(Part):
    """A velocity in the robot's own frame: forward and left in m/s, counter-clockwise in rad/s."""

    vx: Finite
    vy: Finite
    omega: Finite
