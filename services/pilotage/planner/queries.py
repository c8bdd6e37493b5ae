"""What the planner is asked to do: each is begun, or refused with the reason."""

from typing import Protocol

import numpy as np

from pilotage.bus.fabric import RefusedError
from pilotage.bus.node import Node
from pilotage.planner.building import Building
from pilotage.planner.hearing import Hearing
from pilotage.planner.messages import pose_array
from pilotage.planner.mission import Mission, NoWayError, Target
from pilotage.planner.showing import Showing
from pilotage.planner.situation import Situation
from pilotage_schemas.commands import Done, GoTo, LocalizeActively, Look, Nothing


class Planner(Protocol):
    """What the queries need of the service."""

    node: Node
    mission: Mission
    heard: Hearing
    shown: Showing
    building: Building | None

    def changed(self) -> None:
        """Say and keep what is done from now on."""
        ...


class Queries:
    """Answers the planner's queries."""

    def __init__(self, planner: Planner) -> None:
        self._planner = planner
        planner.node.answer("go_to", self.go_to)
        planner.node.answer("localize_actively", self.localize_actively)
        planner.node.answer("cancel", self.cancel)
        planner.node.answer("look", self.look)
        planner.node.answer("planner_status", lambda _: planner.shown.status(planner.mission))

    def go_to(self, request: GoTo) -> Done:
        """Go to a pose; a goal that cannot be reached is refused at once."""
        situation, building = self._required()
        tolerances = request.position_tolerance, request.heading_tolerance
        target = Target(pose_array(request.pose), *tolerances)
        try:
            is_sure = situation.state == "localized"
            way = building.way(target, situation) if is_sure else None
            if not is_sure:
                building.check(target)
        except NoWayError as error:
            raise RefusedError(str(error)) from error
        self._planner.mission.go_to(target, way)
        self._planner.changed()
        if way is None:
            return Done(detail=f"finding out where it is, then on to {target}")
        return Done(detail=f"going to {target}, {way.distance_left:.1f} m")

    def localize_actively(self, request: LocalizeActively) -> Done:
        """Find out where the robot is, now or whenever that is in doubt."""
        heard = self._planner.heard
        obstacle = heard.facts.obstacle if request.always else heard.obstacle()
        if obstacle is not None:
            raise RefusedError(obstacle)
        mission = self._planner.mission
        mission.always |= request.always
        situation = heard.situation()
        in_doubt = situation is not None and situation.state != "localized"
        if in_doubt and mission.target is None:
            mission.localize()
        self._planner.changed()
        if in_doubt:
            return Done(detail="finding out where it is")
        later = ", and every doubt will be resolved" if mission.always else ""
        return Done(detail=f"the pose is not in doubt{later}")

    def cancel(self, _request: Nothing) -> Done:
        """Stand, and do nothing unasked."""
        mission = self._planner.mission
        given_up = mission.reason if mission.is_busy else ""
        was_armed, mission.always = mission.always, False
        if mission.is_busy:
            mission.end("cancelled", f"cancelled: {given_up}")
        elif was_armed:
            mission.reason = "doubts are no longer resolved unasked"
        self._planner.changed()
        return Done(detail=mission.reason if given_up or was_armed else "there was nothing to do")

    def look(self, request: Look) -> Done:
        """Point the camera."""
        facts = self._planner.heard.facts
        if facts.obstacle is not None or facts.build is None:
            raise RefusedError(facts.obstacle or "the robot has not been heard of yet")
        if "look" not in facts.build.commands:
            raise RefusedError(f"{facts.build.name} has no camera that can be pointed")
        self._planner.shown.look(request.pan)
        return Done(detail=f"looking {np.rad2deg(request.pan):.0f} degrees to the left")

    def _required(self) -> tuple[Situation, Building]:
        """Return what a goal needs to be planned; RefusedError says what is missing."""
        obstacle = self._planner.heard.obstacle()
        situation, building = self._planner.heard.situation(), self._planner.building
        if obstacle is not None or situation is None or building is None:
            raise RefusedError(obstacle or "not all is known yet")
        return situation, building
