"""Logs of lines whose first word says what they hold, and logs of rows of numbers."""

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from io import BytesIO

from pilotage.core.logs.line_format import LineFormat
from pilotage.core.logs.records import Record

Line = tuple[int, list[bytes]]
"""Number of a line, from 1, and its words."""

Damage = tuple[int, ValueError]
"""Number of a line that was passed over, and what is wrong with it."""

Readings = tuple[list[Record], list[Damage]]


@dataclass(frozen=True)
class TableFormat:
    """A format of rows of numbers, told by their count.

    `parse` takes the place of a row, from 0, and its numbers; ValueError if it is damaged.
    """

    name: str
    columns: int
    parse: Callable[[int, list[float]], Sequence[Record]]
    separator: bytes | None = None
    """Between numbers; None is any space."""

    def fits(self, words: list[bytes]) -> bool:
        """Say whether a line is a row of this format."""
        try:
            self.numbers(words)
        except ValueError:
            return False
        return True

    def numbers(self, words: list[bytes]) -> list[float]:
        """Return the numbers of a row; ValueError if they are too few or no numbers."""
        parts = b" ".join(words).split(self.separator) if self.separator else words
        if len(parts) != self.columns:
            raise ValueError(f"{len(parts)} values instead of {self.columns}")
        values = [float(part) for part in parts]
        if not math.isfinite(sum(values)):
            raise ValueError("values that are not finite")
        return values


def lines_of(content: bytes) -> Iterator[Line]:
    """Yield the lines that hold words and are no comments.

    One by one: the words of all lines of a long log would take ten times its memory.
    """
    for number, line in enumerate(BytesIO(content), start=1):
        words = line.split()
        if words and not words[0].startswith(b"#"):
            yield number, words


def read_lines(content: bytes, chosen: LineFormat) -> Readings:
    """Return the records of the lines, and number and problem of the damaged ones."""
    parsers = chosen.parsers_for({words[0] for _, words in lines_of(content)})
    records: list[Record] = []
    damaged: list[Damage] = []
    for number, words in lines_of(content):
        parse = parsers.get(words[0])
        if parse is not None:
            try:
                records.append(parse(words))
            except ValueError as error:
                damaged.append((number, error))
        elif not _is_other_message(words[0]):
            damaged.append((number, ValueError("not a line of this format")))
    return records, damaged


def read_rows(lines: Iterable[Line], chosen: TableFormat) -> Readings:
    """Return the records of the rows, and number and problem of the damaged ones."""
    records: list[Record] = []
    damaged: list[Damage] = []
    for place, (number, words) in enumerate(lines):
        try:
            records.extend(chosen.parse(place, chosen.numbers(words)))
        except ValueError as error:
            damaged.append((number, error))
    return records, damaged


def _is_other_message(word: bytes) -> bool:
    """Say whether a word may open a message that is of no use here, such as PARAM or BUMPER."""
    return word.isupper() and word.isalnum()
