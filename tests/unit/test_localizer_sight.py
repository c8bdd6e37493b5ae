"""The table of what can be seen through is made once for a map and kept."""

from pathlib import Path

import numpy as np

from localizer_world import COARSE, flat
from pilotage.localizer.markov_localizer import MarkovLocalizer
from pilotage.localizer.storage import kept_sight


def test_a_kept_table_is_the_one_that_a_localizer_makes_itself(tmp_path: Path) -> None:
    made = kept_sight(tmp_path, "flat", COARSE, flat())
    again = kept_sight(tmp_path, "flat", COARSE, flat())
    assert len(list(tmp_path.iterdir())) == 1
    assert np.array_equal(made.levels, again.levels)
    own = MarkovLocalizer(flat(), COARSE)._sight
    assert np.array_equal(own.levels, again.levels)
    assert own.range_max == again.range_max


def test_another_map_has_another_table(tmp_path: Path) -> None:
    kept_sight(tmp_path, "flat", COARSE, flat())
    kept_sight(tmp_path, "flat moved", COARSE, flat((1.0, 0.0, 0.0)))
    assert len(list(tmp_path.iterdir())) == 2


def test_a_damaged_table_is_made_anew(tmp_path: Path) -> None:
    made = kept_sight(tmp_path, "flat", COARSE, flat())
    (file,) = tmp_path.iterdir()
    file.write_bytes(file.read_bytes()[:-7] + b"damaged")
    assert np.array_equal(kept_sight(tmp_path, "flat", COARSE, flat()).levels, made.levels)
