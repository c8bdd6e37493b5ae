"""How big things may be: small enough to be read at one sitting."""

import ast
import statistics
from pathlib import Path

from architecture.source_tree import product_modules, teach, written_files

MODULE_LIMIT = 400
FUNCTION_LIMIT = 60
PARAMETER_LIMIT = 5
FUNCTION_MEDIAN = 12


def length(node: ast.FunctionDef | ast.AsyncFunctionDef) -> int:
    """Lines of a function without its docstring."""
    first = node.body[1 if ast.get_docstring(node) and len(node.body) > 1 else 0]
    return (node.end_lineno or 0) - first.lineno + 1


def parameters(node: ast.FunctionDef | ast.AsyncFunctionDef) -> int:
    arguments = node.args
    names = [a.arg for a in (*arguments.posonlyargs, *arguments.args, *arguments.kwonlyargs)]
    return len([name for name in names if name not in ("self", "cls")])


def is_kernel_or_command(node: ast.FunctionDef | ast.AsyncFunctionDef) -> bool:
    """Compiled functions take plain arrays and numbers, commands one parameter per option."""
    decorators = " ".join(ast.unparse(decorator) for decorator in node.decorator_list)
    return "kernel" in decorators or "command" in decorators


def test_no_module_is_longer_than_400_lines() -> None:
    teach(
        f"{module}: {count} lines. Think at 200, stop at {MODULE_LIMIT}: one concept per file, "
        "named by a noun of the field"
        for module in product_modules()
        if (count := len(module.text.splitlines())) > MODULE_LIMIT
    )


def test_no_function_is_longer_than_60_lines() -> None:
    teach(
        f"{module}:{node.lineno} {node.name}: {length(node)} lines. About 8 is usual, 30 is long, "
        f"{FUNCTION_LIMIT} the end: give its steps names"
        for module in product_modules()
        for node in module.functions()
        if length(node) > FUNCTION_LIMIT
    )


def test_no_function_takes_more_than_5_parameters() -> None:
    teach(
        f"{module}:{node.lineno} {node.name} takes {parameters(node)} parameters: pass a frozen "
        "dataclass (a GridGeometry, not six numbers)"
        for module in product_modules()
        for node in module.functions()
        if parameters(node) > PARAMETER_LIMIT and not is_kernel_or_command(node)
    )


def test_functions_are_short_on_the_whole() -> None:
    lengths = [length(node) for module in product_modules() for node in module.functions()]
    assert statistics.median(lengths) <= FUNCTION_MEDIAN


def test_tests_are_about_as_long_as_the_code() -> None:
    tested = [path for path in written_files() if path.suffix == ".py" and "tests" in path.parts]
    code = sum(line_count(module.path) for module in product_modules())
    assert sum(map(line_count, tested)) >= 0.9 * code, "tests first, or at the latest now"


def line_count(path: Path) -> int:
    return len(path.read_text(encoding="utf-8").splitlines())
