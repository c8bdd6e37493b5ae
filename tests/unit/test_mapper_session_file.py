import contextlib
import io
import zipfile

import numpy as np
import pytest

from dead_reckoning import DeadReckoning
from pilotage.core.odometry_watch import OdometrySample
from pilotage.mapper import session_file
from pilotage.mapper.mapping_session import MappingSession
from pilotage.mapper.session_file import packed_session, resume_session, unpacked_session


def driven() -> MappingSession:
    """A session after two messages of odometry."""
    session = MappingSession(DeadReckoning("sonar"))
    for seq in range(2):
        session.take_odometry(OdometrySample(seq, seq * 10**8, np.array([0.01 * seq, 0.0, 0.0])))
    return session


@pytest.fixture
def content() -> bytes:
    return packed_session("sonar", driven())


def encrypted(content: bytes) -> bytes:
    """The archive with all its files said to be encrypted."""
    changed = bytearray(content)
    for mark, flags in ((b"PK\x03\x04", 6), (b"PK\x01\x02", 8)):
        at = content.find(mark)
        while at >= 0:
            changed[at + flags] |= 1
            at = content.find(mark, at + 1)
    return bytes(changed)


def archive_of(**files: bytes) -> bytes:
    made = io.BytesIO()
    with zipfile.ZipFile(made, "w") as archive:
        for name, inside in files.items():
            archive.writestr(f"{name}.npy", inside)
    return made.getvalue()


def arrays_of(**arrays: np.ndarray) -> bytes:
    made = io.BytesIO()
    np.savez(made, allow_pickle=True, **arrays)
    return made.getvalue()


def test_session_goes_on_from_its_file(content: bytes) -> None:
    sensor, arrays = unpacked_session(content)
    session = MappingSession(DeadReckoning(sensor))
    resume_session(session, arrays)
    assert sensor == "sonar"
    assert session.newest is not None
    assert session.newest.stamp_ns == 10**8


@pytest.mark.parametrize("length", [0, 3, 40, 300, -30, -1])
def test_file_that_is_cut_off_is_refused(content: bytes, length: int) -> None:
    with pytest.raises(ValueError, match="damaged"):
        unpacked_session(content[:length])


@pytest.mark.parametrize(
    "bad",
    [
        b"nonsense",
        b"PK\x03\x04garbage",
        b"\x93NUMPY\x01\x00",
        archive_of(sensor=b"\x93NUMPY\x01\x00\xff\xff{"),
        arrays_of(counts=np.zeros(3)),
        arrays_of(sensor=np.array([{}], dtype=object)),
    ],
    ids=["prose", "zip", "array", "header", "no sensor", "pickle"],
)
def test_file_that_is_none_is_refused(bad: bytes) -> None:
    with pytest.raises(ValueError, match="damaged"):
        unpacked_session(bad)


def test_encrypted_file_is_refused(content: bytes) -> None:
    with pytest.raises(ValueError, match="damaged"):
        unpacked_session(encrypted(content))


def test_damaged_bytes_are_refused_or_do_no_harm(content: bytes) -> None:
    for at in range(0, len(content), 7):
        changed = bytearray(content)
        changed[at] ^= 0xFF
        with contextlib.suppress(ValueError):
            unpacked_session(bytes(changed))


def test_file_that_unpacks_to_too_much_is_refused(
    content: bytes, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(session_file, "LARGEST", 100)
    with pytest.raises(ValueError, match="100 are taken at most"):
        unpacked_session(content)


@pytest.mark.parametrize("shape", [(), (0,), (1, 1), (50,)])
def test_arrays_of_other_shapes_are_refused(content: bytes, shape: tuple[int, ...]) -> None:
    _, arrays = unpacked_session(content)
    bad = arrays | {"session.counts": np.zeros(shape), "session.newest": np.zeros(shape)}
    with pytest.raises(ValueError, match="does not fit"):
        resume_session(MappingSession(DeadReckoning("sonar")), bad)
