"""What the localizer is asked to do: where to begin, and how to localize."""

from collections.abc import Callable

import numpy as np

from pilotage.bus.fabric import RefusedError
from pilotage.bus.node import Node
from pilotage.localizer.localization import Localization
from pilotage.localizer.messages import pose_array
from pilotage.localizer.method import LocalizationMethod
from pilotage.localizer.methods import NoMethodError
from pilotage.localizer.takeover import Takeover
from pilotage_schemas.commands import Done, Nothing, SetAlgorithm, SetMethod, SetPose

METHOD_WORK_S = 60.0
"""Limit for changing the method: it may need other tables of the map."""

ASSUMED = np.diag([0.25, 0.25, np.deg2rad(15.0) ** 2])
"""Covariance (3, 3) of a pose that is given without one."""


class Queries:
    """Answers the localizer's queries.

    `after` is what follows a change: publish the belief; let what is known now outlive a crash,
    and nothing else.
    """

    def __init__(
        self,
        node: Node,
        at: Localization,
        takeover: Takeover,
        after: tuple[Callable[[], None], Callable[[], None]],
    ) -> None:
        self._node = node
        self._at = at
        self._takeover = takeover
        self._show, self._keep = after
        node.answer("set_pose", self.set_pose)
        node.answer("relocalize", self.relocalize)
        node.answer("set_algorithm", self.set_algorithm)
        node.answer("set_method", self.set_method)

    def set_pose(self, request: SetPose) -> Done:
        """Begin anew from a pose."""
        covariance = ASSUMED if request.covariance is None else request.covariance
        method = self._running()
        try:
            method.start_at(pose_array(request.pose), covariance)
        except (ValueError, np.linalg.LinAlgError) as error:
            raise RefusedError(str(error)) from error
        self._show()
        self._keep()
        return Done(detail="localizing from the given pose")

    def relocalize(self, _request: Nothing) -> Done:
        """Forget everything."""
        self._running().start_anywhere()
        self._show()
        self._keep()
        return Done(detail="localizing from an unknown pose")

    def set_algorithm(self, request: SetAlgorithm) -> Done:
        """Choose M1 or M2."""
        self._running()
        self._at.choose_algorithm(request.algorithm, request.recovery_weight)
        return Done(detail=f"algorithm {request.algorithm.upper()}")

    def set_method(self, request: SetMethod) -> Done:
        """Localize in another way, from what is known; without a map from the next one on."""
        try:
            with self._node.busy(METHOD_WORK_S):
                self._at.choose_method(request.method)
        except NoMethodError as error:
            raise RefusedError(str(error)) from error
        self._show()
        return Done(detail=f"localizing by {request.method}")

    def _running(self) -> LocalizationMethod:
        self._takeover.require_own_pose()
        if self._at.method is None:
            raise RefusedError("there is no map yet")
        return self._at.method
