"""What the mapper keeps: maps in its library, and what a crash leaves of its work."""

from pathlib import Path

import numpy as np
import pytest

from drawing import draw
from localizer_world import ROUND, START
from mapper_bench import STAND, MapperBench, described, half_mapped, pieced_together, stopped
from pilotage.bus.fabric import RefusedError
from pilotage.core import se2
from pilotage.core.map_files import load_map, map_digest, save_map
from pilotage.mapper.config import MapperSettings
from pilotage_schemas.commands import (
    LoadMap,
    MapDelete,
    MapFetch,
    MapFile,
    MapList,
    MapLoad,
    MapLoaded,
    MapSave,
    MapSaved,
    MapStore,
    NamedFile,
    Nothing,
)


@pytest.fixture
def bench(tmp_path: Path) -> MapperBench:
    return described(tmp_path)


@pytest.fixture
def mapping(tmp_path: Path) -> MapperBench:
    return half_mapped(tmp_path)


class TestTheLibrary:
    def test_keeps_the_map_in_the_making_and_the_finished_one(self, mapping: MapperBench) -> None:
        saved = mapping.ask("map_save", MapSave(name="half"))
        assert isinstance(saved, MapSaved)
        mapping.go(*ROUND[8:])
        reply = stopped(mapping)
        whole = mapping.ask("map_save", MapSave(name="whole"))
        assert isinstance(whole, MapSaved)
        assert whole.map_id == reply.map_id != saved.map_id
        assert map_digest(load_map(Path(whole.path) / "map.yaml")) == reply.map_id
        listed = mapping.ask("map_list", Nothing())
        assert isinstance(listed, MapList)
        assert [one.name for one in listed.maps] == ["half", "whole"]
        assert all(one.can_go_on for one in listed.maps)
        files = {"map.yaml", "map.pgm", "trajectory.tum", "pose_graph.g2o", "session.npz"}
        assert set(listed.maps[0].files) == files

    def test_gives_a_map_back_by_its_name(self, mapping: MapperBench) -> None:
        mapping.ask("map_save", MapSave(name="half"))
        mapping.go(*ROUND[8:])
        stopped(mapping)
        reply = mapping.ask("map_load", MapLoad(map="half"))
        assert isinstance(reply, MapLoaded)
        assert mapping.heard["map"][-1].map_id == reply.map_id
        assert mapping.heard["map"][-1].name == "half"

    def test_gives_files_and_takes_them(self, mapping: MapperBench) -> None:
        mapping.ask("map_save", MapSave(name="one"))
        files = []
        for name in ("map.yaml", "map.pgm"):
            reply = mapping.ask("map_fetch", MapFetch(name="one", file=name))
            assert isinstance(reply, MapFile)
            files.append(NamedFile(name=name, content=reply.content))
        stored = mapping.ask("map_store", MapStore(name="two", files=tuple(files)))
        assert isinstance(stored, MapSaved)
        listed = mapping.ask("map_list", Nothing())
        assert isinstance(listed, MapList)
        assert listed.maps[1].map_id == listed.maps[0].map_id == stored.map_id
        assert [one.can_go_on for one in listed.maps] == [True, False]

    def test_deletes_a_map(self, mapping: MapperBench) -> None:
        mapping.ask("map_save", MapSave(name="one"))
        mapping.ask("map_delete", MapDelete(name="one"))
        assert mapping.ask("map_list", Nothing()) == MapList(maps=())

    def test_refuses_with_a_reason(self, mapping: MapperBench) -> None:
        bad = NamedFile(name="map.yaml", content=np.zeros(3, np.int8))
        requests = [
            ("map_save", MapSave(name="../x"), "cannot name a map"),
            ("map_delete", MapDelete(name="none"), "has no map 'none'"),
            ("map_fetch", MapFetch(name="none", file="map.yaml"), "has no map 'none'"),
            ("map_store", MapStore(name="bad", files=(bad,)), "map.yaml"),
            ("map_store", MapStore(name="bad", files=()), "needs its map.yaml"),
        ]
        for query, request, reason in requests:
            with pytest.raises(RefusedError, match=reason):
                mapping.ask(query, request)

    def test_keeps_a_map_from_a_file_too(self, tmp_path: Path) -> None:
        save_map(draw("...\n...", 0.1), tmp_path / "other.yaml")
        bench = MapperBench(tmp_path, MapperSettings(map=tmp_path / "other.yaml"))
        saved = bench.ask("map_save", MapSave(name="other"))
        assert isinstance(saved, MapSaved)
        assert saved.map_id == bench.heard["map"][-1].map_id

    def test_has_nothing_to_keep_before_the_first_map(self, bench: MapperBench) -> None:
        with pytest.raises(RefusedError, match="there is no map yet"):
            bench.ask("map_save", MapSave(name="nothing"))

    @pytest.mark.parametrize("run", [b"nonsense", b"PK\x03\x04 cut off"])
    def test_still_serves_a_map_whose_run_cannot_be_read(
        self, mapping: MapperBench, run: bytes
    ) -> None:
        reply = mapping.ask("map_save", MapSave(name="one"))
        assert isinstance(reply, MapSaved)
        stopped(mapping)
        mapping.service._at.library.save(
            "one",
            {
                name: mapping.service._at.library.read("one", name)
                for name in ("map.yaml", "map.pgm")
            }
            | {"session.npz": run},
            1,
        )
        mapping.ask("map_load", MapLoad(map="one"))
        assert "mapping cannot go on" in mapping.node.vitals.last_error
        assert mapping.heard["map"][-1].map_id == reply.map_id


class TestAfterACrash:
    def test_mapping_goes_on_with_at_most_five_seconds_lost(self, mapping: MapperBench) -> None:
        mapping.go(*[STAND] * 20)
        steps = mapping.service._at.session.steps  # type: ignore[union-attr]  # it is mapping
        mapping.crash()
        assert mapping.status.mode == "mapping"
        lost = (steps - mapping.status.steps) * 0.3
        assert lost <= 5.0
        mapping.go(STAND, STAND)
        true = se2.between(START, mapping.truth)
        said = mapping.heard["pose"][-1].pose
        assert (said.x, said.y) == pytest.approx((true[0], true[1]), abs=0.05)
        cells = pieced_together(mapping.heard["map"], mapping.heard["map_patch"])
        assert (cells == 0).sum() > 5000

    def test_the_finished_map_is_still_there(self, mapping: MapperBench) -> None:
        reply = stopped(mapping)
        mapping.crash()
        assert mapping.status.mode == "idle"
        assert mapping.heard["map"][-1].map_id == reply.map_id
        saved = mapping.ask("map_save", MapSave(name="later"))
        assert isinstance(saved, MapSaved)
        assert saved.map_id == reply.map_id

    def test_a_map_that_was_loaded_is_still_in_use(
        self, bench: MapperBench, tmp_path: Path
    ) -> None:
        save_map(draw("...\n...", 0.1), tmp_path / "other.yaml")
        reply = bench.ask("load_map", LoadMap(path=str(tmp_path / "other.yaml")))
        assert isinstance(reply, MapLoaded)
        bench.crash()
        assert bench.heard["map"][-1].map_id == reply.map_id

    def test_a_crash_during_the_hand_over_ends_it(self, mapping: MapperBench) -> None:
        mapping.localizer.ready()
        reply = stopped(mapping)
        mapping.crash()
        assert mapping.status.mode == "idle"
        assert mapping.heard["map"][-1].map_id == reply.map_id

    def test_a_damaged_memory_costs_the_memory_only(
        self, mapping: MapperBench, tmp_path: Path
    ) -> None:
        (tmp_path / "mapper.state").write_bytes(b"damaged")
        mapping.crash()
        assert mapping.status.mode == "idle"
        assert "it is damaged" in mapping.node.vitals.last_error
