"""Reads a log of any known format, told apart by content."""

from collections.abc import Iterator
from pathlib import Path

from pilotage.core.logs.carmen import CARMEN
from pilotage.core.logs.line_format import LineFormat
from pilotage.core.logs.mounts import settle_mounts
from pilotage.core.logs.records import Log, LogError, OdometryRecord, Record, ScanRecord
from pilotage.core.logs.wean import WEAN
from pilotage.core.maybe_gzip import read_maybe_gzip

FORMATS = {line_format.name: line_format for line_format in (CARMEN, WEAN)}
LARGEST_LOG = 2 * 2**30
"""More bytes than this do not fit beside the services in memory."""
FEW_LINES, FEW_SHARE = 10, 0.1
"""Damaged lines that are passed over: so many, or this share of the lines that matter."""

_Line = tuple[int, list[bytes]]
"""Number of a line, from 1, and its words."""


def read_log(path: str | Path, log_format: str | None = None) -> Log:
    """Read a log, `.gz` or plain; `log_format` is one of `FORMATS` or None to find out.

    A few damaged lines, as a power cut leaves them, are passed over and counted.

    Raises:
        LogError: saying in one sentence which file, where possible which line, and why.
    """
    file = Path(path)
    if log_format is not None and log_format not in FORMATS:
        raise LogError(f"{file}: unknown format '{log_format}', known are {', '.join(FORMATS)}")
    lines = list(_lines_of(_content(file)))
    if not lines:
        raise LogError(f"{file}: the log is empty")
    chosen = FORMATS[log_format] if log_format else _recognise(lines, file)
    records, damaged = _parse(lines, chosen)
    _refuse_useless(records, damaged, file, chosen)
    ordered = sorted(settle_mounts(records), key=lambda record: record.stamp)
    return Log(chosen.name, tuple(ordered), len(damaged))


def _content(file: Path) -> bytes:
    """Return the unpacked content of a file."""
    try:
        return read_maybe_gzip(file, LARGEST_LOG)
    except FileNotFoundError:
        raise LogError(f"{file}: the log does not exist") from None
    except (OSError, ValueError) as error:
        raise LogError(f"{file}: the log cannot be read ({error})") from None


def _lines_of(content: bytes) -> Iterator[_Line]:
    """Yield the lines that hold words and are no comments."""
    for number, line in enumerate(content.splitlines(), start=1):
        words = line.split()
        if words and not words[0].startswith(b"#"):
            yield number, words


def _recognise(lines: list[_Line], file: Path) -> LineFormat:
    """Return the format of the first line that one can read."""
    problem = f"{file}: no line of a known format ({', '.join(FORMATS)})"
    for number, words in lines:
        for candidate in FORMATS.values():
            if words[0] in candidate.parsers:
                try:
                    candidate.parsers[words[0]](words)
                except ValueError as error:
                    problem = f"{file}, line {number}: {error}"
                else:
                    return candidate
    raise LogError(problem)


def _parse(
    lines: list[_Line], chosen: LineFormat
) -> tuple[list[Record], list[tuple[int, ValueError]]]:
    """Return the records of the lines, and number and problem of the damaged ones."""
    parsers = chosen.parsers_for({words[0] for _, words in lines})
    records: list[Record] = []
    damaged: list[tuple[int, ValueError]] = []
    for number, words in lines:
        parse = parsers.get(words[0])
        if parse is not None:
            try:
                records.append(parse(words))
            except ValueError as error:
                damaged.append((number, error))
        elif not _is_other_message(words[0]):
            damaged.append((number, ValueError("not a line of this format")))
    return records, damaged


def _is_other_message(word: bytes) -> bool:
    """Say whether a word may open a message that is of no use here, such as PARAM or BUMPER."""
    return word.isupper() and word.isalnum()


def _refuse_useless(
    records: list[Record],
    damaged: list[tuple[int, ValueError]],
    file: Path,
    chosen: LineFormat,
) -> None:
    """Raise LogError if nothing useful was read, or too much is damaged."""
    if len(damaged) > max(FEW_LINES, FEW_SHARE * len(records)) or (damaged and not records):
        number, problem = damaged[0]
        raise LogError(f"{file}, line {number}: {problem} ({len(damaged)} lines are damaged)")
    if not any(isinstance(record, ScanRecord | OdometryRecord) for record in records):
        raise LogError(f"{file}: neither a scan nor odometry in the format {chosen.name}")
