"""Reads a log of any known format, told apart by content."""

from collections.abc import Iterator
from itertools import chain
from pathlib import Path

from pilotage.core.logs.carmen import CARMEN
from pilotage.core.logs.ev3 import EV3
from pilotage.core.logs.line_format import LineFormat
from pilotage.core.logs.log_clock import with_one_clock
from pilotage.core.logs.mounts import settle_mounts
from pilotage.core.logs.nanodrone import NANODRONE, NANODRONE_FLAT
from pilotage.core.logs.records import (
    Log,
    LogError,
    OdometryRecord,
    Record,
    ScanRecord,
)
from pilotage.core.logs.ring8 import RING8_FILES, RING8_MEASUREMENTS, RING8_POSES
from pilotage.core.logs.text_log import (
    Damage,
    Line,
    Readings,
    TableFormat,
    lines_of,
    read_lines,
    read_rows,
)
from pilotage.core.logs.wean import WEAN
from pilotage.core.maybe_gzip import read_maybe_gzip

ROS_BAG = "rosbag"
LINE_FORMATS = {line_format.name: line_format for line_format in (CARMEN, WEAN)}
TABLES = (EV3, RING8_MEASUREMENTS, RING8_POSES, NANODRONE, NANODRONE_FLAT)
FORMATS = (*LINE_FORMATS, *dict.fromkeys(table.name for table in TABLES), ROS_BAG)
LARGEST_LOG = 2 * 2**30
"""More bytes than this do not fit beside the services in memory."""
FEW_LINES, FEW_SHARE = 10, 0.1
"""Damaged lines that are passed over: so many, or this share of the lines that matter."""

BAG_MAGIC = b"#ROSBAG V"
STORES = {b"SQLite format 3\0": "SQLite", b"\x89MCAP0\r\n": "MCAP"}
"""How the files of ROS 2 bags begin; MCAP files may be of others."""


def read_log(path: str | Path, log_format: str | None = None) -> Log:
    """Read a log, `.gz` or plain; `log_format` is one of `FORMATS` or None to find out.

    A folder is a ROS 2 bag, or holds the two files of a ring8 log; either of these may also be
    named itself. A few damaged lines, as a power cut leaves them, are passed over and counted.

    Raises:
        LogError: saying in one sentence which file, where possible which line, and why.
    """
    file = Path(path)
    if log_format is not None and log_format not in FORMATS:
        raise LogError(f"{file}: unknown format '{log_format}', known are {', '.join(FORMATS)}")
    if log_format == ROS_BAG or (log_format is None and _is_bag(file)):
        # Imported here: the library for bags takes longer to import than most logs to read.
        from pilotage.core.logs.ros_bag import read_bag  # noqa: PLC0415 - see above

        records, skipped = read_bag(file)
        return _log_of(ROS_BAG, records, skipped)
    if file.is_dir():
        file = _ring8_of(file)
    return _read_text(file, log_format)


def _read_text(file: Path, log_format: str | None) -> Log:
    content = _content(file)
    if content.startswith(BAG_MAGIC):
        raise LogError(f"{file}: a packed ROS bag: unpack it first")
    chosen = _recognise(content, file, log_format)
    if isinstance(chosen, LineFormat):
        records, damaged = read_lines(content, chosen)
    elif chosen.name == RING8_POSES.name:
        records, damaged = _read_ring8(file)
    else:
        records, damaged = read_rows(_rows_of(content, chosen), chosen)
    _refuse_useless(records, damaged, file, chosen.name)
    return _log_of(chosen.name, records, len(damaged))


def _rows_of(content: bytes, chosen: TableFormat) -> Iterator[Line]:
    """Yield the lines of a table, without a first that names its columns."""
    lines = lines_of(content)
    first = next(lines)
    names_columns = chosen.separator is not None and first[1][0][:1].isalpha()
    return lines if names_columns else chain([first], lines)


def _log_of(name: str, records: list[Record], skipped: int) -> Log:
    ordered = sorted(settle_mounts(with_one_clock(records)), key=lambda record: record.stamp)
    return Log(name, tuple(ordered), skipped)


def _is_bag(file: Path) -> bool:
    """Say whether a file or folder is a ROS bag, by its first bytes."""
    if file.is_dir():
        return (file / "metadata.yaml").is_file()
    if not file.is_file():
        return False
    try:
        with file.open("rb") as stream:
            head = stream.read(16)
    except OSError:
        return False
    return head.startswith((BAG_MAGIC, *STORES))


def _ring8_of(folder: Path) -> Path:
    """Return the measurements of a ring8 log in a folder."""
    for ending in ("", ".gz"):
        file = folder / f"measurement.txt{ending}"
        if file.is_file():
            return file
    raise LogError(
        f"{folder}: a folder that is no log: neither metadata.yaml of a ROS 2 bag nor "
        "measurement.txt and poses.txt of a ring8 log"
    )


def _read_ring8(file: Path) -> Readings:
    """Return the records of both files of a ring8 log of which one is given."""
    records: list[Record] = []
    damaged: list[Damage] = []
    for name, table in RING8_FILES.items():
        part = file.with_name(name + (".gz" if file.suffix == ".gz" else ""))
        if not part.is_file():
            raise LogError(f"{file}: a ring8 log has two files, and {part.name} is not beside it")
        some, bad = read_rows(lines_of(_content(part)), table)
        records += some
        damaged += bad
    return records, damaged


def _content(file: Path) -> bytes:
    """Return the unpacked content of a file."""
    try:
        return read_maybe_gzip(file, LARGEST_LOG)
    except FileNotFoundError:
        raise LogError(f"{file}: the log does not exist") from None
    except (OSError, ValueError) as error:
        raise LogError(f"{file}: the log cannot be read ({error})") from None


def _recognise(content: bytes, file: Path, log_format: str | None) -> LineFormat | TableFormat:
    """Return the format asked for, or that of the first line that one can read."""
    if next(lines_of(content), None) is None:
        raise LogError(f"{file}: the log is empty")
    if log_format in LINE_FORMATS:
        return LINE_FORMATS[log_format]
    tables = [table for table in TABLES if log_format in {None, table.name}]
    problem = f"{file}: no line of a known format ({', '.join(FORMATS)})"
    for number, words in lines_of(content):
        for table in tables:
            if table.fits(words):
                return table
        for candidate in LINE_FORMATS.values() if log_format is None else ():
            if words[0] in candidate.parsers:
                try:
                    candidate.parsers[words[0]](words)
                except ValueError as error:
                    problem = f"{file}, line {number}: {error}"
                else:
                    return candidate
    raise LogError(problem if log_format is None else f"{file}: no line of a {log_format} log")


def _refuse_useless(records: list[Record], damaged: list[Damage], file: Path, name: str) -> None:
    """Raise LogError if nothing useful was read, or too much is damaged."""
    if len(damaged) > max(FEW_LINES, FEW_SHARE * len(records)) or (damaged and not records):
        number, problem = damaged[0]
        raise LogError(f"{file}, line {number}: {problem} ({len(damaged)} lines are damaged)")
    if not any(isinstance(record, ScanRecord | OdometryRecord) for record in records):
        raise LogError(f"{file}: neither a laser scan nor odometry in the format {name}")
