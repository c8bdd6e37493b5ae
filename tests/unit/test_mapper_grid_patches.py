import numpy as np
import pytest

from pilotage.core.grid import GridGeometry, OccupancyMap
from pilotage.mapper.grid_patches import (
    MOST_TILES,
    TILE,
    CellPatch,
    patched,
    patches_between,
)


def world_of(cells: np.ndarray) -> OccupancyMap:
    rows, cols = cells.shape
    geometry = GridGeometry(rows, cols, 0.05, (1.0, 2.0, 0.0))
    return OccupancyMap(geometry, cells.astype(np.int8))


def patches_of(before: np.ndarray, after: np.ndarray) -> tuple[CellPatch, ...]:
    patches = patches_between(world_of(before), world_of(after))
    assert patches is not None
    return patches


def unknown(rows: int = 400, cols: int = 500) -> np.ndarray:
    return np.full((rows, cols), -1, np.int8)


def test_a_map_that_did_not_change_has_no_patches() -> None:
    assert patches_between(world_of(unknown()), world_of(unknown())) == ()


def test_a_patch_is_cut_to_the_cells_that_changed() -> None:
    after = unknown()
    after[70:73, 90:100] = 0
    (patch,) = patches_of(unknown(), after)
    assert (patch.row, patch.col, patch.cells.shape) == (70, 90, (3, 10))
    assert (patch.cells == 0).all()


def test_changes_far_apart_have_patches_of_their_own() -> None:
    after = unknown()
    after[3, 4] = after[390, 480] = 100
    patches = patches_of(unknown(), after)
    assert [(patch.row, patch.col, patch.cells.size) for patch in patches] == [
        (3, 4, 1),
        (390, 480, 1),
    ]


def test_no_patch_is_larger_than_a_message_should_be() -> None:
    after = np.zeros((700, 900), np.int8)
    patches = patches_of(unknown(700, 900), after)
    assert max(max(patch.cells.shape) for patch in patches) <= TILE * MOST_TILES
    assert sum(patch.cells.size for patch in patches) == after.size


def test_a_map_that_grew_must_be_sent_whole() -> None:
    assert patches_between(world_of(unknown(4, 4)), world_of(unknown(4, 5))) is None


def test_a_map_without_cells_has_no_patches() -> None:
    assert patches_between(world_of(unknown(0, 0)), world_of(unknown(0, 0))) == ()


@pytest.mark.parametrize(("row", "col"), [(-1, 0), (0, -1), (3, 0), (0, 3), (99, 0)])
def test_a_patch_off_the_map_is_refused(row: int, col: int) -> None:
    patch = CellPatch(row, col, np.zeros((2, 2), np.int8))
    with pytest.raises(ValueError, match="lies off the map"):
        patched(world_of(unknown(4, 4)), (patch,))
