"""Maps at the gateway: those that grow, and those of the library."""

import asyncio
import io
import zipfile
from collections.abc import Callable, Iterator

import cbor2
import numpy as np
import pytest

from gateway_world import GatewayWorld, grid, pose_estimate
from pilotage.bus.fabric import RefusedError
from pilotage.bus.node import Node
from pilotage.gateway.growing_map import GrowingMap
from pilotage.gateway.map_archive import MOST_FILES, ArchiveError, packed, unpacked
from pilotage.gateway.stream import MOST_STEPS, Outbox
from pilotage_schemas.codec import decode
from pilotage_schemas.commands import (
    Done,
    MapDelete,
    MapFetch,
    MapFile,
    MapList,
    MapLoad,
    MapLoaded,
    MapSaved,
    MapStore,
    StoredMap,
)
from pilotage_schemas.mapping import GridPatch, MappingStatus, OccupancyGrid

MAPS = "/api/v1/maps"
FILES = {"map.yaml": b"image: map.pgm\n", "map.pgm": b"P5\n\xff"}


def with_damaged_content(archive: bytes) -> bytes:
    """The archive with the packed bytes of its first file spoilt."""
    begin = archive.index(b"map.yaml") + len(b"map.yaml")
    return archive[:begin] + b"\xff" * 8 + archive[begin + 8 :]


def packed_unknown_way(archive: bytes) -> bytes:
    """The archive, its files said to be packed by a method of which nobody knows."""
    spoilt = bytearray(archive)
    for mark, offset in ((b"PK\x03\x04", 8), (b"PK\x01\x02", 10)):
        at = spoilt.find(mark)
        while at >= 0:
            spoilt[at + offset : at + offset + 2] = b"\x63\x00"
            at = spoilt.find(mark, at + 4)
    return bytes(spoilt)


@pytest.fixture
def world() -> Iterator[GatewayWorld]:
    with GatewayWorld() as world:
        yield world


def growing(map_id: str = "growing-1") -> OccupancyGrid:
    return grid("???? ???? ????", map_id=map_id, in_progress=True)


def patch(row: int, col: int, drawing: str, map_id: str = "growing-1", seq: int = 0) -> GridPatch:
    cells = grid(drawing).cells
    return GridPatch(
        stamp_ns=5, frame_id="map", map_id=map_id, row=row, col=col, cells=cells, seq=seq
    )


class TestAGrowingMap:
    def test_is_the_whole_one_with_its_patches_laid_over_it(self) -> None:
        grown = GrowingMap()
        grown.take(growing())
        assert grown.lay(patch(1, 1, "#. .#"))
        assert grown.grid is not None
        expected = grid("?#.? ?.#? ????").cells
        assert np.array_equal(grown.grid.cells, expected)
        assert (grown.grid.map_id, grown.revision) == ("growing-1", 1)

    def test_leaves_earlier_readers_their_own_cells(self) -> None:
        grown = GrowingMap()
        grown.take(growing())
        before = grown.grid
        grown.lay(patch(0, 0, "#"))
        assert before is not None
        assert (before.cells == -1).all()

    def test_takes_patches_that_came_before_it(self) -> None:
        grown = GrowingMap()
        assert not grown.lay(patch(0, 0, "#"))
        assert not grown.lay(patch(0, 0, ".", map_id="another"))
        assert not grown.lay(patch(0, 1, "#"))
        grown.take(growing())
        assert grown.revision == 2
        assert grown.grid is not None
        assert grown.grid.cells[0].tolist() == [100, 100, -1, -1]

    @pytest.mark.parametrize(("row", "col"), [(3, 0), (0, 4), (2, 3), (99, 99)])
    def test_refuses_what_does_not_lie_on_it(self, row: int, col: int) -> None:
        grown = GrowingMap()
        grown.take(growing())
        assert not grown.lay(patch(row, col, "## ##"))
        assert grown.revision == 0

    def test_begins_anew_with_every_whole_map(self) -> None:
        grown = GrowingMap()
        grown.take(growing())
        grown.lay(patch(0, 0, "#"))
        grown.take(growing("growing-2"))
        assert not grown.lay(patch(0, 0, "#"))
        assert grown.revision == 0


class TestOverHttp:
    def test_the_files_of_a_map_change_with_its_patches(self, world: GatewayWorld) -> None:
        world.publish("mapper", "map", growing())
        first = world.client.get("/api/v1/robots/demo/map.pgm")
        world.publish("mapper", "map_patch", patch(0, 0, "#"))
        second = world.client.get("/api/v1/robots/demo/map.pgm")
        assert first.headers["etag"] == '"growing-1"'
        assert second.headers["etag"] == '"growing-1.1"'
        assert first.content != second.content
        again = {"if-none-match": second.headers["etag"]}
        assert world.client.get("/api/v1/robots/demo/map.pgm", headers=again).status_code == 304

    def test_who_joins_late_gets_the_map_as_it_is_now(self, world: GatewayWorld) -> None:
        world.publish("mapper", "map", growing())
        world.publish("mapper", "map_patch", patch(0, 0, "#"))
        with world.stream("?topics=map,map_patch") as stream:
            assert cbor2.loads(stream.receive_bytes())["topic"] == "hello"
            told = cbor2.loads(stream.receive_bytes())
            assert told["topic"] == "map"
            assert decode(OccupancyGrid, told["payload"]).cells[0, 0] == 100
            world.publish("mapper", "map_patch", patch(0, 1, "#"))
            told = cbor2.loads(stream.receive_bytes())
            assert told["topic"] == "map_patch"
            assert decode(GridPatch, told["payload"]).col == 1

    def test_what_happens_to_the_map_is_news_but_not_that_it_grows(
        self, world: GatewayWorld
    ) -> None:
        def status(mode: str, redraws: int = 0) -> None:
            fields = {"mode": mode, "sensor": "laser", "redraws": redraws, "steps": 7}
            fields |= {"stamp_ns": 1, "frame_id": "map", "since_ns": 9}
            world.publish("mapper", "mapping_status", MappingStatus.model_validate(fields))

        status("mapping")
        for number in range(3):
            world.publish("mapper", "map", growing(f"growing-{number}"))
        status("mapping", redraws=1)
        status("mapping", redraws=1)
        status("handing_over", redraws=1)
        status("idle", redraws=1)
        assert world.events() == [
            "A map is made by laser",
            "Old poses were corrected: the map is drawn anew",
            "The map is finished, of 7 measurements",
        ]

    def test_the_pose_is_taken_from_the_mapper_too(self, world: GatewayWorld) -> None:
        world.publish("mapper", "pose", pose_estimate(world.now_ns, 4.0))
        assert world.client.get("/api/v1/robots/demo/pose").json()["pose"]["x"] == 4.0


def sent(outbox: Outbox) -> list[bytes]:
    async def take() -> list[bytes]:
        return [await outbox.take() or b"" for _ in range(len(outbox._pending))]

    return asyncio.run(take())


def stepped(outbox: Outbox, count: int) -> Outbox:
    """Put steps that say their number into an outbox."""

    def say(text: str) -> Callable[[], bytes]:
        return text.encode

    whole = ("map", "mapper"), say("map")
    for number in range(count):
        outbox.put_step(("map_patch", str(number)), say(str(number)), whole)
    return outbox


class TestASlowClient:
    def test_gets_every_patch_in_order(self) -> None:
        assert sent(stepped(Outbox(), 3)) == [b"0", b"1", b"2"]

    def test_gets_the_whole_map_in_place_of_too_many(self) -> None:
        assert sent(stepped(Outbox(), MOST_STEPS + 3)) == [
            b"map",
            b"%d" % (MOST_STEPS + 1),
            b"%d" % (MOST_STEPS + 2),
        ]

    def test_that_did_not_ask_for_patches_gets_none(self) -> None:
        assert not stepped(Outbox({"pose"}), 3).has_more
        outbox = Outbox()
        outbox.pause()
        assert not stepped(outbox, 3).has_more


class Library:
    """A mapper with one map in its library, and what it was asked."""

    def __init__(self, world: GatewayWorld) -> None:
        self.stored: list[MapStore] = []
        self.deleted: list[str] = []
        self.refusal = ""
        answers: dict[str, Callable[..., object]] = {
            "map_list": lambda _: MapList(maps=(self.map,)),
            "map_fetch": self.fetch,
            "map_store": self.store,
            "map_load": self.load,
            "map_delete": self.delete,
        }
        for query, handler in answers.items():
            world.answer("mapper", query, handler)  # type: ignore[arg-type]  # of different requests
        self.mapper: Node = world.other("mapper")

    @property
    def map(self) -> StoredMap:
        return StoredMap(
            name="office",
            map_id="abc",
            rows=3,
            cols=4,
            resolution=0.05,
            saved_ns=1,
            files=tuple(FILES),
            can_go_on=False,
        )

    def fetch(self, request: MapFetch) -> MapFile:
        return MapFile(content=np.frombuffer(FILES[request.file], np.int8))

    def store(self, request: MapStore) -> MapSaved:
        if self.refusal:
            raise RefusedError(self.refusal)
        self.stored.append(request)
        return MapSaved(name=request.name, map_id="abc", path=f"maps/{request.name}")

    def load(self, request: MapLoad) -> MapLoaded:
        assert request.map == "office"
        return MapLoaded(map_id="abc", rows=3, cols=4)

    def delete(self, request: MapDelete) -> Done:
        self.deleted.append(request.name)
        return Done()


@pytest.fixture
def library(world: GatewayWorld) -> Library:
    return Library(world)


@pytest.mark.usefixtures("library")
class TestTheLibrary:
    def test_is_listed(self, world: GatewayWorld) -> None:
        listed = world.client.get(MAPS).json()
        assert [one["name"] for one in listed["maps"]] == ["office"]
        assert world.client.get(f"{MAPS}/office").json() == listed["maps"][0]
        assert world.events() == []

    def test_is_downloaded_whole_and_file_by_file(self, world: GatewayWorld) -> None:
        answer = world.client.get(f"{MAPS}/office/archive")
        assert answer.headers["content-type"] == "application/zip"
        assert 'filename="office.zip"' in answer.headers["content-disposition"]
        with zipfile.ZipFile(io.BytesIO(answer.content)) as archive:
            assert {name: archive.read(name) for name in archive.namelist()} == FILES
        assert world.client.get(f"{MAPS}/office/files/map.pgm").content == FILES["map.pgm"]

    def test_takes_an_archive(self, world: GatewayWorld, library: Library) -> None:
        answer = world.client.put(f"{MAPS}/new", content=packed(FILES))
        assert answer.status_code == 200
        assert answer.json() == {"name": "new", "map_id": "abc", "path": "maps/new"}
        (store,) = library.stored
        assert {one.name: one.content.tobytes() for one in store.files} == FILES

    def test_is_activated_and_deleted(self, world: GatewayWorld, library: Library) -> None:
        assert world.client.post(f"{MAPS}/office/activate").json()["map_id"] == "abc"
        assert world.client.delete(f"{MAPS}/office").status_code == 200
        assert library.deleted == ["office"]

    @pytest.mark.parametrize(
        ("method", "path"),
        [
            ("GET", "none"),
            ("GET", "none/archive"),
            ("GET", "none/files/map.yaml"),
            ("GET", "office/files/map.png"),
            ("POST", "none/activate"),
            ("DELETE", "none"),
        ],
    )
    def test_says_what_it_does_not_have(self, world: GatewayWorld, method: str, path: str) -> None:
        answer = world.client.request(method, f"{MAPS}/{path}")
        assert answer.status_code == 404
        assert "it has" in answer.json()["detail"]

    def test_says_why_a_map_was_refused(self, world: GatewayWorld, library: Library) -> None:
        library.refusal = "the map 'new' was not saved: No space left on device"
        answer = world.client.put(f"{MAPS}/new", content=packed(FILES))
        assert (answer.status_code, answer.json()["detail"]) == (409, library.refusal)

    @pytest.mark.parametrize(
        "body",
        [
            *(b"", b"hello", packed(FILES)[:-9], b"PK\x05\x06" + b"\0" * 18),
            *(with_damaged_content(packed(FILES)), packed_unknown_way(packed(FILES))),
        ],
    )
    def test_takes_nothing_but_archives(self, world: GatewayWorld, body: bytes) -> None:
        answer = world.client.put(f"{MAPS}/new", content=body)
        assert answer.status_code == 422
        assert "archive" in answer.json()["detail"]


def test_a_viewer_may_look_at_the_library_but_not_change_it() -> None:
    tokens = {"viewer_tokens": ["v" * 16], "operator_tokens": ["o" * 16]}
    with GatewayWorld(**tokens) as world:
        Library(world)
        viewer = {"authorization": "Bearer " + "v" * 16}
        assert world.client.get(MAPS, headers=viewer).status_code == 200
        assert world.client.get(f"{MAPS}/office/archive", headers=viewer).status_code == 200
        for method, path in (("PUT", "x"), ("POST", "office/activate"), ("DELETE", "office")):
            answer = world.client.request(method, f"{MAPS}/{path}", headers=viewer)
            assert answer.status_code == 403
        assert world.client.get(MAPS).status_code == 401


def test_without_a_mapper_the_library_is_not_there(world: GatewayWorld) -> None:
    assert world.client.get(MAPS).status_code == 503


class TestAnArchive:
    def test_is_packed(self) -> None:
        assert len(packed({"map.pgm": bytes(100_000)})) < 1000

    def test_comes_back_as_it_was_packed(self) -> None:
        assert {one.name: one.content.tobytes() for one in unpacked(packed(FILES))} == FILES

    def test_may_hold_its_files_in_a_folder(self) -> None:
        made = packed({f"office/{name}": content for name, content in FILES.items()})
        assert {one.name for one in unpacked(made)} == set(FILES)

    def test_with_too_many_files_is_refused(self) -> None:
        with pytest.raises(ArchiveError, match="17 files"):
            unpacked(packed({str(number): b"" for number in range(MOST_FILES + 1)}))

    def test_that_would_fill_the_memory_is_refused(self) -> None:
        with pytest.raises(ArchiveError, match="are taken at most"):
            unpacked(packed({"map.pgm": bytes(61 * 2**20)}))
