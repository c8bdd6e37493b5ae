"""High-level features that nodes are bound to: corners, doors and passages (Zhuang et al. 2005)."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pilotage.core import se2

FeatureKind = Literal["corner", "door", "passage"]
KINDS: tuple[FeatureKind, ...] = ("corner", "door", "passage")


@dataclass(frozen=True)
class Features:
    """Features in one frame.

    `kinds` (n,): index into KINDS. `poses` (n, 3): a corner's tip with the direction that its
    opening faces (the bisector into free space); a door's or a passage's middle with the direction
    of walking through it (either way: only its axis counts). `widths` (n,) m, NaN for corners.
    `covariances` (n, 2, 2) of the positions, m^2.
    """

    kinds: NDArray[np.int64]
    poses: NDArray[np.float64]
    widths: NDArray[np.float64]
    covariances: NDArray[np.float64]

    def __len__(self) -> int:
        return len(self.kinds)

    @classmethod
    def none(cls) -> "Features":
        """Return no features."""
        nothing = np.empty(0)
        return cls(np.empty(0, np.int64), np.empty((0, 3)), nothing, np.empty((0, 2, 2)))

    @classmethod
    def joined(cls, parts: "list[Features]") -> "Features":
        """Return the features of all parts."""
        each = [cls.none(), *parts]
        return cls(
            np.concatenate([part.kinds for part in each]),
            np.concatenate([part.poses for part in each]),
            np.concatenate([part.widths for part in each]),
            np.concatenate([part.covariances for part in each]),
        )

    def chosen(self, which: NDArray[np.bool_] | NDArray[np.int64]) -> "Features":
        """Return those that a mask (n,) or indices (k,) choose."""
        return Features(
            self.kinds[which], self.poses[which], self.widths[which], self.covariances[which]
        )

    def moved(self, outer_from_inner: ArrayLike) -> "Features":
        """Return the same features in the outer frame of a pose (3,) that is known exactly."""
        if len(self) == 0:
            return self
        pose = np.asarray(outer_from_inner, float)
        cos, sin = np.cos(pose[2]), np.sin(pose[2])
        rotation = np.array([[cos, -sin], [sin, cos]])
        turned = rotation @ self.covariances @ rotation.T
        return Features(self.kinds, se2.compose(pose, self.poses), self.widths, turned)
