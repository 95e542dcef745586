"""Rules of the house that every module keeps, read from the source itself."""

from __future__ import annotations

import ast
import graphlib
import tomllib
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

import acalx

ROOT = Path(acalx.__file__).parent
MODULES = sorted(ROOT.rglob("*.py"))
LOOSE = 12

# What says something to a person, and must decide nothing.
SAYINGS = {"message", "method", "reason", "label"}
# Methods of texts by which a decision could read one.
READS = {"startswith", "endswith", "find", "index", "count", "match", "search", "fullmatch"}

each_module = pytest.mark.parametrize("path", MODULES, ids=lambda path: str(path.relative_to(ROOT)))


@cache
def tree_of(path: Path) -> ast.Module:
    return ast.parse(path.read_text())


def functions(tree: ast.AST) -> Iterator[ast.FunctionDef | ast.AsyncFunctionDef]:
    return (node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef))


@each_module
def test_no_module_is_longer_than_300_lines(path: Path) -> None:
    assert len(path.read_text().splitlines()) <= 300


@each_module
def test_no_function_is_longer_than_60_lines(path: Path) -> None:
    lengths = {f.name: (f.end_lineno or 0) - f.lineno + 1 for f in functions(tree_of(path))}
    assert {name: length for name, length in lengths.items() if length > 60} == {}


def test_hardly_anything_is_loose() -> None:
    assert len(list(ROOT.glob("*.py"))) <= LOOSE


def public(tree: ast.AST) -> Iterator[tuple[str, str]]:
    """Names and docstrings of a module and its public classes, functions and methods."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef) and not node.name.startswith("_"):
            text = ast.get_docstring(node)
            if text is not None:
                yield node.name, text
            if isinstance(node, ast.ClassDef):
                yield from ((f"{node.name}.{name}", text) for name, text in public(node))


@each_module
def test_every_public_docstring_says_something(path: Path) -> None:
    assert [(name, text) for name, text in public(tree_of(path)) if len(text.split()) <= 3] == []


# ---------------------------------------------------------------- decisions on values


def names_of_errors(tree: ast.AST) -> set[str]:
    """Names that exceptions are caught under."""
    return {node.name for node in ast.walk(tree) if isinstance(node, ast.ExceptHandler) and node.name}


def says(node: ast.AST, errors: set[str]) -> bool:
    """Whether an expression is text meant for a person: a message, the text of an error, the name of a class."""
    if isinstance(node, ast.Attribute):
        return node.attr in SAYINGS or (node.attr == "__name__" and _is_type(node.value))
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "str" and node.args:
        given = node.args[0]
        return isinstance(given, ast.Name) and given.id in errors
    return False


def _is_type(node: ast.AST) -> bool:
    if isinstance(node, ast.Attribute):
        return node.attr == "__class__"
    return isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "type"


def decisions(tree: ast.AST) -> Iterator[tuple[int, str]]:
    """Lines where something is decided by a text meant for a person, or by a name that stands for one."""
    errors = names_of_errors(tree)
    told = {
        target.id
        for node in ast.walk(tree)
        if isinstance(node, ast.Assign) and says(node.value, errors)
        for target in node.targets
        if isinstance(target, ast.Name)
    }
    for node in ast.walk(tree):
        read: list[ast.expr] = []
        if isinstance(node, ast.Compare):
            read = [node.left, *node.comparators]
        elif isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr in READS:
            read = [node.func.value, *node.args]
        elif isinstance(node, ast.Match):
            read = [node.subject]
        for part in read:
            if says(part, errors) or (isinstance(part, ast.Name) and part.id in told):
                yield part.lineno, ast.unparse(node)


@pytest.mark.parametrize(
    ("source", "found"),
    [
        ("try:\n    go()\nexcept ValueError as error:\n    if 'few' in str(error):\n        pass", True),
        ("try:\n    go()\nexcept ValueError as error:\n    hint = f'{error}' if verbose else ''", False),
        ("try:\n    go()\nexcept ValueError as error:\n    text = str(error)\nfew = 'few' in text", True),
        ("if result.message == 'done':\n    pass", True),
        ("good = bound.method.startswith('relaxation')", True),
        ("if type(x).__name__ == 'D':\n    pass", True),
        ("if x.__class__.__name__ in names:\n    pass", True),
        ("if text == str(3):\n    pass", False),
        ("if isinstance(x, D) and result.status == 'ok':\n    print(result.message)", False),
        ("found = re.search('few', error.message)", True),
        ("match bound.method:\n    case 'floor':\n        pass", True),
    ],
)
def test_decisions_on_texts_are_seen(source: str, found: bool) -> None:
    assert bool(list(decisions(ast.parse(source)))) == found


@each_module
def test_no_decision_reads_what_is_said(path: Path) -> None:
    assert list(decisions(tree_of(path))) == []


# ---------------------------------------------------------------- what a part costs


def code_lines(node: ast.ClassDef, source: list[str]) -> int:
    """Lines of a class in a file without docstrings, blank lines, decorators and imports."""
    left = set(range(node.lineno, (node.end_lineno or 0) + 1))
    for inner in ast.walk(node):
        docstring = isinstance(inner, ast.Expr) and isinstance(inner.value, ast.Constant)
        if docstring or isinstance(inner, ast.Import | ast.ImportFrom):
            left -= set(range(inner.lineno, (inner.end_lineno or 0) + 1))
        if isinstance(inner, ast.FunctionDef):
            left -= {decorator.lineno for decorator in inner.decorator_list}
    return sum(bool(source[line - 1].strip()) for line in left)


def test_a_criterion_costs_a_few_lines() -> None:
    path = ROOT / "criteria" / "alphabetic.py"
    criterion = next(node for node in tree_of(path).body if isinstance(node, ast.ClassDef) and node.name == "D")
    assert code_lines(criterion, path.read_text().splitlines()) <= 14


@pytest.mark.parametrize("name", ["run", "evaluate", "simulate", "calibrate", "validate"])
def test_entry_points_are_a_screen_or_two(name: str) -> None:
    assert len((ROOT / "commands" / f"{name}.py").read_text().splitlines()) < 120


def imported(path: Path) -> set[str]:
    """Modules of acalx that a file imports, anywhere in it, those for types alone too."""
    names: set[str] = set()
    for node in ast.walk(tree_of(path)):
        if isinstance(node, ast.ImportFrom) and node.module and node.module.split(".")[0] == "acalx":
            names |= {node.module, *(f"{node.module}.{alias.name}" for alias in node.names)}
    return names


def test_no_modules_import_each_other_in_a_circle() -> None:
    modules = {".".join(("acalx", *path.relative_to(ROOT).with_suffix("").parts)): path for path in MODULES}
    graph = {name: imported(path) & set(modules) - {name} for name, path in modules.items()}
    graphlib.TopologicalSorter(graph).prepare()  # raises CycleError with the circle
    assert sum(map(len, graph.values())) > 500


def test_every_room_is_installed() -> None:
    """An editable installation would hide a package that is not listed."""
    root = Path(__file__).parents[1]
    listed = set(tomllib.loads((root / "pyproject.toml").read_text())["tool"]["setuptools"]["packages"])
    rooms = {".".join(("acalx", *path.parent.relative_to(ROOT).parts)) for path in ROOT.rglob("__init__.py")}
    assert listed == rooms | {"acalx.conf", "hydra_plugins"}


# Who may know a package that is not ours; each only there where it is used, and imported when it is.
MAY_KNOW = {
    "hydra": {"commands"},
    "matplotlib": {"reporting"},
    "cvxpy": {"criteria", "weights"},
    "pymoo": {"optimizers"},
}


@pytest.mark.parametrize("package", MAY_KNOW)
def test_no_room_escapes_the_contracts(package: str) -> None:
    """import-linter asks of modules that are listed: all but those that may know it, and the starting points."""
    configured = tomllib.loads((Path(__file__).parents[1] / "pyproject.toml").read_text())["tool"]["importlinter"]
    (contract,) = (c for c in configured["contracts"] if package in c.get("forbidden_modules", ()))
    shims = {"__init__", "__main__", "run", "evaluate", "simulate", "calibrate", "validate"}
    rooms = {path.parent.name for path in ROOT.glob("*/__init__.py")} | {path.stem for path in ROOT.glob("*.py")}
    assert {name.removeprefix("acalx.") for name in contract["source_modules"]} == rooms - shims - MAY_KNOW[package]
