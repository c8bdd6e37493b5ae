"""Active localization by landmarks, to the letter: Liu et al. 2008, section 2; pure.

Where to go (eq. 4 to 8), how far (eq. 9) and where to look (eq. 10), decided anew at every step
from nothing but the belief.
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from pilotage.core.grid import OccupancyMap
from pilotage.planner.hypotheses import merged
from pilotage.planner.information import drawn, expected_gain
from pilotage.planner.landmark_targets import TargetParams, survey
from pilotage.planner.landmark_views import Camera, Sharpness, expected_log_likelihoods, views_from
from pilotage.planner.potential_field import Sources
from pilotage.planner.sample_spacing import sample_spacing
from pilotage.planner.situation import Hypotheses

Array = NDArray[np.float64]
Move = NDArray[np.float64]
"""A displacement (2,) in base_link [m]: the robot dog walks any way without turning (eq. 9)."""
FULL_TURN = (0.0, float(np.pi))


@dataclass(frozen=True)
class ActiveParams:
    """How decisions are made.

    `step`: v_max dt, the longest way of a step [m]; `alpha`: what a metre costs [bit] (eq. 6);
    `noise`: standard deviation of a displacement, as a share of it (section 3.1); `gazes`:
    pointings compared, all around;
    `samples`, `truths`: how many samples of the belief are weighed, and how many of these say
    what would be seen.
    """

    step: float = 0.10
    alpha: float = 0.1
    noise: float = 0.1
    gazes: int = 16
    samples: int = 250
    truths: int = 24
    camera: Camera = field(default_factory=Camera)
    random_targets: int = 6


@dataclass(frozen=True)
class Decision:
    """What to do next, and why.

    `candidates` (n, 2) in the map frame, what each is expected to tell [bit] and how far it is
    [m], (n,); `target`: the one chosen; `here` (3,): where the robot seems to be; `move`: the
    next step; `gaze`: where to point the camera then, off the heading [rad].
    """

    candidates: Array
    gains: Array
    travels: Array
    target: int
    here: Array
    move: Move
    gaze: float


class LandmarkLocalization:
    """Decides for one field of landmarks."""

    def __init__(self, sources: Sources, world: OccupancyMap, params: ActiveParams) -> None:
        self.sources = sources
        self.params = params
        self.field = survey(sources, world, TargetParams(params.camera.half_view))
        self._gazes = np.linspace(-np.pi, np.pi, params.gazes, endpoint=False)

    def decide(self, belief: Hypotheses, rng: np.random.Generator) -> Decision:
        """Return where to go, how far now, and where to look then."""
        here = merged(belief).best
        samples = self._drawn(belief, rng)
        candidates = self.field.around(here[:2], self.params.random_targets, rng)
        moves = [move_to(here, place) for place in candidates]
        gains = np.array([self._gains(samples, move, [FULL_TURN])[0] for move in moves])
        travels = np.array([float(np.hypot(*move)) for move in moves])
        target = int(np.argmax(gains - self.params.alpha * travels))
        move = shortened(moves[target], self.params.step)
        gaze = self._best_gaze(samples, move)
        return Decision(candidates, gains, travels, target, here, move, gaze)

    def _best_gaze(self, belief: Hypotheses, move: Move) -> float:
        """Return the pointing of the camera that tells most after a move (eq. 10)."""
        half = self.params.camera.half_view
        gains = self._gains(belief, move, [(float(gaze), half) for gaze in self._gazes])
        return float(self._gazes[int(np.argmax(gains))])

    def _gains(
        self, belief: Hypotheses, move: Move, windows: list[tuple[float, float]]
    ) -> list[float]:
        """Return H(l_t) - H(l_t+1) [bit] of a look through each window after a move.

        Eq. 7 and 8 say `sum over l' of p(s | l) p(l | l', a) Bel(l')`. The sum over what the move
        may do is taken first: it blurs what is seen. (Samples moved by chance would spread, and
        as entropy does not see weighed samples spread, a long way would seem to tell more.)
        """
        params = self.params
        after = predicted(belief, move, np.zeros((len(belief.poses), 2)))
        views = views_from(self.sources, after.poses)
        truths = drawn(belief.weights, params.truths)
        sharpness = self._sharpness(belief, move)
        return [
            expected_gain(
                expected_log_likelihoods(self.sources, views, truths, window, sharpness),
                belief.weights,
            )
            for window in windows
        ]

    def _sharpness(self, belief: Hypotheses, move: Move) -> Sharpness:
        """Return how sharply the camera tells samples of the belief apart after a move.

        No more finely than the samples lie: else to know one of two like places better would
        seem worth more than to know which of them it is.
        """
        spacing, camera = sample_spacing(belief), self.params.camera
        blur = float(np.hypot(spacing[:2].max(), self.params.noise * np.hypot(*move)))
        around = float(np.hypot(camera.bearing_error, spacing[2]))
        # A pose may not be told by what is just in or out of view: that rim is too thin to aim by.
        return Sharpness(camera.range_error, around, camera.outlier, blur, rim=around)

    def _drawn(self, belief: Hypotheses, rng: np.random.Generator) -> Hypotheses:
        """Return so many samples of the belief as are weighed, all of the same weight."""
        count = min(self.params.samples, len(belief.weights))
        chosen = rng.permutation(drawn(belief.weights, count))
        return Hypotheses(belief.poses[chosen], np.full(count, 1.0 / count))


def move_to(here: Array, place: Array) -> Move:
    """Return the move from a pose (3,) to a place (2,) of the map frame."""
    dx, dy = place - here[:2]
    cos, sin = np.cos(here[2]), np.sin(here[2])
    return np.array([cos * dx + sin * dy, cos * dy - sin * dx])


def shortened(move: Move, step: float) -> Move:
    """Return the whole move if it is no longer than a step, else a step along it (eq. 9)."""
    way = float(np.hypot(*move))
    return move if way <= step else move * (step / way)


def predicted(belief: Hypotheses, move: Move, errors: Array) -> Hypotheses:
    """Return the belief after a move (eq. 7), each sample with an error of its own.

    `errors` (n, 2): ahead and aside, as shares of the way.
    """
    steps = move + errors * np.hypot(*move)
    cos, sin = np.cos(belief.poses[:, 2]), np.sin(belief.poses[:, 2])
    x = belief.poses[:, 0] + cos * steps[:, 0] - sin * steps[:, 1]
    y = belief.poses[:, 1] + sin * steps[:, 0] + cos * steps[:, 1]
    return Hypotheses(np.column_stack([x, y, belief.poses[:, 2]]), belief.weights)
