"""A method at work on a map, and what of it outlives a crash of the process."""

from dataclasses import replace
from typing import Literal

import numpy as np

from pilotage.core.grid import OccupancyMap
from pilotage.core.odometry_watch import OdometrySample
from pilotage.localizer.method import LocalizationMethod
from pilotage.localizer.methods import MethodSetup, known, make_method, require_method
from pilotage.localizer.range_model import RangeTable
from pilotage.localizer.storage import Choice, RunFolder, SightKey, Snapshot


class Localization:
    """At most one method on at most one map; `usual` is what the settings choose."""

    def __init__(
        self, setup: MethodSetup, kept: RunFolder, usual: Choice, rng: np.random.Generator
    ) -> None:
        self.method: LocalizationMethod | None = None
        self.map_id = ""
        self.choice = kept.load_choice(usual.settings) or usual
        self._setup = setup
        self._kept = kept
        self._rng = rng

    def begin_on(self, world: OccupancyMap, map_id: str) -> Snapshot | None:
        """Begin on a map, anywhere or from the snapshot of a crashed run, which is returned.

        Raises:
            ValueError: the map cannot be localized on; the old one stays in use.
        """
        method = self._made(self.choice.method, world, map_id, None)
        snapshot = self._kept.load_snapshot(map_id)
        if snapshot is not None:
            method.resume(snapshot.memory)
        self.method, self.map_id = method, map_id
        return snapshot

    def choose_method(self, name: str) -> None:
        """Localize by this method from now on, from what the old one knows.

        Raises:
            NoMethodError: there is no such method; the old one stays in use.
        """
        require_method(name)
        old = self.method
        if old is not None and old.name != name:
            is_shared = self._setup.sight_of(name) == self._setup.sight_of(old.name)
            new = self._made(name, old.world, self.map_id, old.sight if is_shared else None)
            _carry_over(old, new)
            self.method = new
        self._choose(replace(self.choice, method=name))

    def choose_algorithm(self, algorithm: Literal["m1", "m2"], recovery_weight: float) -> None:
        """Use M1 or M2 from now on, by whichever method and on whichever map."""
        if self.method is not None:
            self.method.choose_algorithm(algorithm, recovery_weight)
        chosen = replace(self.choice, algorithm=algorithm, recovery_weight=recovery_weight)
        self._choose(chosen)

    def choose_map_file(self, file: str, served_id: str) -> None:
        """Note that a file (or with "" the mapper's map) is what to localize on."""
        self._choose(replace(self.choice, map_file=file, served_id=served_id))

    def save(self, odometry_seq: int) -> None:
        """Keep what the method remembers, if it has measured anything."""
        memory = None if self.method is None else self.method.remember()
        if memory is not None:
            self._kept.save_snapshot(Snapshot(self.map_id, odometry_seq, memory))

    def save_known(self, odometry: OdometrySample | None) -> None:
        """Keep what is known now; what was kept before has been taken back."""
        memory = None
        if self.method is not None and odometry is not None:
            memory = known(self.method, odometry.pose, odometry.stamp_ns)
        if odometry is None or memory is None:
            self._kept.forget_snapshot()
        else:
            self._kept.save_snapshot(Snapshot(self.map_id, odometry.seq, memory))

    def _made(
        self, name: str, world: OccupancyMap, map_id: str, sight: RangeTable | None
    ) -> LocalizationMethod:
        params = self._setup.sight_of(name)
        key = None if params is None else SightKey(map_id, *params)
        if sight is None and key is not None:
            sight = self._kept.load_sight(key)
        method = make_method(name, world, self._setup, self._rng, sight)
        if sight is None and key is not None and method.sight is not None:
            self._kept.save_sight(key, method.sight)
        method.choose_algorithm(self.choice.algorithm, self.choice.recovery_weight)
        return method

    def _choose(self, choice: Choice) -> None:
        self.choice = choice
        self._kept.save_choice(choice)


def _carry_over(old: LocalizationMethod, new: LocalizationMethod) -> None:
    """Let the new method go on from what the old one knows; if that is nothing, from anywhere."""
    memory = known(old, np.zeros(3), 0)
    if memory is None:
        return
    new.resume(memory)
    if old.remember() is None:
        new.restart_odometry()
