"""The source tree as the architecture tests see it."""

import ast
import shutil
import subprocess
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path

REPOSITORY = Path(__file__).resolve().parents[2]
PILOTAGE = REPOSITORY / "services" / "pilotage"
SCHEMAS = REPOSITORY / "schemas" / "pilotage_schemas"
NOT_SERVICES = {"core", "bus", "experiments", "bench"}


@dataclass(frozen=True)
class Module:
    """One Python file of the product: its path, its dotted name, its syntax tree."""

    path: Path
    name: str

    @cached_property
    def text(self) -> str:
        """The source."""
        return self.path.read_text(encoding="utf-8")

    @cached_property
    def tree(self) -> ast.Module:
        """The parsed source."""
        return ast.parse(self.text)

    def imports(self) -> Iterator[tuple[int, str]]:
        """Line and dotted name of each import, wherever in the file it stands."""
        for node in ast.walk(self.tree):
            if isinstance(node, ast.Import):
                yield from ((node.lineno, alias.name) for alias in node.names)
            elif isinstance(node, ast.ImportFrom) and node.module:
                yield node.lineno, node.module

    def libraries(self) -> Iterator[tuple[int, str]]:
        """Line and top-level package of each import."""
        return ((line, imported.split(".")[0]) for line, imported in self.imports())

    def lines(self) -> Iterator[tuple[int, str]]:
        """The numbered lines."""
        return enumerate(self.text.splitlines(), start=1)

    def functions(self) -> Iterator[ast.FunctionDef | ast.AsyncFunctionDef]:
        """Every function and method."""
        for node in ast.walk(self.tree):
            if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
                yield node

    def __str__(self) -> str:
        return str(self.path.relative_to(REPOSITORY))


@cache
def product_modules() -> list[Module]:
    """Every module of both packages, by name."""
    found = [
        Module(path, ".".join(path.relative_to(root.parent).with_suffix("").parts))
        for root in (PILOTAGE, SCHEMAS)
        for path in root.rglob("*.py")
    ]
    return sorted(found, key=lambda module: module.name)


def service_folders() -> list[Path]:
    """The folders of the services: all packages but core, bus, experiments and bench."""
    return sorted(
        folder
        for folder in PILOTAGE.iterdir()
        if folder.is_dir()
        and folder.name not in NOT_SERVICES
        and next(folder.rglob("*.py"), None) is not None
    )


@cache
def written_files() -> list[Path]:
    """Every file under version control, or about to be."""
    git = shutil.which("git")
    assert git is not None, "these tests look at what is under version control: install git"
    listed = subprocess.run(
        [git, "ls-files", "--cached", "--others", "--exclude-standard"],
        cwd=REPOSITORY,
        capture_output=True,
        text=True,
        check=True,
    )
    paths = (REPOSITORY / name for name in listed.stdout.splitlines())
    return [path for path in paths if path.is_file()]


def teach(violations: Iterable[str]) -> None:
    """Fail with all violations at once, each saying what the rule is for."""
    found = list(violations)
    assert not found, "\n" + "\n".join(found)
