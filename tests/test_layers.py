"""Who may import whom, and how long a file may be.  The checks are shown to find what they look for."""

import ast
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import NamedTuple

import pytest

ROOT = Path(__file__).parent.parent
PACKAGES = ("protocol", "app", "ui")
LONGEST_FILE_LINES = 400
IMPURE = {"threading", "_thread", "time", "logging", "asyncio", "concurrent", "multiprocessing", "signal"}
QT = {"PySide6", "shiboken6", "pyqtgraph"}


class Import(NamedTuple):
    """One imported top-level module, where, and whether it is inside a function."""

    module: str
    line: int
    is_in_function: bool


def imports(source: str) -> Iterator[Import]:
    """All imports of a source text, ``import_module("...")`` and ``__import__("...")`` included."""
    yield from _imports(ast.parse(source), is_in_function=False)


def _imports(node: ast.AST, *, is_in_function: bool) -> Iterator[Import]:
    for child in ast.iter_child_nodes(node):
        for name in _imported_names(child):
            yield Import(name.partition(".")[0], getattr(child, "lineno", 0), is_in_function)
        is_function = isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda)
        yield from _imports(child, is_in_function=is_in_function or is_function)


def _imported_names(node: ast.AST) -> list[str]:
    match node:
        case ast.Import(names=names):
            return [alias.name for alias in names]
        case ast.ImportFrom(module=str(module), level=0):
            return [module]
        case ast.Call(
            func=ast.Name(id="__import__" | "import_module") | ast.Attribute(attr="import_module"),
            args=[ast.Constant(value=str(name)), *_],
        ):
            return [name]
    return []


def faults(path: str, source: str) -> list[str]:
    """What a file below the repository's root (``path`` with slashes) does against the layers."""
    package = path.partition("/")[0]
    found = [
        f"{path}:{one.line}: {why}"
        for one in imports(source)
        if (why := _why_forbidden(package, one, is_root=path == "app/__main__.py"))
    ]
    lines = len(source.splitlines())
    if lines > LONGEST_FILE_LINES:
        found.append(f"{path}: {lines} lines, {LONGEST_FILE_LINES} are the most")
    return found


def _why_forbidden(package: str, one: Import, *, is_root: bool) -> str | None:
    module = one.module
    if module == "tests":
        return "nothing imports the tests"
    if package == "protocol":
        if module in IMPURE:
            return f"protocol/ has no clock, thread or log: {module}"
        if module != "protocol" and module not in sys.stdlib_module_names:
            return f"protocol/ imports the standard library and itself only: {module}"
    if package == "app":
        if module in QT:
            return f"app/ is free of Qt: {module}"
        if module == "ui" and not (is_root and one.is_in_function):
            return "ui/ is imported by app/__main__.py only, inside a function"
    if package == "ui" and module == "serial":
        return "ui/ has no port: serial"
    return None


def sources(packages: Iterable[str] = PACKAGES) -> list[Path]:
    """Every Python file of the packages."""
    return sorted(path for package in packages for path in (ROOT / package).rglob("*.py"))


def test_every_file_keeps_to_its_layer() -> None:
    paths = sources()
    assert {path.relative_to(ROOT).parts[0] for path in paths} == set(PACKAGES)
    found = [
        fault for path in paths for fault in faults(path.relative_to(ROOT).as_posix(), path.read_text(encoding="utf-8"))
    ]
    assert not found, "\n".join(found)


def test_packaging_is_no_package() -> None:
    """A package of that name would hide PyPI's ``packaging``, which pip, pytest and setuptools need."""
    assert (ROOT / "packaging").is_dir()
    assert not (ROOT / "packaging" / "__init__.py").exists()


@pytest.mark.parametrize(
    ("path", "source"),
    [
        ("protocol/frame.py", "import numpy"),
        ("protocol/frame.py", "import serial.tools"),
        ("protocol/frame.py", "from app.text import i18n"),
        ("protocol/link.py", "def now():\n    from time import monotonic\n    return monotonic()"),
        ("protocol/link.py", "import threading"),
        ("protocol/link.py", "import struct, logging"),
        ("protocol/link.py", "import asyncio.queues"),
        ("protocol/link.py", "from importlib import import_module\nclock = import_module('time')"),
        ("app/engine/device.py", "from PySide6.QtCore import QObject"),
        ("app/engine/device.py", "if True:\n    import pyqtgraph as pg"),
        ("app/engine/device.py", "def show():\n    import ui.window"),
        ("app/__main__.py", "import ui.window"),
        ("app/__main__.py", "try:\n    from ui import window\nexcept ImportError:\n    pass"),
        ("app/__main__.py", "def main():\n    from PySide6 import QtCore"),
        ("ui/window.py", "import serial"),
        ("ui/pages/live.py", "from serial.tools import list_ports"),
        ("ui/pages/live.py", "import importlib\nimportlib.import_module('serial')"),
        ("app/simulator.py", "from tests.doubles import Clock"),
        ("app/long.py", "x = 1\n" * (LONGEST_FILE_LINES + 1)),
    ],
)
def test_a_forbidden_import_is_found(path: str, source: str) -> None:
    assert len(faults(path, source)) == 1


@pytest.mark.parametrize(
    ("path", "source"),
    [
        ("protocol/frame.py", "import struct\nfrom protocol.catalogue import COMMANDS\nfrom . import text"),
        ("app/engine/device.py", "import time, threading, numpy, serial\nfrom protocol import frame"),
        ("app/__main__.py", "def gui():\n    from ui.window import show\n    show()"),
        ("ui/window.py", "import PySide6.QtWidgets, pyqtgraph, time\nfrom app.text import i18n"),
        ("app/long.py", "x = 1\n" * LONGEST_FILE_LINES),
    ],
)
def test_an_allowed_import_is_left_alone(path: str, source: str) -> None:
    assert faults(path, source) == []
