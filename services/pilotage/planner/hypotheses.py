"""A belief reduced to places: samples that nobody needs to tell apart become one; pure."""

import numpy as np
from numpy.typing import NDArray

from pilotage.core.angles import wrap
from pilotage.core.jit import kernel
from pilotage.planner.situation import Hypotheses

NEAR = 0.5
"""m: samples nearer than this are one place, as a pose is right that is off by less."""
ALIKE = float(np.deg2rad(15.0))
"""rad: and that point the same way."""
LIKELY = 0.95
"""Share of the belief that the likely places hold together."""


def merged(belief: Hypotheses, most: int = 400) -> Hypotheses:
    """Return the places of a belief, heaviest first; each is the mean of the samples around it.

    At most `most` places are kept: an unknown start may have thousands, and each weighs nothing.
    """
    order = np.argsort(-belief.weights, kind="stable")
    # What weighs nothing is no place, and has no mean.
    order = order[belief.weights[order] > 0.0]
    poses, weights = belief.poses[order], belief.weights[order]
    owners, count = _owners(poses, NEAR, ALIKE, most)
    kept = owners >= 0
    poses, weights, owners = poses[kept], weights[kept], owners[kept]
    mass = np.bincount(owners, weights, count)
    means = np.empty((count, 3))
    for axis in (0, 1):
        means[:, axis] = np.bincount(owners, weights * poses[:, axis], count) / mass
    firsts = poses[np.unique(owners, return_index=True)[1], 2]
    turns = wrap(poses[:, 2] - firsts[owners])
    means[:, 2] = wrap(firsts + np.bincount(owners, weights * turns, count) / mass)
    heaviest = np.argsort(-mass, kind="stable")
    return Hypotheses(means[heaviest], mass[heaviest] / mass.sum())


def likely(places: Hypotheses, share: float = LIKELY) -> Hypotheses:
    """Return the fewest places (heaviest first) that hold `share` of the belief together."""
    count = int(np.searchsorted(np.cumsum(places.weights), share * (1.0 - 1e-9))) + 1
    weights = places.weights[:count]
    return Hypotheses(places.poses[:count], weights / weights.sum())


@kernel
def _owners(
    poses: NDArray[np.float64], near: float, alike: float, most: int
) -> tuple[NDArray[np.int64], int]:
    """Return for each pose (n, 3), heaviest first, the place that it belongs to, and their number.

    A pose belongs to the heaviest place within reach; with none it is a place itself, or -1 once
    there are `most`.
    """
    owners = np.full(len(poses), -1, np.int64)
    centres = np.empty(most, np.int64)
    count = 0
    for i in range(len(poses)):
        for place in range(count):
            centre = poses[centres[place]]
            turn = abs(poses[i, 2] - centre[2]) % (2.0 * np.pi)
            apart = (poses[i, 0] - centre[0]) ** 2 + (poses[i, 1] - centre[1]) ** 2
            if apart <= near * near and min(turn, 2.0 * np.pi - turn) <= alike:
                owners[i] = place
                break
        if owners[i] < 0 and count < most:
            centres[count] = i
            owners[i] = count
            count += 1
    return owners, count


def warm_up() -> None:
    """Compile the kernel."""
    _owners(np.zeros((1, 3)), NEAR, ALIKE, 1)
