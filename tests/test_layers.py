"""The imports keep to the layers and rooms of the table in docs/architecture.md, lowest first; pages never import each
other."""

import ast
import re
import sys
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path
from typing import NamedTuple

import pytest

ROOT = Path(__file__).parent.parent
ARCHITECTURE = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
TABLE = ARCHITECTURE.partition("| room | purpose |\n| --- | --- |\n")[2].partition("\n\n")[0]
ROOMS = re.findall(r"^\| `(.+?)` \|", TABLE, re.MULTILINE)
FILES = sorted(path for top in ("protocol", "app", "ui") for path in (ROOT / top).rglob("*.py"))
IMPURE = {"threading", "_thread", "time", "asyncio", "concurrent", "multiprocessing", "signal"}
QT = {"PySide6", "shiboken6", "pyqtgraph"}


class Import(NamedTuple):
    module: str
    line: int
    is_later: bool  # inside a function, or for types only


def imports(source: str) -> list[Import]:
    """All of a source text, including `import_module("...")` and `__import__("...")`."""
    found: list[Import] = []

    def walk(node: ast.AST, *, is_later: bool) -> None:
        for child in ast.iter_child_nodes(node):
            match child:
                case ast.Import(names=names):
                    modules = [alias.name for alias in names]
                case ast.ImportFrom(module=str(module), names=names, level=0):
                    modules = [f"{module}.{alias.name}" for alias in names]
                case ast.Call(
                    func=ast.Name(id="__import__" | "import_module") | ast.Attribute(attr="import_module"),
                    args=[ast.Constant(value=str(name)), *_],
                ):
                    modules = [name]
                case _:
                    modules = []
            found.extend(Import(module, getattr(child, "lineno", 0), is_later) for module in modules)
            is_for_types = isinstance(child, ast.If) and ast.unparse(child.test) == "TYPE_CHECKING"
            is_function = isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda)
            walk(child, is_later=is_later or is_function or is_for_types)

    walk(ast.parse(source), is_later=False)
    return found


@cache
def imports_of(path: Path) -> list[Import]:
    return imports(path.read_text(encoding="utf-8"))


def room_of(path: str) -> str:
    """Of a file, or of an imported name with slashes for dots; "" for none."""
    fitting = [room for room in ROOMS if f"{path}/".startswith((f"{room}/", f"{room.removesuffix('.py')}/"))]
    return max(fitting, key=len, default="")


def why_forbidden(path: str, one: Import) -> str:
    """`path` is relative to the root."""
    package, imported = path.partition("/")[0], one.module.partition(".")[0]
    if package == "protocol":
        is_own = imported == "protocol" or imported in sys.stdlib_module_names
        return (
            "" if is_own and imported not in IMPURE else f"protocol/ has no clock, thread or other package: {imported}"
        )
    if imported == "tests" or (package == "app" and imported in QT) or (package == "ui" and imported == "serial"):
        return f"{package}/ never imports {imported}"
    if package == "app" and imported == "ui":
        return "" if path == "app/__main__.py" and one.is_later else "ui/ is imported in a function of app/__main__.py"
    if imported not in ("protocol", "app", "ui"):
        return ""
    here, there = room_of(path.removesuffix(".py")), room_of(one.module.replace(".", "/"))
    if not here or not there or ROOMS.index(there) > ROOMS.index(here):
        return f"{here or path} is below {there or one.module}, or one of them is no room"
    is_page = here.startswith("ui/pages/") and there.startswith("ui/pages/")
    return f"pages never import each other: {there}" if is_page and here != there else ""


def test_every_file_keeps_to_its_layer_and_its_room() -> None:
    found = [
        f"{path.relative_to(ROOT)}:{one.line}: {why}"
        for path in FILES
        for one in imports_of(path)
        if (why := why_forbidden(path.relative_to(ROOT).as_posix(), one))
    ]
    assert not found, "\n".join(found)


def test_the_independent_module_and_the_vendors_table_know_nothing_of_the_product() -> None:
    files = [path for room in ("module", "vendor") for path in (ROOT / "tests" / room).glob("*.py")]
    known = [one.module for path in files if not path.name.startswith("test_") for one in imports_of(path)]
    assert [name for name in known if name.startswith(("protocol", "app", "ui", "tests.support"))] == []


def test_every_room_is_there() -> None:
    assert [room for room in ROOMS if not (ROOT / room).exists()] == []
    assert len(ROOMS) > 40


def test_no_files_import_each_other() -> None:
    names = {path: ".".join(path.relative_to(ROOT).with_suffix("").parts) for path in FILES}
    imported: dict[str, set[str]] = {}
    for path, name in names.items():
        modules = {one.module for one in imports_of(path) if not one.is_later}
        modules |= {module.rpartition(".")[0] for module in modules}
        imported[name] = (modules & set(names.values())) - {name}
    try:
        TopologicalSorter(imported).prepare()
    except CycleError as error:
        pytest.fail(" imports ".join(error.args[1]))
