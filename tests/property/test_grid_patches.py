import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from pilotage.core.grid import GridGeometry, OccupancyMap
from pilotage.mapper.grid_patches import patched, patches_between
from pilotage.mapper.laser_grid import LaserGrid
from pilotage.mapper.laser_grid_params import LaserGridParams

SEEDS = st.integers(0, 2**32 - 1)


@given(SEEDS, st.tuples(st.integers(0, 150), st.integers(0, 150)), st.floats(0.0, 1.0))
def test_the_old_map_with_all_patches_is_the_new_map(
    seed: int, shape: tuple[int, int], share: float
) -> None:
    rng = np.random.default_rng(seed)
    geometry = GridGeometry(*shape, 0.05)
    old = OccupancyMap(geometry, rng.integers(-1, 101, shape).astype(np.int8))
    # Changes in blocks and single cells, for patches of every size.
    is_new = np.kron(rng.random((5, 5)) < share, np.ones((30, 30), bool))[: shape[0], : shape[1]]
    is_new = is_new | (rng.random(shape) < share**8)
    cells = np.where(is_new, rng.integers(-1, 101, shape), old.cells).astype(np.int8)
    new = OccupancyMap(geometry, cells)
    patches = patches_between(old, new)
    assert patches is not None
    assert (patched(old, patches).cells == new.cells).all()
    covered = np.zeros(shape, int)
    for patch in patches:
        rows, cols = patch.cells.shape
        covered[patch.row : patch.row + rows, patch.col : patch.col + cols] += 1
    assert covered.max(initial=0) <= 1


@given(SEEDS)
def test_who_follows_the_patches_has_the_map_also_when_it_grew(seed: int) -> None:
    rng = np.random.default_rng(seed)
    grid = LaserGrid(LaserGridParams(resolution=0.1))
    theirs = grid.map()
    for _ in range(6):
        origin = rng.uniform(-30.0, 30.0, 2)
        grid.insert(origin, origin + rng.normal(0.0, 3.0, (20, 2)), rng.random(20) < 0.7)
        ours = grid.map()
        patches = patches_between(theirs, ours)
        theirs = ours if patches is None else patched(theirs, patches)
        assert theirs.geometry == ours.geometry
        assert (theirs.cells == ours.cells).all()
