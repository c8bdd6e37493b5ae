"""Whether a localizer is right, track after track, and whether it knows it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pilotage.core.angles import wrap
from pilotage.core.grid import OccupancyMap
from pilotage.experiments.clutter import Condition, altered
from pilotage.experiments.tracks import Track, drive_through
from pilotage.localizer.confidence import Signs
from pilotage.localizer.log_run import LogEstimate, LogSensors, localize_log
from pilotage.localizer.method import LocalizationMethod

RIGHT_WAY, RIGHT_TURN = 0.5, float(np.deg2rad(15.0))
"""What `confidence` is the probability of: nearer than this [m, rad]."""

WRONG_WAY, WRONG_TURN = 1.0, float(np.deg2rad(30.0))
"""An estimate farther off than this [m, rad] is wrong."""


@dataclass(frozen=True)
class Outcome:
    """What a localizer said after each of n scans of a track, beside the truth.

    `way` [m] and `turn` [rad] (n,) are its errors; `localized` (n,) where it said so, `ambiguous`
    likewise; `confidence` (n,), and the signs (n) that it came from.
    """

    way: NDArray[np.float64]
    turn: NDArray[np.float64]
    localized: NDArray[np.bool_]
    ambiguous: NDArray[np.bool_]
    confidence: NDArray[np.float64]
    signs: list[Signs | None]
    kidnapped: int | None

    @property
    def right(self) -> NDArray[np.bool_]:
        """Where (n,) the estimate is as near as `confidence` promises."""
        return (self.way <= RIGHT_WAY) & (self.turn <= RIGHT_TURN)

    @property
    def wrong(self) -> NDArray[np.bool_]:
        """Where (n,) the estimate was called localized and is far off."""
        return self.localized & ((self.way > WRONG_WAY) | (self.turn > WRONG_TURN))

    @property
    def ends_right(self) -> bool:
        """Whether the last estimate is localized and right."""
        return bool(self.localized[-1] and self.right[-1])

    @property
    def ends_ambiguous(self) -> bool:
        """Whether the last estimate admits that there are several places."""
        return bool(self.ambiguous[-1])

    def scans_to_fix(self, start: int = 0) -> int | None:
        """Return how many scans from `start` on it took to be localized and right."""
        fixed = np.nonzero((self.localized & self.right)[start:])[0]
        return int(fixed[0]) + 1 if len(fixed) else None


def simulated_track(
    world: OccupancyMap, condition: Condition, lengths: tuple[int, ...], seed: int
) -> Track:
    """Return a track through a building that differs from its map as the condition says."""
    rng = np.random.default_rng(seed)
    return drive_through(altered(world, condition, rng), condition, lengths, rng)


def run_trial(localizer: LocalizationMethod, track: Track) -> Outcome:
    """Let a localizer follow a track from an unknown start."""
    localizer.start_anywhere()
    estimates = list(localize_log(track.log(), localizer, LogSensors()))
    return outcome_of(estimates, track)


def outcome_of(estimates: list[LogEstimate], track: Track) -> Outcome:
    """Return what a run of estimates, one per scan, is worth."""
    poses = np.array([estimate.pose for estimate in estimates])
    states = np.array([estimate.estimate.state for estimate in estimates])
    return Outcome(
        way=np.hypot(*(poses - track.truth)[:, :2].T),
        turn=np.abs(wrap(poses[:, 2] - track.truth[:, 2])),
        localized=states == "localized",
        ambiguous=states == "ambiguous",
        confidence=np.array([estimate.estimate.confidence for estimate in estimates]),
        signs=[estimate.estimate.signs for estimate in estimates],
        kidnapped=track.kidnapped,
    )
