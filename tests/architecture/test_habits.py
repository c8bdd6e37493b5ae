"""Rules of the house that no linter knows."""

import re
from pathlib import Path

from architecture.source_tree import REPOSITORY, product_modules, teach, written_files

MARKERS = re.compile(r"\b(TO[D]O|FIX[M]E|X[X]X|HA[C]K)\b")
MACHINE_PATHS = re.compile(r"(?<![\w.:/-])/(work|home|root|Users)/\w")
BAD_NAMES = {"utils", "util", "helpers", "helper", "common", "misc", "manager", "stuff", "base"}
IGNORE = re.compile(r"#\s*(type: ignore|noqa)(\S*)(.*)")
TEXT = {
    ".py",
    ".md",
    ".js",
    ".css",
    ".html",
    ".yaml",
    ".yml",
    ".toml",
    ".json",
    ".json5",
    ".sh",
    "",
}
GENERATED = {"requirements.lock", "requirements-test.lock", "LICENSE"}


def text_files() -> list[Path]:
    """What a person writes."""
    files = written_files()
    return [path for path in files if path.suffix in TEXT and path.name not in GENERATED]


def lines_matching(pattern: re.Pattern[str]) -> list[str]:
    return [
        f"{path.relative_to(REPOSITORY)}:{number}: {line.strip()[:80]}"
        for path in text_files()
        for number, line in enumerate(path.read_text("utf-8", "replace").splitlines(), start=1)
        if pattern.search(line)
    ]


def test_nothing_is_left_over_to_be_done() -> None:
    teach(f"{place}: do it now, or open an issue" for place in lines_matching(MARKERS))


def test_no_path_of_somebodys_machine_is_written_down() -> None:
    teach(f"{place}: say it relative to the checkout" for place in lines_matching(MACHINE_PATHS))


def test_modules_are_named_after_things_of_the_field() -> None:
    teach(
        f"{module}: name the file after what it holds, so that it need not be opened to be found"
        for module in product_modules()
        if module.path.stem in BAD_NAMES
    )


def test_an_exception_to_a_rule_names_the_rule_and_the_reason() -> None:
    teach(
        f"{module}:{number}: write `# {found.group(1)}...code  - reason`: {line.strip()[:80]}"
        for module in product_modules()
        for number, line in module.lines()
        if (found := IGNORE.search(line)) and not is_reasoned(found)
    )


def is_reasoned(found: re.Match[str]) -> bool:
    """Whether the exception has a code, and words after it."""
    code, rest = found.group(2), found.group(3)
    return bool(re.search(r"[A-Z\[]", code + rest)) and bool(re.search(r"[-#]\s*\w{2}", rest))


def test_nothing_is_printed() -> None:
    teach(
        f"{module}:{number}: print belongs to a terminal; log in a service, typer.echo in the cli"
        for module in product_modules()
        for number, line in module.lines()
        if re.match(r"\s*print\(", line)
    )


def test_numba_is_used_through_the_projects_own_decorator() -> None:
    teach(
        f"{module}:{line} imports numba: decorate with `pilotage.core.jit.kernel`, which caches "
        "and is typed"
        for module in product_modules()
        for line, library in module.libraries()
        if library == "numba" and module.name != "pilotage.core.jit"
    )


def test_the_top_level_holds_what_it_should() -> None:
    allowed = {"pyproject.toml", "README.md", "LICENSE", "schemas", "services", "deploy", "tests"}
    top = {path.relative_to(REPOSITORY).parts[0] for path in written_files()}
    teach(
        f"{name} at the top level: find it a folder"
        for name in sorted(top - allowed)
        if not name.startswith(".")
    )
