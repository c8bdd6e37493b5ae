"""The planner on the bus: what is known in; velocities, paths and reasons out."""

import numpy as np

from pilotage.bus.deployment import Deployment
from pilotage.bus.node import Node
from pilotage.planner.active_drive import ActiveDrive
from pilotage.planner.building import Building, unusable, warm_up
from pilotage.planner.camera_setup import camera_of
from pilotage.planner.config import PlannerSettings
from pilotage.planner.hearing import Hearing
from pilotage.planner.messages import world_of
from pilotage.planner.mission import AT_REST, Mission, Target, Way
from pilotage.planner.queries import Queries
from pilotage.planner.showing import Showing
from pilotage.planner.situation import Situation
from pilotage.planner.storage import Orders, load_orders, save_orders

PERIOD = 0.1
"""s between two steps of whoever drives; the robot stands after 0.5 s without one."""
STATUS_PERIOD = 0.5
MAP_WORK_S = 60.0


class PlannerService:
    """Glue between a mission, what is known of the robot, and the bus."""

    def __init__(self, settings: PlannerSettings, node: Node, deployment: Deployment) -> None:
        self.node = node
        self.mission = Mission(self._begin_search, self._plan_way, settings.mission())
        self.heard = Hearing(node, self)
        self.shown = Showing(node)
        self.building: Building | None = None
        self._settings = settings
        self._camera = camera_of(settings)
        self._folder = deployment.run_dir
        self._kept: Orders | None = None
        self._rng = np.random.default_rng(settings.seed)
        self._orders = 0
        self._search: ActiveDrive | None = None
        self._was_driving = False
        with node.busy(MAP_WORK_S):
            warm_up()
        self._remember()
        self.heard.begin()
        Queries(self)
        node.every(PERIOD, self.step)
        node.every(STATUS_PERIOD, lambda: self.shown.say(self.mission))

    def step(self) -> None:
        """Do what is to be done now, and say what has changed."""
        now, situation = self.node.clock.monotonic(), self.heard.situation()
        if situation is not None and not self.heard.facts.is_held and self.mission.must_search(now):
            self.mission.localize()
            self.changed()
        self._drive(now, situation)
        self._show(now)
        if self.shown.is_news(self.mission):
            self._keep()
            self.shown.say(self.mission)

    def changed(self) -> None:
        """Say and keep what is done from now on; whoever wished it knows all orders so far."""
        if self.mission.is_busy:
            self._orders = self.heard.facts.orders
        if self.mission.target is not None:
            self.shown.show_goal(self.mission.target)
        self._let_go()
        self._keep()
        self.shown.say(self.mission)

    def robot_or_map_changed(self) -> None:
        """Make anew what planning on this map for this robot needs."""
        if self.mission.is_busy:
            self.mission.end("interrupted", "another map is in use")
        grid, build = self.heard.map, self.heard.facts.build
        if grid is None or build is None or build.sight is None:
            return
        world = world_of(grid)
        self.heard.map_fault, self.building = unusable(world), None
        if self.heard.map_fault is not None:
            return
        with self.node.busy(MAP_WORK_S):
            tuned = self._settings.active(build), self._settings.follower(build)
            self.building = Building(world, tuned, self._camera)
        self.shown.show_potential(self.building.active.potential)

    def map_begun(self) -> None:
        """Plan nothing while a map is being made."""
        if self.mission.is_busy:
            self.mission.end("interrupted", "a map is being made")

    def robot_said(self) -> None:
        """Give up once a person has told the robot something else; that is what it does now."""
        orders = self.heard.facts.orders
        if orders > self._orders and self.mission.is_busy:
            reason = f"a person told the robot something else: {self.heard.facts.activity}"
            self.mission.end("interrupted", reason, None)
        # A robot that was restarted counts anew.
        self._orders = orders

    def _drive(self, now: float, situation: Situation | None) -> None:
        speeds = self.mission.step(now, situation, self.heard.obstacle())
        if speeds is not None:
            self.shown.drive(speeds, self._orders)
        elif self._was_driving and self.mission.is_busy:
            # It waits now: told to, the robot stands sooner than of its own accord.
            self.shown.drive(AT_REST, self._orders)
        self._was_driving = speeds is not None
        self._let_go()

    def _let_go(self) -> None:
        if self.mission.ending is not None:
            self.shown.let_go(self.mission.ending)
            self.mission.ending = None
        self.shown.say_farewell(self._orders)

    def _show(self, began: float) -> None:
        """Show the way and the search that the mission is on, or that there is none."""
        decision = None if self._search is None else self._search.decision
        if self._search is not None and self._search.gaze is not None:
            self.shown.look(self._search.gaze)
        if self.mission.search is None:
            self._search = None
            self.shown.show_no_search()
        elif decision is not None and self.shown.show_decision(decision, self.heard.places):
            self.shown.decision_ms = 1e3 * (self.node.clock.monotonic() - began)
        if self.mission.search is None and self.mission.way is not None:
            self.shown.show_path(self.mission.way.path)
        elif not self.mission.is_busy:
            self.shown.show_no_path()

    def _begin_search(self) -> ActiveDrive:
        assert self.building is not None  # noqa: S101 - there is a situation, so there is a map
        self._search = self.building.search(self._rng)
        return self._search

    def _plan_way(self, target: Target, situation: Situation) -> Way:
        assert self.building is not None  # noqa: S101 - there is a situation, so there is a map
        return self.building.way(target, situation)

    def _remember(self) -> None:
        """Go on with what was told to an earlier process of this run; not with what it was at."""
        self._kept = load_orders(self._folder, lambda text: self.node.warn("storage", text))
        self.mission.always = self._settings.always_localizes
        if self._kept is None:
            return
        self.mission.always = self._kept.always
        if self._kept.task:
            self.mission.outcome = "interrupted"
            self.mission.reason = f"the planner was restarted while {self._kept.task}"

    def _keep(self) -> None:
        """Keep what a restarted planner has to know."""
        orders = Orders(self.mission.always, self.mission.task)
        if orders != self._kept:
            self._kept = orders
            save_orders(self._folder, orders, lambda text: self.node.warn("storage", text))
