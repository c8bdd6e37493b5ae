"""What the localizer believes."""

from typing import Annotated, Literal

from pydantic import Field

from pilotage_schemas.arrays import Float32Array, Float64Array, Nd
from pilotage_schemas.geometry import Pose2
from pilotage_schemas.mapping import Resolution
from pilotage_schemas.message import Fraction, Message, Name, NonNegative, Part

State = Literal["unknown", "ambiguous", "localized", "lost"]
Covariance = Annotated[Float64Array, Nd("float64", "3,3")]


class PoseEstimate(Message):
    """The best pose of base_link in `map`; when not `localized`, the best of several.

    `confidence` is the calibrated probability that the true pose lies within 0.5 m and
    15 degrees. Covariance over x, y, theta in m^2, m rad, rad^2, map frame.
    """

    pose: Pose2
    covariance: Covariance
    state: State
    confidence: Fraction


class Mode(Part):
    """One place the robot could be, with the share of the belief that lies there."""

    mass: Fraction
    pose: Pose2
    covariance: Covariance


class Marginal(Part):
    """Probability per cell of x and y, headings summed; `origin` as in OccupancyGrid."""

    resolution: Resolution
    origin: Pose2
    mass: Annotated[Float32Array, Nd("float32", "rows,cols")]


class Belief(Message):
    """The distribution over poses, reduced to what others need.

    `samples` are x, y, theta and weight (summing to one) of the heaviest states; `modes` are
    sorted by mass; `entropy` in bits; `matched` the share of beams that agree with the map at
    the best mode, or None before the first scan.
    """

    map_id: Name
    method: Name
    samples: Annotated[Float32Array, Nd("float32", "n,4")]
    entropy: NonNegative
    modes: Annotated[tuple[Mode, ...], Field(max_length=64, strict=False)]
    marginal: Marginal | None = None
    matched: Fraction | None = None
