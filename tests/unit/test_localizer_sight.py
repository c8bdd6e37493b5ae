"""The table of what can be seen through is made once for a map, shared and kept."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from localizer_world import COARSE, flat
from pilotage.localizer import markov_localizer, particle_evidence
from pilotage.localizer.localization import Localization
from pilotage.localizer.markov_localizer import MarkovLocalizer
from pilotage.localizer.methods import MethodSetup
from pilotage.localizer.particle_evidence import EvidenceParams
from pilotage.localizer.particle_localizer import ParticleParams
from pilotage.localizer.storage import Choice, RunFolder, SightKey

SHARED = MethodSetup(COARSE, ParticleParams(evidence=EvidenceParams(tables=COARSE.grid)))


def localization(folder: Path | None, setup: MethodSetup = SHARED) -> Localization:
    """A localization that begins on the flat."""
    kept = RunFolder(folder, pytest.fail)
    begun = Localization(setup, kept, Choice("", "markov", "m2", 0.1), np.random.default_rng(0))
    begun.begin_on(flat(), "flat")
    return begun


def forbid(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let nobody make the table any more."""
    for module in (markov_localizer, particle_evidence):
        monkeypatch.setattr(module, "optimistic_ranges", lambda *_: pytest.fail("made again"))


def test_a_kept_table_serves_the_next_start(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    made = localization(tmp_path).method
    forbid(monkeypatch)
    again = localization(tmp_path).method
    assert made is not None
    assert again is not None
    assert made.sight is not None
    assert again.sight is not None
    assert np.array_equal(made.sight.levels, again.sight.levels)
    assert again.sight.range_max == made.sight.range_max


def test_a_table_at_hand_is_used_as_it_is() -> None:
    table = MarkovLocalizer(flat(), COARSE).sight
    assert MarkovLocalizer(flat(), COARSE, table).sight is table


@pytest.mark.parametrize("has_folder", [True, False])
def test_both_methods_share_the_table(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, *, has_folder: bool
) -> None:
    begun = localization(tmp_path if has_folder else None)
    old = begun.method
    forbid(monkeypatch)
    begun.choose_method("mcl")
    assert old is not None
    assert begun.method is not None
    assert begun.method.name == "mcl"
    assert begun.method.sight is old.sight


def test_a_method_with_other_cells_has_a_table_of_its_own(tmp_path: Path) -> None:
    other = MethodSetup(COARSE, ParticleParams())
    begun = localization(tmp_path, other)
    begun.choose_method("mcl")
    kept = RunFolder(tmp_path, pytest.fail)
    evidence = other.particles.evidence
    assert evidence.visibility is not None
    assert kept.load_sight(SightKey("flat", COARSE.grid, COARSE.visibility)) is not None
    assert kept.load_sight(SightKey("flat", evidence.tables, evidence.visibility)) is not None


def test_a_method_that_needs_no_table_keeps_none(tmp_path: Path) -> None:
    evidence = replace(SHARED.particles.evidence, visibility=None)
    blind = replace(SHARED, particles=replace(SHARED.particles, evidence=evidence))
    begun = localization(tmp_path, blind)
    before = sorted(tmp_path.glob("sight-*"))
    begun.choose_method("mcl")
    assert begun.method is not None
    assert begun.method.name == "mcl"
    assert sorted(tmp_path.glob("sight-*")) == before
