"""Reads parsed JSON strictly: whoever asks for a value gets it, or one sentence why not."""

import math
from collections.abc import Iterator

LARGEST = 1e9
"""Numbers beyond this [m, rad] mean a mistake."""

MOST_LETTERS = 64


class JsonError(ValueError):
    """A value that is missing or of another kind; the text says where it stands and what it is."""


class Value:
    """A value and where it stands: as `step` (`.properties` or `[3]`) of `parent`."""

    __slots__ = ("_parent", "_step", "json")

    def __init__(self, json: object, parent: "Value | None" = None, step: str | int = "") -> None:
        self.json = json
        self._parent, self._step = parent, step

    @property
    def path(self) -> str:
        """The path to it, e.g. `features[3].properties.id`; made only where it is needed."""
        before = "" if self._parent is None else self._parent.path
        if isinstance(self._step, int):
            return f"{before}[{self._step}]"
        return f"{before}.{self._step}" if before else self._step

    def member(self, name: str) -> "Value":
        """Return a member of an object; JsonError if there is none."""
        found = self.optional(name)
        if found is None:
            raise JsonError(f"{Value(None, self, name).path} is missing")
        return found

    def optional(self, name: str) -> "Value | None":
        """Return a member of an object, None where it is missing or null."""
        if not isinstance(self.json, dict):
            raise JsonError(f"{self.path or 'the document'} must be an object")
        found = self.json.get(name)
        return None if found is None else Value(found, self, name)

    def items(self) -> Iterator["Value"]:
        """Yield what an array holds."""
        if not isinstance(self.json, list):
            raise JsonError(f"{self.path} must be an array")
        for i, item in enumerate(self.json):
            yield Value(item, self, i)

    def number(self) -> float:
        """Return a finite number of reasonable size."""
        value = self.json
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise JsonError(f"{self.path} must be a number")
        if not abs(value) <= LARGEST:
            raise JsonError(f"{self.path} must be a number no larger than {LARGEST:g}")
        return float(value)

    def not_negative(self) -> float:
        """Return a number that is zero or more."""
        if self.number() < 0.0:
            raise JsonError(f"{self.path} must not be negative")
        return self.number()

    def angle(self) -> float:
        """Return an angle in [-pi, pi] rad."""
        if abs(self.number()) > math.pi:
            raise JsonError(f"{self.path} must be an angle in [-pi, pi]")
        return self.number()

    def identity(self) -> int:
        """Return a whole number from 0 to 2^31 - 1."""
        value = self.json
        if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value < 2**31:
            raise JsonError(f"{self.path} must be a whole number from 0 to 2147483647")
        return value

    def text(self) -> str:
        """Return a short text."""
        if not isinstance(self.json, str) or len(self.json) > MOST_LETTERS:
            raise JsonError(f"{self.path} must be a text of at most {MOST_LETTERS} letters")
        return self.json

    def one_of(self, words: tuple[str, ...]) -> str:
        """Return one of these words."""
        if not isinstance(self.json, str) or self.json not in words:
            raise JsonError(f"{self.path} must be one of {', '.join(words)}")
        return self.json
