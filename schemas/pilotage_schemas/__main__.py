"""Write what is generated from the registry, or check that it is fresh.

python -m pilotage_schemas            write v1/*.json and the tables of the READMEs
python -m pilotage_schemas --check    exit 1 naming whatever is stale
"""

import argparse
import json
import sys
from pathlib import Path

from pilotage_schemas.documents import Json, all_kinds, asyncapi, json_schema
from pilotage_schemas.tables import MissingMarkersError, with_tables
from pilotage_schemas.topics import VERSION

PACKAGE = Path(__file__).resolve().parent
README_FOLDERS = (PACKAGE.parent, PACKAGE.parent.parent)


def generated() -> dict[Path, str]:
    """Return the wanted text of every generated file; OSError outside a checkout."""
    folder = PACKAGE / f"v{VERSION}"
    files = {folder / f"{kind.__name__}.json": _text(json_schema(kind)) for kind in all_kinds()}
    files[folder / "asyncapi.json"] = _text(asyncapi())
    for readme in (parent / "README.md" for parent in README_FOLDERS):
        try:
            files[readme] = with_tables(readme.read_text(encoding="utf-8"))
        except MissingMarkersError as error:
            raise MissingMarkersError(f"{readme}: {error}") from error
    return files


def stale(files: dict[Path, str]) -> list[Path]:
    """Return the files that differ from what they should be, and those that should not be."""
    differing = [path for path, text in files.items() if _current(path) != text]
    leftover = [path for path in (PACKAGE / f"v{VERSION}").glob("*.json") if path not in files]
    return sorted(differing + leftover)


def main() -> int:
    """Write or check; return the exit code."""
    parser = argparse.ArgumentParser("pilotage_schemas", description=__doc__.splitlines()[0])
    parser.add_argument("--check", action="store_true", help="write nothing, fail when stale")
    check = parser.parse_args().check
    try:
        files = generated()
    except (OSError, MissingMarkersError) as error:
        sys.stderr.write(f"pilotage_schemas: {error}\n")
        return 2
    found = stale(files)
    if check and found:
        names = ", ".join(path.name for path in found)
        sys.stderr.write(f"stale: {names}; renew them with `python -m pilotage_schemas`\n")
        return 1
    for path in found:
        _renew(path, files.get(path))
    return 0


def _renew(path: Path, text: str | None) -> None:
    if text is None:
        path.unlink()
        return
    path.parent.mkdir(exist_ok=True)
    path.write_text(text, encoding="utf-8")


def _current(path: Path) -> str | None:
    return path.read_text(encoding="utf-8") if path.exists() else None


def _text(document: Json) -> str:
    return json.dumps(document, indent=2, ensure_ascii=False) + "\n"


if __name__ == "__main__":
    sys.exit(main())
