"""Real sonar rings: the default model beside the plain one."""

from functools import cache
from pathlib import Path

import numpy as np
import pytest

from map_sharpness import Round, foretold, mean_entropies, mean_entropy_of_known
from pilotage.core.grid import OccupancyMap
from pilotage.core.logs import Log, OdometryRecord, SonarRecord, read_log
from pilotage.mapper.log_run import LogUse, records_of
from pilotage.mapper.sonar_grid import SonarGrid, SonarGridParams
from pilotage.mapper.sonar_mapping import DEFAULT_MODEL, SonarMapping, SonarMappingParams
from pilotage.mapper.sonar_models import SonarModel
from pilotage.mapper.sonar_ring import SonarRing

pytestmark = pytest.mark.data

SETS = {
    "sonar/ev3/ev3-101.log": (0.03, 1.5, 0.06),
    "sonar/ev3/ev3-222.log": (0.03, 1.5, 0.06),
    "sonar/ring8": (0.1, 3.0, 0.15),
}
"""Cell, farthest reading that is asked about, and tolerance, all m."""
MODELS: tuple[SonarModel, ...] = ("centre_line", "bayes", DEFAULT_MODEL)


@cache
def rounds_of(path: Path) -> tuple[SonarRing, list[Round]]:
    """The ring of a log and its rounds at the poses of odometry."""
    log: Log = read_log(path)
    pose, rounds, ring = np.zeros(3), [], None
    for record in records_of(log, LogUse("sonar")):
        if isinstance(record, OdometryRecord):
            pose = np.array(record.pose)
        elif isinstance(record, SonarRecord):
            ring = SonarRing(record.mounts, record.cone, record.range_max)
            rounds.append((pose, record.ranges.astype(float)))
    assert ring is not None
    return ring, rounds


def drawn(ring: SonarRing, rounds: list[Round], model: SonarModel, cell: float) -> OccupancyMap:
    grid = SonarGrid(SonarGridParams(resolution=cell), ring, model)
    for pose, ranges in rounds:
        grid.insert(pose, ranges)
    return grid.map()


@pytest.mark.parametrize("name", SETS)
def test_default_model_is_sharper_than_the_centre_line(data_dir: Path, name: str) -> None:
    ring, rounds = rounds_of(data_dir / name)
    maps = [drawn(ring, rounds, model, SETS[name][0]) for model in MODELS]
    plain, bayes, default = mean_entropies(maps)
    assert default < 0.75 * plain, "over all cells that any model knows"
    assert default < 1.1 * bayes
    per_known = [mean_entropy_of_known(world) for world in maps]
    assert per_known[2] < per_known[0], "even over what each knows"
    assert per_known[2] < per_known[1]


@pytest.mark.parametrize("name", SETS)
def test_sharpness_is_not_bought_by_declaring_all_free(data_dir: Path, name: str) -> None:
    ring, rounds = rounds_of(data_dir / name)
    cell, farthest, tolerance = SETS[name]
    unseen = rounds[4::5]
    known = [entry for number, entry in enumerate(rounds) if number % 5 != 4]
    told = {
        model: foretold(drawn(ring, known, model, cell), ring, unseen, (farthest, tolerance))
        for model in MODELS
    }
    plain, default = told["centre_line"], told[DEFAULT_MODEL]
    assert default[1] < 0.9 * plain[1], "readings that go through an obstacle of the map"
    # It explains fewer echoes (one cell each, and cones erase) but contradicts fewer still.
    assert default[0] - default[1] > plain[0] - plain[1] - 0.08, told
    assert default[0] > 0.45, told


@pytest.mark.parametrize("name", SETS)
def test_whole_logs_are_mapped_where_odometry_goes(data_dir: Path, name: str) -> None:
    grid = SonarGridParams(resolution=SETS[name][0])
    mapping = SonarMapping(SonarMappingParams(grid=grid))
    steps = [mapping.process(r) for r in records_of(read_log(data_dir / name), LogUse("sonar"))]
    heard = sum(step is not None for step in steps)
    _, rounds = rounds_of(data_dir / name)
    assert heard >= 0.9 * len(rounds)
    world = mapping.map()
    assert world.is_wall.sum() > 100
    assert mapping.trajectory()[1][-1] == pytest.approx(rounds[-1][0], abs=1e-6)
