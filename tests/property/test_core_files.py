import contextlib
import gzip
import tempfile
from io import BytesIO
from pathlib import Path

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays
from PIL import Image

from pilotage.core.grid import GridGeometry, OccupancyMap
from pilotage.core.logs import LogError, read_log
from pilotage.core.map_files import MapFileError, load_map, map_digest, save_map

SHAPES = array_shapes(min_dims=2, max_dims=2, min_side=1, max_side=9)
TRINARY = st.sampled_from([-1, 0, 100])
CELLS = (TRINARY | st.integers(-1, 100)).flatmap(lambda _: st.just(TRINARY)) | st.just(
    st.integers(-1, 100)
)
GRIDS = st.tuples(SHAPES, CELLS).flatmap(
    lambda choice: arrays(np.int8, choice[0], elements=choice[1])
)
NUMBERS = st.floats(-1e6, 1e6)


@settings(max_examples=50)
@given(GRIDS, st.floats(1e-3, 10.0), st.tuples(NUMBERS, NUMBERS, st.floats(-7.0, 7.0)))
def test_any_map_survives_the_disk(
    cells: np.ndarray, resolution: float, origin: tuple[float, float, float]
) -> None:
    rows, cols = cells.shape
    world = OccupancyMap(GridGeometry(rows, cols, resolution, origin), cells)
    with tempfile.TemporaryDirectory() as folder:
        save_map(world, Path(folder) / "map.yaml")
        assert map_digest(load_map(Path(folder) / "map.yaml")) == map_digest(world)


def load_bytes(yaml_bytes: bytes, image_bytes: bytes) -> None:
    """Load a map of these files; the only error may be MapFileError, in one line."""
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "m.yaml").write_bytes(yaml_bytes)
        (Path(folder) / "m.img").write_bytes(image_bytes)
        try:
            load_map(Path(folder) / "m.yaml")
        except MapFileError as error:
            assert "\n" not in str(error)  # noqa: PT017 - most inputs are refused, not all


def read_bytes(content: bytes) -> None:
    """Read a log of these bytes; the only error may be LogError, in one line."""
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "run.log").write_bytes(content)
        try:
            read_log(Path(folder) / "run.log")
        except LogError as error:
            assert "\n" not in str(error)  # noqa: PT017 - most inputs are refused, not all


YAML = (
    b"image: m.img\nresolution: 0.1\norigin: [0, 0, 0]\noccupied_thresh: 0.65\nfree_thresh: 0.2\n"
)
PGM = b"P5\n3 2\n255\nabcdef"
WEAN_MAP = b"robot_specifications->resolution 10\nglobal_map[0]: 1 3\n0.5 1 -1\n"
LOG = (
    b"ODOM 1.0 2.0 4.0 0.5 -0.1 0 10.5 robot 0.25\n"
    b"FLASER 2 1.5 2.5 0 0 0 0 0 0 11.5 robot 1\n"
    b"ROBOTLASER1 0 -0.5 1 0.5 20 0.01 0 2 1 2 0 0 0 0 0 0 0 0 0 0 0 0 12.5 robot 1\n"
    b"SONAR 0.2 1 1.5 0 0 0 13.5 robot 1\nCOMPASS 1 2 3\nCOMMAND 1 2 3\n"
)


EV3 = b"0 0 0" + b" 100.5" * 325 + b"\n" + b"10 0 0.5" + b" 255" * 325 + b"\n"
DRONE = b"# t\n" + b"0.1,1,2,0.3,0.5,0.5,1.5,4.2,3.9,2.8\n" * 3


def damaged(content: bytes) -> st.SearchStrategy[bytes]:
    """The content with some bytes put in place of others."""
    return st.tuples(st.integers(0, len(content)), st.integers(0, 8), st.binary(max_size=8)).map(
        lambda cut: content[: cut[0]] + cut[2] + content[cut[0] + cut[1] :]
    )


@given(st.binary(max_size=200) | damaged(YAML) | damaged(WEAN_MAP))
def test_odd_bytes_for_a_map_are_refused_not_fatal(content: bytes) -> None:
    load_bytes(content, PGM)


@given(st.text(max_size=80))
def test_odd_text_for_a_map_is_refused_not_fatal(text: str) -> None:
    load_bytes(text.encode("utf-8", "surrogatepass"), PGM)


@given(st.binary(max_size=200) | damaged(PGM) | st.binary(max_size=60).map(b"P2 ".__add__))
def test_odd_bytes_for_an_image_are_refused_not_fatal(content: bytes) -> None:
    load_bytes(YAML, content)


@given(st.data())
def test_damaged_png_is_refused_not_fatal(data: st.DataObject) -> None:
    stream = BytesIO()
    Image.fromarray(np.zeros((4, 5), np.uint8)).save(stream, "PNG")
    load_bytes(YAML, data.draw(damaged(stream.getvalue())))


@given(st.binary(max_size=300) | damaged(LOG) | damaged(EV3) | damaged(DRONE))
def test_odd_bytes_for_a_log_are_refused_not_fatal(content: bytes) -> None:
    read_bytes(content)


@given(damaged(gzip.compress(LOG)))
def test_damaged_gzip_is_refused_not_fatal(content: bytes) -> None:
    read_bytes(content)


WORDS = st.sampled_from(
    [
        "ODOM",
        "FLASER",
        "ROBOTLASER1",
        "RAWLASER1",
        "SONAR",
        "TRUEPOS",
        "COMPASS",
        "COMMAND",
        "O",
        "L",
    ]
)
VALUES = st.sampled_from(["0", "1", "2", "-1", "1e308", "-1e308", "nan", "inf", "x", "1e-320"])


@given(st.lists(st.tuples(WORDS, st.lists(VALUES, max_size=30)), max_size=6))
def test_lines_of_odd_values_are_refused_not_fatal(lines: list[tuple[str, list[str]]]) -> None:
    text = "\n".join(" ".join([word, *values]) for word, values in lines)
    with contextlib.suppress(LogError):
        read_bytes(text.encode())
