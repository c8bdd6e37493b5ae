"""Pose tracking on walls by an extended Kalman filter (Zhuang et al. 2005, methods D); pure.

A line's normal form makes its measurement nearly linear: seen from a pose x, y, theta a wall alpha,
rho of the map lies at alpha - theta, rho - x cos(alpha) - y sin(alpha). A corner is a point. What
is not seen stays unknown: along a bare corridor no wall says how far the robot has come, and the
covariance keeps and shows what odometry makes of that.
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.core.angles import wrap
from pilotage.core.corners import Corners
from pilotage.core.lines import Lines
from pilotage.localizer.dead_reckoning import grown
from pilotage.localizer.ekf_walls import Walls
from pilotage.localizer.line_ekf_kernels import Gate, Pieces, match_in_turn
from pilotage.localizer.line_ekf_update import Pairs, corrected, no_pairs
from pilotage.localizer.motion_spread import MotionSpread

Array = NDArray[np.float64]


@dataclass(frozen=True)
class GaussianPose:
    """A pose `mean` (3,) map_from_base with covariance (3, 3) over x, y, theta, map frame."""

    mean: Array
    covariance: Array


POOR = 0.5
"""Share of what is seen that is matched, by length, below which odometry is in doubt."""

GATE = Gate(
    squared=9.21,
    facing=float(np.deg2rad(30.0)),
    overlap=0.5,
    slack=0.15,
    clutter=-float(np.log(20.0 * np.pi)),
)
"""Chi-squared of two degrees of freedom at 99 %; as likely as any is an unmapped line in all
directions and 10 m of distance."""


@dataclass(frozen=True)
class LineEkfParams:
    """Parameters of the filter.

    `gate`: what a seen line and one of the map must agree in. `corner_gate`, `corner_facing`
    [rad]: the same of corners. `reach` [m]: farther walls of the map are not looked at. `wide` [m],
    `wide_turn` [rad]: a pose that is known no better is tried from several starts. `slip` [m, rad]:
    by how much (one sigma) wheels may have slipped where hardly anything matches; None: never.
    """

    motion: MotionSpread = field(default_factory=MotionSpread)
    gate: Gate = GATE
    corner_gate: float = 9.21
    corner_facing: float = float(np.deg2rad(40.0))
    reach: float = 12.0
    wide: float = 0.25
    wide_turn: float = float(np.deg2rad(6.0))
    slip: tuple[float, float] | None = (0.1, 0.1)


@dataclass(frozen=True)
class EkfStep:
    """The belief after one cycle, what it was predicted to be, and the walls that were matched.

    `pairs` index the lines and corners that were seen and those of `near`, the map's walls about
    the robot.
    """

    belief: GaussianPose
    predicted: GaussianPose
    near: Walls
    pairs: Pairs


def track(
    before: GaussianPose, increment: Array, seen: Walls, known: Walls, params: LineEkfParams
) -> EkfStep:
    """Return the belief after one cycle.

    Args:
        before: the belief.
        increment: (3,) motion since then by odometry, in the robot's frame of then.
        seen: walls in base_link.
        known: the map's, in map.
        params: of the filter.
    """
    predicted = predict(before, increment, params.motion)
    near = known.near(predicted.mean, params.reach)
    pairs = match(predicted, seen, near, params)
    if params.slip is not None and pairs.matched_share(seen) < POOR:
        predicted, pairs = _slipped(predicted, pairs, (seen, near), params)
    return EkfStep(update(predicted, seen, near, pairs), predicted, near, pairs)


def predict(before: GaussianPose, increment: Array, motion: MotionSpread) -> GaussianPose:
    """Return a pose moved by odometry's increment (3,), with what that makes uncertain."""
    covariance = grown(before.mean, before.covariance, increment, motion)
    return GaussianPose(se2.compose(before.mean, increment), covariance)


def match(predicted: GaussianPose, seen: Walls, near: Walls, params: LineEkfParams) -> Pairs:
    """Return which seen wall is which of the map.

    A seen line is one of the map's at most, for it is one surface. One of the map's may be several
    seen ones: doors, people and furniture cut a wall to pieces, and each says where it is.
    """
    partners, aimed = match_lines(predicted, seen.lines, near.lines, params)
    corners = match_corners(aimed, seen.corners, near.corners, params)
    return Pairs(_listed(partners), corners, _is_new(corners, seen.corners, partners))


def match_lines(
    predicted: GaussianPose, seen: Lines, near: Lines, params: LineEkfParams
) -> tuple[NDArray[np.int64], GaussianPose]:
    """Return for each seen line (n,) the map's that is nearest by Mahalanobis distance, or -1.

    And the pose that they lead to. One that is hardly known is tried from several starts; the
    likeliest pairs count.
    """
    order = np.argsort(-seen.lengths, kind="stable")
    what = _pieces(seen.chosen(order)), _pieces(near)
    best, aimed, most = np.empty(0, np.int64), predicted, -np.inf
    for mean, covariance, log_prior in _starts(predicted, params):
        found, likelihood, *end = match_in_turn(mean, covariance, *what, params.gate)
        if likelihood + log_prior > most:
            best, aimed, most = found, GaussianPose(*end), likelihood + log_prior
    partners = np.empty(len(seen), np.int64)
    partners[order] = best
    return partners, aimed


def update(predicted: GaussianPose, seen: Walls, near: Walls, pairs: Pairs) -> GaussianPose:
    """Return the pose corrected by all pairs at once."""
    return GaussianPose(*corrected(predicted.mean, predicted.covariance, (seen, near), pairs))


def _slipped(
    predicted: GaussianPose, pairs: Pairs, walls: tuple[Walls, Walls], params: LineEkfParams
) -> tuple[GaussianPose, Pairs]:
    """Return the prediction and the pairs, as they are or, if that explains far more, slipped."""
    if params.slip is None:
        return predicted, pairs
    way, turn = params.slip
    wider = GaussianPose(predicted.mean, predicted.covariance + np.diag([way, way, turn]) ** 2)
    again = match(wider, *walls, params)
    share = again.matched_share(walls[0])
    is_better = share >= POOR and share >= 2.0 * pairs.matched_share(walls[0])
    return (wider, again) if is_better else (predicted, pairs)


def _starts(predicted: GaussianPose, params: LineEkfParams) -> list[tuple[Array, Array, float]]:
    """Return poses (3,) to match from, the covariance (3, 3) and the log prior of each.

    The predicted one, and where it is hardly known others along the axes in question.
    """
    widths = np.array([params.wide, params.wide, params.wide_turn])
    scaled = predicted.covariance / np.outer(widths, widths)
    variances, axes = np.linalg.eigh((scaled + scaled.T) / 2.0)
    starts = [(predicted.mean, predicted.covariance, 0.0)]
    for axis, variance in enumerate(variances):
        if variance > 1.0:
            along = widths * axes[:, axis] * np.sqrt(variance)
            starts = [start for one in starts for start in _spread_out(one, along)]
    return starts


def _spread_out(one: tuple[Array, Array, float], along: Array) -> list[tuple[Array, Array, float]]:
    """Return five starts for one, a standard deviation `along` (3,) apart, half as uncertain."""
    mean, covariance, log_prior = one
    narrowed = covariance - 0.75 * np.outer(along, along)
    return [
        (mean + step * along, narrowed, log_prior - 0.5 * step**2)
        for step in (-2.0, -1.0, 0.0, 1.0, 2.0)
    ]


def match_corners(
    aimed: GaussianPose, seen: Corners, near: Corners, params: LineEkfParams
) -> NDArray[np.int64]:
    """Return pairs (k, 2) of a seen corner and the map's nearest that opens the same way."""
    if not len(seen) or not len(near):
        return no_pairs()
    in_map = se2.compose(aimed.mean, seen.poses)
    off = in_map[:, None] - near.poses[None]
    away = in_map[:, :2] - aimed.mean[:2]
    jacobian = np.zeros((len(away), 2, 3))
    jacobian[:, 0, 0] = jacobian[:, 1, 1] = 1.0
    jacobian[:, 0, 2], jacobian[:, 1, 2] = -away[:, 1], away[:, 0]
    turned = _rotation(aimed.mean[2])
    spread = jacobian @ aimed.covariance @ jacobian.transpose(0, 2, 1)
    spread = spread + turned @ seen.covariances @ turned.T
    squared = _squared(off[..., :2], spread[:, None] + near.covariances[None])
    turn: Array = wrap(off[..., 2])
    is_alike = seen.convex[:, None] == near.convex[None]
    fits = is_alike & (np.abs(turn) <= params.corner_facing)
    squared = np.where(fits, squared, np.inf)
    partners = np.argmin(squared, axis=1)
    is_near = squared[np.arange(len(partners)), partners] <= params.corner_gate
    return _listed(np.where(is_near, partners, -1))


def _is_new(
    corners: NDArray[np.int64], seen: Corners, partners: NDArray[np.int64]
) -> NDArray[np.bool_]:
    """Say of pairs of corners (k, 2) whether they tell what the matched lines do not.

    A corner is where two lines meet: if both are matched it would be counted twice.
    """
    ours = seen.lines[corners[:, 0]]
    is_new: NDArray[np.bool_] = np.any(partners[ours] < 0, axis=1)
    return is_new


def _squared(off: Array, covariances: Array) -> Array:
    """Return Mahalanobis distances squared (...) of (..., 2) by covariances (..., 2, 2)."""
    a, b, d = covariances[..., 0, 0], covariances[..., 0, 1], covariances[..., 1, 1]
    x, y = off[..., 0], off[..., 1]
    squared: Array = (d * x * x - 2.0 * b * x * y + a * y * y) / (a * d - b * b)
    return squared


def _rotation(theta: float) -> Array:
    cos, sin = np.cos(theta), np.sin(theta)
    return np.array([[cos, -sin], [sin, cos]])


def _listed(partners: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return pairs (k, 2) of seen and known from partners (n,), -1 for none."""
    seen = np.flatnonzero(partners >= 0)
    return np.stack([seen, partners[seen]], axis=1)


def _pieces(lines: Lines) -> Pieces:
    return Pieces(*(np.ascontiguousarray(part) for part in _parts(lines)))


def _parts(lines: Lines) -> tuple[Array, Array, Array]:
    return lines.ends, lines.polar, lines.covariances
