"""Which of the modules and files that PyInstaller finds go into the bundle; used by dps-s.spec."""

import re
from collections.abc import Iterable
from pathlib import Path, PurePosixPath
from typing import Final, NamedTuple

LATE_MODULES: Final = (
    "_cffi_backend",  # imported by cryptography's compiled part
    # imported by pyqtgraph under names that it puts together
    "PySide6.QtOpenGL",
    "PySide6.QtOpenGLWidgets",
    "PySide6.QtSvg",
    "mcap.reader",
    "mcap.writer",
)
"""Needed, but not named by any import statement that PyInstaller can see."""

LEFT_OUT_MODULES: Final = (
    # for Pythons other than CPython; of cffi only the compiled part is needed
    "cffi",
    "zstandard._cffi",
    "zstandard.backend_cffi",
    "zstandard.backend_rust",
    "PySide6.QtDBus",
    "PySide6.QtNetwork",
    "PySide6.QtPrintSupport",
    "PySide6.QtTest",
    "PySide6.QtUiTools",
    # compiling and testing with numpy
    "numpy.distutils",
    "numpy.f2py",
    "numpy.testing.tests",
    # parts of pyqtgraph that its plots do without
    "pyqtgraph.console",
    "pyqtgraph.examples",
    "pyqtgraph.flowchart",
    "pyqtgraph.jupyter",
    "pyqtgraph.opengl",
    # development tools that hooks would include
    "construct",
    "hypothesis",
    "pip",
    "pytest",
    "serial.urlhandler.protocol_cp2110",  # needs a library that is not here
    "readline",  # for an interactive Python; under the GPL
    "setuptools",
    "tkinter",
)

_PLUGINS: Final = frozenset(
    {
        "iconengines/qsvgicon",
        "imageformats/qico",
        "imageformats/qsvg",
        "platforminputcontexts/composeplatforminputcontextplugin",
        "platforminputcontexts/ibusplatforminputcontextplugin",
        "platforms/qcocoa",
        "platforms/qminimal",
        "platforms/qoffscreen",
        "platforms/qwayland",
        "platforms/qwindows",
        "platforms/qxcb",
        "platformthemes/qgtk3",
        "platformthemes/qxdgdesktopportal",
    }
)
_WHOLE_PLUGIN_FOLDERS: Final = (
    "styles/",
    "wayland-decoration-client/",
    "wayland-graphics-integration-client/",
    "wayland-shell-integration/",
    "xcbglintegrations/",
)
_QT_LIBRARIES_OUT: Final = re.compile(r"(?:lib)?Qt6?(?:EglF|Network)|opengl32sw")
_TRANSLATIONS: Final = ("qtbase_zh_CN.qm",)


class Entry(NamedTuple):
    """One file in PyInstaller's list: place in the bundle, source, and kind (BINARY, DATA, PYMODULE ...)."""

    place: str
    source: str
    kind: str


def is_wanted(place: str) -> bool:
    path = PurePosixPath(place.replace("\\", "/"))
    text = path.as_posix()
    _, is_plugin, plugin = text.partition("/plugins/")
    if "PySide6/" in text and is_plugin:
        name = re.sub(r"^lib|\.(so|dll|dylib)$", "", path.name)
        is_known = f"{PurePosixPath(plugin).parent.as_posix()}/{name}" in _PLUGINS
        return is_known or plugin.startswith(_WHOLE_PLUGIN_FOLDERS)
    if "PySide6/" in text and "/translations/" in text:
        return path.name in _TRANSLATIONS
    folder = path.parent.name
    if ".egg-info" in text or ".dist-info" in text:  # only the version is needed
        return folder.endswith(".dist-info") and path.name == "METADATA"
    if path.parts[0] == "pyqtgraph":  # its icons and colour maps, which have licences of their own
        return False
    return not _QT_LIBRARIES_OUT.match(path.name)


def is_from_the_system(source: str) -> bool:
    """Whether this is a library of the Linux distribution that only Qt needs.

    Such libraries must match the desktop, so they are not bundled: the .deb depends on them, and the program names
    missing ones.
    """
    path = Path(source)
    return path.parts[:2] in (("/", "lib"), ("/", "usr"), ("/", "lib64")) and not _PYTHONS.match(path.name)


_PYTHONS: Final = re.compile(
    r"lib(?:python3|ssl|crypto|ffi|sqlite3|bz2|lzma|expat|uuid|mpdec|readline|tinfo|ncursesw|panelw|gdbm|db-5|z)\b.*\.so"
    r"|.*\.cpython-.*\.so"
)
"""Libraries of Python's own modules, which differ between distributions, are bundled."""


def without_unneeded(entries: Iterable[Entry], *, is_linux: bool) -> list[Entry]:
    """The entries that go into the bundle, sorted by place."""
    kept = {
        entry.place: entry
        for entry in entries
        if is_wanted(entry.place) and not (is_linux and entry.kind == "BINARY" and is_from_the_system(entry.source))
    }
    if is_linux:  # links to libraries that were left out
        targets = {PurePosixPath(place) for place in kept}
        kept = {
            place: entry
            for place, entry in kept.items()
            if entry.kind != "SYMLINK" or (PurePosixPath(place).parent / entry.source) in targets
        }
    return [kept[place] for place in sorted(kept)]
