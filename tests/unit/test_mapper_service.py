"""The mapper on a fake fabric: map files in, the topic `map` out."""

import math
from pathlib import Path

import numpy as np
import pytest

from drawing import draw
from pilotage.bus.clock import HandClock
from pilotage.bus.deployment import ConfigError, Deployment, read_deployment, service_settings
from pilotage.bus.fabric import RefusedError, Sample
from pilotage.bus.fake import FakeFabric
from pilotage.bus.node import Node
from pilotage.core.map_files import map_digest, save_map
from pilotage.mapper.config import MapperSettings
from pilotage.mapper.messages import grid_message
from pilotage.mapper.service import MapperService
from pilotage_schemas.codec import decode
from pilotage_schemas.commands import LoadMap, MapLoaded
from pilotage_schemas.mapping import OccupancyGrid

HALL = draw("####\n#..#\n#..#\n####", 0.1, (1.0, -2.0, 0.5))
OTHER = draw("#####\n#.?.#\n#####", 0.05)


class Bench:
    """A mapper and whoever asks it."""

    def __init__(self, settings: MapperSettings) -> None:
        self.fabric, self.clock = FakeFabric(), HandClock()
        self.node = Node("mapper", "demo", self.fabric, self.clock)
        self.asking = Node("gateway", "demo", self.fabric, self.clock)
        self.maps = self.listen()
        self.service = MapperService(settings, self.node, Deployment())
        self.fabric.pump = self.step

    def step(self) -> None:
        self.node.step()

    def listen(self) -> list[OccupancyGrid]:
        heard: list[OccupancyGrid] = []

        def hear(sample: Sample) -> None:
            heard.append(decode(OccupancyGrid, sample.payload))

        self.fabric.declare_subscriber("pilotage/@v1/demo/map", "never_drop", hear)
        return heard

    def load(self, path: Path) -> MapLoaded:
        reply = self.asking.ask("load_map", LoadMap(path=str(path)))
        assert isinstance(reply, MapLoaded)
        return reply


@pytest.fixture
def hall(tmp_path: Path) -> Path:
    save_map(HALL, tmp_path / "hall.yaml")
    return tmp_path / "hall.yaml"


@pytest.fixture
def bench(hall: Path) -> Bench:
    return Bench(MapperSettings(map=hall))


def test_the_map_of_the_settings_is_published_at_once(bench: Bench) -> None:
    (grid,) = bench.maps
    assert grid.map_id == map_digest(HALL)
    assert grid.name == "hall.yaml"
    assert grid.resolution == pytest.approx(0.1)
    assert np.array_equal(grid.cells, HALL.cells)
    assert (grid.origin.x, grid.origin.y, grid.origin.theta) == pytest.approx((1.0, -2.0, 0.5))
    assert grid.stamp_ns == bench.clock.now_ns()


def test_who_comes_late_hears_the_map_too(bench: Bench) -> None:
    assert [grid.map_id for grid in bench.listen()] == [map_digest(HALL)]


def test_without_a_map_in_its_settings_the_mapper_waits_for_one(hall: Path) -> None:
    bench = Bench(MapperSettings())
    assert bench.maps == []
    assert bench.load(hall).map_id == map_digest(HALL)
    assert len(bench.maps) == 1


def test_another_map_is_loaded_on_request(bench: Bench, tmp_path: Path) -> None:
    save_map(OTHER, tmp_path / "other.yaml")
    reply = bench.load(tmp_path / "other.yaml")
    assert (reply.map_id, reply.rows, reply.cols) == (map_digest(OTHER), 3, 5)
    assert bench.maps[-1].map_id == map_digest(OTHER)
    assert [grid.map_id for grid in bench.listen()] == [map_digest(OTHER)]


def test_a_missing_file_is_refused_by_name(bench: Bench, tmp_path: Path) -> None:
    with pytest.raises(RefusedError, match=r"nowhere\.yaml"):
        bench.load(tmp_path / "nowhere.yaml")


@pytest.mark.parametrize(
    "content",
    [b"", b"\xff\x00\xfe", b"image: gone.pgm\nresolution: 0.1\norigin: [0, 0, 0]\n", b"[1, 2"],
    ids=["empty", "binary", "no image", "no YAML"],
)
def test_a_damaged_file_is_refused_and_the_old_map_stays(
    bench: Bench, tmp_path: Path, content: bytes
) -> None:
    (tmp_path / "bad.yaml").write_bytes(content)
    with pytest.raises(RefusedError, match=r"bad\.yaml|gone"):
        bench.load(tmp_path / "bad.yaml")
    assert len(bench.maps) == 1
    assert [grid.map_id for grid in bench.listen()] == [map_digest(HALL)]


def test_an_image_cut_off_is_refused_and_the_old_map_stays(bench: Bench, tmp_path: Path) -> None:
    save_map(OTHER, tmp_path / "other.yaml")
    image = tmp_path / "other.pgm"
    image.write_bytes(image.read_bytes()[:-4])
    with pytest.raises(RefusedError, match="other"):
        bench.load(tmp_path / "other.yaml")
    assert len(bench.maps) == 1


def test_a_map_where_nobody_can_stand_is_refused_and_the_old_one_stays(
    bench: Bench, tmp_path: Path
) -> None:
    save_map(draw("##?\n###"), tmp_path / "full.yaml")
    with pytest.raises(RefusedError, match="no free cell"):
        bench.load(tmp_path / "full.yaml")
    assert len(bench.maps) == 1


def test_a_folder_is_no_map(bench: Bench, tmp_path: Path) -> None:
    with pytest.raises(RefusedError, match=str(tmp_path)):
        bench.load(tmp_path)


@pytest.mark.parametrize("content", [None, b"no map at all"], ids=["missing", "damaged"])
def test_settings_with_an_unusable_map_end_the_mapper_with_a_reason(
    tmp_path: Path, content: bytes | None
) -> None:
    path = tmp_path / "first.yaml"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(ConfigError, match=r"first\.yaml"):
        Bench(MapperSettings(map=path))


def test_the_path_in_a_deployment_is_relative_to_its_file(hall: Path) -> None:
    deployment = hall.parent / "deployment.yaml"
    deployment.write_text("services: {mapper: {map: hall.yaml}}\n", encoding="utf-8")
    settings = service_settings(read_deployment(deployment), "mapper", MapperSettings)
    assert settings.map == hall


def test_a_long_name_is_cut_to_what_a_message_holds() -> None:
    assert len(grid_message(HALL, "x" * 200, 1).name) == 64


def test_map_ids_tell_maps_apart_and_nothing_else() -> None:
    ids = {
        grid_message(world, name, stamp).map_id
        for world, name, stamp in ((HALL, "a", 1), (HALL, "b", 2), (OTHER, "a", 1))
    }
    assert len(ids) == 2


@pytest.mark.parametrize("yaw", [math.pi, 6.0, -9.0])
def test_a_map_turned_by_any_angle_is_published(yaw: float) -> None:
    theta = grid_message(draw("..", 0.1, (0.0, 0.0, yaw)), "a", 1).origin.theta
    assert math.cos(theta - yaw) == pytest.approx(1.0)


def test_a_map_that_no_message_can_hold_is_refused_and_the_old_one_stays(
    bench: Bench, tmp_path: Path
) -> None:
    save_map(draw("..", 0.1, (1e300, 0.0, 0.0)), tmp_path / "afar.yaml")
    with pytest.raises(RefusedError, match=r"afar\.yaml: the map cannot be published: x"):
        bench.load(tmp_path / "afar.yaml")
    assert len(bench.maps) == 1


@pytest.mark.parametrize(("path", "reason"), [("", "the path is empty"), (".", "a directory")])
def test_a_path_that_names_no_file_is_refused_in_words(hall: Path, path: str, reason: str) -> None:
    bench = Bench(MapperSettings(map=hall))
    with pytest.raises(RefusedError, match=reason) as refused:
        bench.asking.ask("load_map", LoadMap(path=path))
    assert "Errno" not in str(refused.value)
    assert len(bench.maps) == 1
