"""What the pictures of the simulated camera are like."""

from dataclasses import dataclass

from pilotage.robot.pinhole import PinholeCamera
from pilotage.robot.simulator.parameter_checks import refuse_negative, refuse_zero

LARGEST = 4096
"""Pixels along a side; more would hold up the robot."""


@dataclass(frozen=True)
class PictureParams:
    """A small camera on the robot that looks level."""

    width: int = 320
    height: int = 120
    """Pixels."""
    lens_height: float = 0.6
    """m above the floor."""
    frame_width: float = 0.07
    """Of the door frames, m."""
    exposure: float = 1.0
    """Shades are multiplied by this; what is then above 255 is burnt out."""
    noise: float = 2.5
    """Standard deviation of a pixel, grey levels."""
    samples: int = 2
    """Rays to a column."""

    def __post_init__(self) -> None:
        """Refuse what no camera has (ValueError)."""
        refuse_negative(self)
        refuse_zero(self, "width", "height", "lens_height", "exposure", "samples")
        if max(self.width, self.height) > LARGEST:
            raise ValueError(f"width and height must be {LARGEST} pixels at most")

    def lens(self, field_of_view: float) -> PinholeCamera:
        """Return how it projects, its full opening angle across being `field_of_view` rad."""
        return PinholeCamera.across(self.width, field_of_view)
