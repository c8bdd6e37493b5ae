"""Takes a pose that the topology service found at a node, if whoever localizes needs it."""

from collections.abc import Callable

import numpy as np

from pilotage.bus.endpoints import RejectedError
from pilotage.bus.node import Node
from pilotage.core import se2
from pilotage.core.odometry_buffer import OdometryBuffer
from pilotage.localizer.localization import Localization
from pilotage.localizer.messages import pose_array
from pilotage.localizer.method import LocalizationMethod
from pilotage.localizer.second_chance import Found, takes
from pilotage.localizer.takeover import Takeover
from pilotage_schemas.topology import Relocalization

EXTRAPOLATION_NS = 100_000_000


class SecondChance:
    """Listens to `relocalization`; `after` is what follows a new beginning."""

    def __init__(
        self,
        node: Node,
        at: Localization,
        takeover: Takeover,
        odometry: OdometryBuffer,
        after: Callable[[], None],
    ) -> None:
        self._node = node
        self._at = at
        self._takeover = takeover
        self._odometry = odometry
        self._after = after
        node.subscribe("relocalization", self.take)

    def take(self, message: Relocalization) -> None:
        """Begin at the pose of now that was found, unless the belief is better off without."""
        method = self._at.method
        is_of_this_map = message.map_id in ("", self._at.map_id)
        if method is None or self._takeover.is_silent or not is_of_this_map:
            return
        then = self._odometry.pose_at(message.stamp_ns, EXTRAPOLATION_NS)
        now = self._odometry.latest()
        if then is None or now is None:
            raise RejectedError("relocalization", "no odometry is known of when it was found")
        found = Found(pose_array(message.pose), message.covariance, message.matched)
        moved = found.moved(se2.between(then, now[1]))
        shift = se2.between(method.estimate.pose, method.pose_at(now[1]))
        if takes(method.estimate, shift, moved):
            self._begin(method, moved, message.node)

    def _begin(self, method: LocalizationMethod, found: Found, node: int) -> None:
        try:
            method.start_at(found.pose, found.covariance)
        except (ValueError, np.linalg.LinAlgError) as error:
            self._node.warn("relocalization", f"ignored: {error}")
            return
        self._node.log.info("begun anew at node %d, by %d features", node, found.matched)
        self._after()
