"""Checks the imports between layers and rooms."""

import ast
import re
import sys
from collections.abc import Iterable, Iterator
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path
from typing import NamedTuple

import pytest

ROOT = Path(__file__).parent.parent
PACKAGES = ("protocol", "app", "ui")
IMPURE = {"threading", "_thread", "time", "asyncio", "concurrent", "multiprocessing", "signal"}
QT = {"PySide6", "shiboken6", "pyqtgraph"}
ROOMS = (
    "protocol",
    "app",  # its version, nothing else
    "app/text",
    "app/system",
    "app/engine",
    "app/safety",
    "app/store",
    "app/procedures",
    "app/guided",
    "app/settings",
    "app/modules",
    "app/limits",
    "app/trigger_records",
    "app/samples",
    "app/captures",
    "app/diagnosis",
    "app/preflight",
    "app/records",
    "app/archive",
    "app/fleet",
    "app/recordings",
    "app/flights",
    "app/simulator",
    "app/port_urls",
    "app/sharing.py",
    "app/terminal",
    "app/integration.py",  # the door for programs of others
    "app/cli",
    "app/__main__.py",  # puts the command line together, and opens the window
    "ui",
    "ui/style",
    "ui/core",
    "ui/widgets",
    "ui/forms",
    "ui/services",
    "ui/session",
    "ui/services/page.py",  # knows the module that is shown
    "ui/services/context.py",
    "ui/files",
    "ui/plots",
    "ui/acts",
    "ui/preferences",
    "ui/connect",
    "ui/simulator",
    "ui/pages",
    "ui/pages/live",
    "ui/pages/settings",
    "ui/pages/triggers",
    "ui/pages/preflight",
    "ui/pages/commands",
    "ui/pages/fleet",
    "ui/pages/logs",
    "ui/pages/diagnosis",
    "ui/help",
    "ui/shell",
    "ui/main.py",  # puts the window together
)
"""Lowest first: a file imports from its own room and from those before it. Pages never import each other."""


class Import(NamedTuple):
    """One imported module, where, and whether it is inside a function or for types only."""

    module: str
    line: int
    is_in_function: bool

    @property
    def package(self) -> str:
        return self.module.partition(".")[0]


@cache
def imports(source: str) -> tuple[Import, ...]:
    """Return all imports of a source text, including `import_module("...")` and `__import__("...")`."""
    passed_over = () if "import_module" in source or "__import__" in source else ast.expr
    return tuple(_imports(ast.parse(source), passed_over, is_in_function=False))


def _imports(node: ast.AST, passed_over: type | tuple[()], *, is_in_function: bool) -> Iterator[Import]:
    for child in ast.iter_child_nodes(node):
        if not isinstance(child, passed_over):
            for name in _imported_names(child):
                yield Import(name, getattr(child, "lineno", 0), is_in_function)
            is_function = isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda)
            is_later = is_in_function or is_function or _is_for_types(child)
            yield from _imports(child, passed_over, is_in_function=is_later)


def _is_for_types(node: ast.AST) -> bool:
    return isinstance(node, ast.If) and isinstance(node.test, ast.Name) and node.test.id == "TYPE_CHECKING"


def _imported_names(node: ast.AST) -> list[str]:
    match node:
        case ast.Import(names=names):
            return [alias.name for alias in names]
        case ast.ImportFrom(module=str(module), names=names, level=0):
            return [f"{module}.{alias.name}" for alias in names]
        case ast.Call(
            func=ast.Name(id="__import__" | "import_module") | ast.Attribute(attr="import_module"),
            args=[ast.Constant(value=str(name)), *_],
        ):
            return [name]
    return []


@cache
def room_of(path: str) -> str | None:
    """Return the room of a file or of an imported name (with slashes for dots), or None."""
    fitting = [room for room in ROOMS if path == room or path.startswith((f"{room}/", f"{room.removesuffix('.py')}/"))]
    plain = [room for room in ROOMS if room.endswith(".py") and path == room.removesuffix(".py")]
    return max(plain or fitting, key=len, default=None)


def faults(path: str, source: str) -> list[str]:
    """Return the forbidden imports of a file; `path` is relative to the root."""
    return [f"{path}:{one.line}: {why}" for one in imports(source) if (why := _why_forbidden(path, one))]


def _why_forbidden(path: str, one: Import) -> str | None:
    package, imported = path.partition("/")[0], one.package
    if imported == "tests":
        return "nothing imports the tests"
    if package == "protocol":
        if imported in IMPURE:
            return f"protocol/ has no clock or thread: {imported}"
        if imported != "protocol" and imported not in sys.stdlib_module_names:
            return f"protocol/ imports the standard library and itself only: {imported}"
    if package == "app":
        if imported in QT:
            return f"app/ is free of Qt: {imported}"
        if imported == "ui" and path == "app/__main__.py" and one.is_in_function:
            return None
        if imported == "ui":
            return "ui/ is imported by app/__main__.py only, inside a function"
    if package == "ui" and imported == "serial":
        return "ui/ has no port: serial"
    return _why_upward(path, one.module.replace(".", "/")) if imported in PACKAGES else None


def _why_upward(path: str, imported: str) -> str | None:
    here, there = room_of(path), room_of(imported)
    if here is None or there is None:
        return f"in no room: {path if here is None else imported}"
    if ROOMS.index(there) > ROOMS.index(here):
        return f"{here} is below {there}"
    is_page = here.startswith("ui/pages/") and there.startswith("ui/pages/")
    return f"pages never import each other: {there}" if is_page and here != there else None


def sources(packages: Iterable[str] = PACKAGES) -> list[Path]:
    """Return every Python file of the packages."""
    return sorted(path for package in packages for path in (ROOT / package).rglob("*.py"))


def test_every_file_keeps_to_its_layer_and_its_room() -> None:
    paths = sources()
    assert {path.relative_to(ROOT).parts[0] for path in paths} == set(PACKAGES)
    found = [
        fault for path in paths for fault in faults(path.relative_to(ROOT).as_posix(), path.read_text(encoding="utf-8"))
    ]
    assert not found, "\n".join(found)


def test_every_room_is_there_and_says_in_a_line_what_it_is_for() -> None:
    for room in ROOMS:
        assert (ROOT / room).exists(), room
        if not room.endswith(".py"):
            docstring = ast.get_docstring(ast.parse((ROOT / room / "__init__.py").read_text(encoding="utf-8")))
            assert docstring, room
            assert "\n" not in docstring, room


def circle(imported: dict[str, set[str]]) -> list[str]:
    """Return files that import each other in a circle, or an empty list."""
    try:
        TopologicalSorter(imported).prepare()
    except CycleError as error:
        return list(error.args[1])
    return []


def test_no_files_import_each_other() -> None:
    imported = {}
    for path in sources():
        name = ".".join(path.relative_to(ROOT).with_suffix("").parts)
        names = {one.module for one in imports(path.read_text(encoding="utf-8")) if not one.is_in_function}
        imported[name] = names | {name.rpartition(".")[0] for name in names}
    assert circle({name: names & imported.keys() - {name} for name, names in imported.items()}) == []


def test_no_class_name_means_two_things() -> None:
    """Below the window. `Serial` is what pyserial looks for in a module that handles a scheme of URLs."""
    named: dict[str, list[str]] = {}
    for path in sources(("protocol", "app")):
        for name in re.findall(r"^ *class (\w+)", path.read_text(encoding="utf-8"), re.MULTILINE):
            named.setdefault(name, []).append(path.relative_to(ROOT).as_posix())
    twice = {name: places for name, places in named.items() if len(places) > 1}
    assert twice == {}


def test_packaging_is_no_package() -> None:
    """A package of that name would hide PyPI's `packaging`, which pip, pytest and setuptools need."""
    assert (ROOT / "packaging").is_dir()
    assert not (ROOT / "packaging" / "__init__.py").exists()


@pytest.mark.parametrize(
    ("path", "source"),
    [
        ("protocol/messages.py", "import numpy"),
        ("protocol/messages.py", "from app.text import i18n"),
        ("protocol/link.py", "def now():\n    from time import monotonic\n    return monotonic()"),
        ("protocol/link.py", "from importlib import import_module\nclock = import_module('time')"),
        ("app/engine/conversation.py", "from PySide6.QtCore import QObject"),
        ("app/engine/conversation.py", "def show():\n    import ui.main"),
        ("app/engine/conversation.py", "from app.safety.permit import Permit"),
        ("app/__main__.py", "import ui.main"),
        ("ui/core/bridge.py", "import serial"),
        ("ui/core/bridge.py", "from ui.shell.main_window import MainWindow"),
        ("ui/pages/live/page.py", "from ui.pages.settings.rows import SettingsRow"),
    ],
)
def test_a_forbidden_import_is_found(path: str, source: str) -> None:
    assert len(faults(path, source)) == 1


def test_the_map_in_the_documents_is_the_tree() -> None:
    page = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    table = page.partition("| room | purpose |\n| --- | --- |\n")[2].partition("\n\n")[0]
    rows = [re.match(r"\| `(.+?)` \| (.+) \|$", line) for line in table.splitlines()]
    files = [(room, ROOT / room if room.endswith(".py") else ROOT / room / "__init__.py") for room in ROOMS]
    purposes = [(ast.get_docstring(ast.parse(file.read_text(encoding="utf-8"))) or "") for _, file in files]
    said = [row.groups() for row in rows if row is not None]
    assert said == [(room, purpose.splitlines()[0]) for (room, _), purpose in zip(files, purposes, strict=True)]
    named = set(re.findall(r"`((?:app|ui|protocol|tests|docs)/[\w/]+\.(?:py|md))`", page))
    assert named
    assert [name for name in sorted(named) if not (ROOT / name).exists()] == []
