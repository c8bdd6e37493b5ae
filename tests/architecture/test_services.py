"""Every service has the same shape, and keeps to the registry and to the process table."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

from architecture.source_tree import (
    PILOTAGE,
    REPOSITORY,
    Module,
    product_modules,
    service_folders,
    teach,
)
from pilotage_schemas.topics import EVERYONE, QUERIES, TOPICS

FILES = ("__main__.py", "config.py", "service.py", "README.md")
HEADINGS = ["Does", "In", "Out", "Parameters", "Source"]
HEADING = re.compile(rf"^(?:#+ |\*\*)({'|'.join(HEADINGS)})\b", re.MULTILINE)
MAY_HEAR_THE_TRUTH = {"gateway", "recorder"}
CALLS = ("subscribe", "subscribe_samples", "publisher", "answer", "ask")


def named_on_the_bus(module: Module) -> Iterator[tuple[int, str, str]]:
    """Line, method and literal name of each call like `node.subscribe("scan", ...)`."""
    for node in ast.walk(module.tree):
        if (
            isinstance(node, ast.Call)
            and isinstance(node.func, ast.Attribute)
            and node.func.attr in CALLS
            and node.args
            and isinstance(node.args[0], ast.Constant)
            and isinstance(node.args[0].value, str)
        ):
            yield node.lineno, node.func.attr, node.args[0].value


def service_of(module: Module) -> str:
    return module.name.split(".")[1] if module.name.count(".") > 1 else ""


def test_every_service_has_the_same_three_files_and_a_readme() -> None:
    teach(
        f"{folder.relative_to(REPOSITORY)} lacks {name}: services all look the same, see "
        "services/README.md"
        for folder in service_folders()
        for name in FILES
        if not (folder / name).is_file()
    )


def headings(readme: Path) -> list[str]:
    """The house's headings in a README, written as `## Does` or as `**Does.**`."""
    return HEADING.findall(readme.read_text(encoding="utf-8"))


def test_every_services_readme_has_the_same_headings() -> None:
    teach(
        f"{readme.relative_to(REPOSITORY)}: the headings are {', '.join(HEADINGS)}, in this order; "
        f"it has {', '.join(headings(readme)) or 'none'}"
        for readme in (folder / "README.md" for folder in service_folders())
        if readme.is_file() and headings(readme) != HEADINGS
    )


def test_every_folder_of_the_tree_explains_itself(repository: Path) -> None:
    teach(
        f"{name}/README.md is missing: say what belongs there"
        for name in ("schemas", "services", "tests", "deploy")
        if not (repository / name / "README.md").is_file()
    )


def test_main_only_starts_the_service() -> None:
    teach(
        f"{path.relative_to(REPOSITORY)}: about ten lines; what a service does is in service.py"
        for path in (folder / "__main__.py" for folder in service_folders())
        if path.is_file() and len(path.read_text(encoding="utf-8").splitlines()) > 30
    )


def test_every_topic_and_query_in_the_code_is_registered() -> None:
    teach(
        f"{module}:{line}: '{name}' is not in schemas/pilotage_schemas/topics.py; add it there "
        "first"
        for module in product_modules()
        for line, method, name in named_on_the_bus(module)
        if name not in (QUERIES if method in ("answer", "ask") else TOPICS)
    )


def test_a_service_publishes_and_answers_only_what_it_owns() -> None:
    teach(
        f"{module}:{line}: {service_of(module)} does not own '{name}'"
        for module in product_modules()
        for line, method, name in named_on_the_bus(module)
        if service_of(module) not in ("", "bus")
        and (
            (
                method == "publisher"
                and not {service_of(module), EVERYONE} & set(TOPICS[name].publishers)
            )
            or (method == "answer" and QUERIES[name].service != service_of(module))
        )
    )


def test_no_service_that_estimates_hears_the_truth() -> None:
    teach(
        f"{module}:{line}: only {', '.join(sorted(MAY_HEAR_THE_TRUTH))} may listen to "
        "ground_truth; an estimator that knows the answer proves nothing"
        for module in product_modules()
        for line, method, name in named_on_the_bus(module)
        if name == "ground_truth"
        and method != "publisher"
        and service_of(module) not in MAY_HEAR_THE_TRUTH
    )


def test_every_service_folder_stands_in_the_process_table() -> None:
    table = PILOTAGE / "launcher" / "process_table.py"
    teach(
        f"{folder.name} is not in {table.relative_to(REPOSITORY)}: nobody would start it"
        for folder in service_folders()
        if folder.name != "launcher" and folder.name not in table.read_text(encoding="utf-8")
    )
