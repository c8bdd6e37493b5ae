"""The table of what can be seen through is made once for a map and kept."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from localizer_world import COARSE, flat
from pilotage.localizer.markov_localizer import MarkovLocalizer
from pilotage.localizer.range_model import RangeTable
from pilotage.localizer.storage import load_sight, save_sight
from pilotage.localizer.visibility import VisibilityParams


def kept(folder: Path) -> RangeTable:
    table = MarkovLocalizer(flat(), COARSE).sight
    save_sight(folder, "flat", COARSE, table)
    return table


def test_a_kept_table_serves_the_next_start(tmp_path: Path) -> None:
    made = kept(tmp_path)
    again = load_sight(tmp_path, "flat", COARSE)
    assert again is not None
    assert np.array_equal(made.levels, again.levels)
    assert again.range_max == made.range_max
    assert MarkovLocalizer(flat(), COARSE, again).sight is again


def test_another_map_or_other_parameters_have_no_kept_table(tmp_path: Path) -> None:
    kept(tmp_path)
    assert load_sight(tmp_path, "another flat", COARSE) is None
    finer = replace(COARSE, visibility=VisibilityParams(reach=8.0))
    assert load_sight(tmp_path, "flat", finer) is None


def test_a_damaged_table_is_none(tmp_path: Path) -> None:
    kept(tmp_path)
    (file,) = tmp_path.iterdir()
    file.write_bytes(file.read_bytes()[:-7] + b"damaged")
    assert load_sight(tmp_path, "flat", COARSE) is None
