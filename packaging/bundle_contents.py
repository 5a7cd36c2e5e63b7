"""What goes into the bundle and what stays out: read by dps-s.spec, tried on every file that PyInstaller found."""

import re
from collections.abc import Iterable
from pathlib import Path, PurePosixPath
from typing import Final, NamedTuple

TOP_PACKAGES: Final = ("app", "protocol", "ui")
LATE_MODULES: Final = (
    "_cffi_backend",  # cryptography's compiled part imports it
    "PySide6.QtSvg",
    "mcap.reader",
    "mcap.writer",
    # the kinds of port that are given by a URL
    "serial.urlhandler.protocol_alt",
    "serial.urlhandler.protocol_hwgrep",
    "serial.urlhandler.protocol_loop",
    "serial.urlhandler.protocol_rfc2217",
    "serial.urlhandler.protocol_socket",
    "serial.urlhandler.protocol_spy",
)
"""Wanted although no import statement that PyInstaller can see names them."""

LEFT_OUT_MODULES: Final = (
    # what zstandard has for Pythons that are not CPython; of cffi only its compiled part is wanted
    "cffi",
    "zstandard._cffi",
    "zstandard.backend_cffi",
    "zstandard.backend_rust",
    "PySide6.QtDBus",
    "PySide6.QtNetwork",
    "PySide6.QtPrintSupport",
    "PySide6.QtTest",
    "PySide6.QtUiTools",
    # of numpy, what compiles and tests
    "numpy.distutils",
    "numpy.f2py",
    "numpy.testing.tests",
    # tools of the development that hooks would take along when they happen to be installed
    "IPython",
    "PIL",
    "construct",
    "hypothesis",
    "matplotlib",
    "pip",
    "pkg_resources",
    "pyqtgraph",
    "pytest",
    "readline",  # of an interactive Python; under the GPL
    "scipy",
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
_QT_MODULES_OUT: Final = re.compile(
    r"(?:lib)?Qt6?(?:Qml|Quick|Network|Pdf|Sql|Test|Lottie|VirtualKeyboard|EglFS|EglFs|WaylandCompositor|"
    r"PrintSupport|ShaderTools|Labs|Help|Designer|UiTools)\w*(?:\.|$)"
)
_TRANSLATIONS: Final = ("qtbase_zh_CN.qm",)
_SOFTWARE_OPENGL: Final = "opengl32sw.dll"


class Entry(NamedTuple):
    """One file as PyInstaller lists it: where in the bundle, from where, and its kind (BINARY, DATA, PYMODULE ...)."""

    place: str
    source: str
    kind: str


def is_wanted(place: str) -> bool:
    """Does a file that is to lie at this place in the bundle belong there?"""
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
    if ".egg-info" in text or ".dist-info" in text:  # of what is installed only the version is asked for
        return folder.endswith(".dist-info") and path.name == "METADATA"
    if "PySide6/Qt/qml/" in text or "PySide6/qml/" in text or path.name == _SOFTWARE_OPENGL:
        return False
    return not _QT_MODULES_OUT.match(path.name)


def is_from_the_system(source: str) -> bool:
    """Is this a library of a Linux distribution that only Qt asks for?

    Such libraries have to fit the desktop that they run on, so they stay the system's: the .deb depends on them, and
    the program names those that are missing before Qt does.
    """
    path = Path(source)
    return path.parts[:2] in (("/", "lib"), ("/", "usr"), ("/", "lib64")) and not _PYTHONS.match(path.name)


_PYTHONS: Final = re.compile(
    r"lib(?:python3|ssl|crypto|ffi|sqlite3|bz2|lzma|expat|uuid|mpdec|readline|tinfo|ncursesw|panelw|gdbm|db-5|z)\b.*\.so"
    r"|.*\.cpython-.*\.so"
)
"""What Python's own modules ask for, which differs between releases, comes along."""


def sifted(entries: Iterable[Entry], *, is_linux: bool) -> list[Entry]:
    """The entries that belong into the bundle, in the order of their places."""
    kept = {
        entry.place: entry
        for entry in entries
        if is_wanted(entry.place) and not (is_linux and entry.kind == "BINARY" and is_from_the_system(entry.source))
    }
    if is_linux:  # a link to a library that was left out would point nowhere
        targets = {PurePosixPath(place) for place in kept}
        kept = {
            place: entry
            for place, entry in kept.items()
            if entry.kind != "SYMLINK" or (PurePosixPath(place).parent / entry.source) in targets
        }
    return [kept[place] for place in sorted(kept)]


def module_names(site: Path) -> list[str]:
    """All modules of the program below `site`: sub-commands and pages are imported by name at run time."""
    names = []
    for top in TOP_PACKAGES:
        for path in sorted((site / top).rglob("*.py")):
            parts = path.relative_to(site).with_suffix("").parts
            names.append(".".join(parts[:-1] if parts[-1] == "__init__" else parts))
    return names


def data_files(site: Path) -> list[tuple[str, str]]:
    """What of the program is no module, with its folder in the bundle."""
    files = [path for top in TOP_PACKAGES for path in sorted((site / top).rglob("*")) if path.is_file()]
    return [
        (str(path), path.parent.relative_to(site).as_posix())
        for path in files
        if path.suffix not in (".py", ".pyc") and path.name != "py.typed"
    ]
