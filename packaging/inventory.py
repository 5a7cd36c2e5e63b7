"""The third-party parts of a bundle that PyInstaller collected, each with version, licence and licence text."""

import platform
import sys
import sysconfig
from collections.abc import Iterable
from importlib import metadata
from pathlib import Path, PurePosixPath
from typing import Final

from bundle_contents import Entry
from enclosed_parts import enclosed_parts
from environment import ROOT, SetupError, run
from packaging.utils import canonicalize_name
from parts import LICENCE_FOLDER, Part, texts_of

_LGPL: Final = ("LGPL-3.0.txt", "GPL-3.0.txt")
_QT_TEXTS: Final = ("Qt.txt", *_LGPL)
LICENCES: Final = {
    "colorama": "BSD-3-Clause",
    "lz4": "BSD-3-Clause",
    "mcap": "MIT",
    "numpy": "BSD-3-Clause AND 0BSD AND MIT AND Zlib AND CC0-1.0",  # the version for Windows, which is an older one
    "pyinstaller": "GPL-2.0-or-later WITH Bootloader-exception",
    "pyinstaller-hooks-contrib": "Apache-2.0",
    "pyqtgraph": "MIT",
    "pyserial": "BSD-3-Clause",
    "pyside6-essentials": "LGPL-3.0-only",
    "segno": "BSD-3-Clause",
    "shiboken6": "LGPL-3.0-only",
    "shtab": "MPL-2.0",
    "tzdata": "Apache-2.0",
}
"""SPDX expressions of distributions that state none."""
_PYSIDE: Final = "pyside6-essentials"
TEXTS: Final = {
    "mcap": ("mcap.txt",),
    "psycopg": _LGPL,
    "psycopg-binary": _LGPL,
    "pyserial": ("pyserial.txt",),
    "pyside6-essentials": _QT_TEXTS,
    "shiboken6": _QT_TEXTS,
}
"""Our copies, for distributions without a text, or without all of it: the LGPL refers to the GPL."""
OF_THE_SYSTEM: Final = {
    "libbz2": "bzip2-1.0.6",
    "libexpat": "MIT",
    "libffi": "MIT",
    "liblzma": "LicenseRef-Public-Domain",
    "libmpdec": "BSD-2-Clause",
    "libncursesw": "X11-distribute-modifications-variant",
    "libsqlite": "blessing",
    "libssl": "Apache-2.0",
    "libtinfo": "X11-distribute-modifications-variant",
    "libuuid": "BSD-3-Clause",
    "zlib": "Zlib",
}
"""SPDX expressions of Debian's packages, by the beginning of their names."""


def parts(collected: Iterable[Entry], own: Path) -> list[Part]:
    """All parts of the bundle except the program, whose files lie below `own` or in this checkout.

    Raises SetupError if the licence text of a part is missing.
    """
    entries = [entry for entry in collected if entry.kind != "SYMLINK"]
    owned, python, rest = _owners(entries, own)
    of_pyside = owned.pop(_PYSIDE, [])
    owned[_PYSIDE] = [entry for entry in of_pyside if not _is_of_qt(entry)]
    bundled = [_from_distribution(metadata.distribution(name), files) for name, files in owned.items()]
    bundled += [_python(python), _qt([entry for entry in of_pyside if _is_of_qt(entry)])]
    if sys.platform.startswith("linux"):
        bundled += _system_parts(rest)
    bundled += enclosed_parts(entries)
    for part in bundled:
        if not part.texts:
            raise SetupError(f"The licence text of {part.name} is not found; put it into {LICENCE_FOLDER}.")
    return sorted(bundled, key=lambda part: (part.name.lower(), part.version or ""))


def _owners(entries: Iterable[Entry], own: Path) -> tuple[dict[str, list[Entry]], list[Entry], list[Entry]]:
    """Files by distribution, those of Python, and those of neither of them nor the program."""
    site = Path(sysconfig.get_path("purelib"))
    owner: dict[str, str] = {}
    for distribution in metadata.distributions(path=[str(site)]):
        name = canonicalize_name(distribution.name)
        for file in distribution.files or ():
            owner[str(site / file)] = name
    libraries = [Path(sys.base_prefix), Path(sysconfig.get_path("stdlib"))]
    owned: dict[str, list[Entry]] = {}
    python, rest = [], []
    for entry in entries:
        path = Path(entry.source)
        if entry.source in owner:
            owned.setdefault(owner[entry.source], []).append(entry)
        elif _is_python(path, libraries):
            python.append(entry)
        elif not any(path.is_relative_to(folder) for folder in (own, ROOT)):
            rest.append(entry)
    return owned, python, rest


def _is_python(path: Path, libraries: list[Path]) -> bool:
    # A system's own Python has /usr as its prefix, where everything else lies too.
    roots = libraries[1:] if libraries[0] == Path("/usr") else libraries
    own = ("libpython3", "base_library.zip")  # the latter is a part of the standard library
    return not path.is_absolute() or any(path.is_relative_to(root) for root in roots) or path.name.startswith(own)


def _from_distribution(distribution: metadata.Distribution, files: Iterable[Entry]) -> Part:
    name = canonicalize_name(distribution.name)
    licence = next(iter(distribution.metadata.get_all("License-Expression") or ()), None) or LICENCES.get(name)
    if licence is None:
        raise SetupError(f"{distribution.name} states no licence; look at its text and name it in inventory.py.")
    return Part(
        name=distribution.name,
        version=distribution.version,
        purl=f"pkg:pypi/{name}@{distribution.version}",
        licence=licence,
        texts=tuple(LICENCE_FOLDER / text for text in TEXTS[name]) if name in TEXTS else texts_of(distribution),
        files=tuple(files),
    )


def _python(files: Iterable[Entry]) -> Part:
    places = (
        Path(sysconfig.get_path("stdlib")) / "LICENSE.txt",
        Path(sys.base_prefix) / "LICENSE.txt",
        Path(f"/usr/share/doc/python{sys.version_info.major}.{sys.version_info.minor}/copyright"),
    )
    version = platform.python_version()
    return Part(
        name="CPython",
        version=version,
        purl=f"pkg:generic/cpython@{version}",
        licence="Python-2.0.1",
        texts=tuple(place for place in places if place.exists())[:1],
        files=tuple(files),
    )


def _qt(files: Iterable[Entry]) -> Part:
    from PySide6.QtCore import qVersion

    return Part(
        name="Qt",
        version=qVersion(),
        purl=f"pkg:generic/qt@{qVersion()}",
        licence="LGPL-3.0-only",
        texts=tuple(LICENCE_FOLDER / text for text in _QT_TEXTS),
        files=tuple(files),
    )


def _is_of_qt(entry: Entry) -> bool:
    """Whether it belongs to Qt, whose files lie in the folders of PySide6."""
    path = PurePosixPath(entry.place)
    return bool({"Qt", "plugins", "translations"} & {*path.parts}) or path.name.startswith(("Qt6", "QtLibs"))


def _system_parts(entries: Iterable[Entry]) -> Iterable[Part]:
    """Libraries of the system that Python needs, by their Debian packages."""
    packages: dict[str, list[Entry]] = {}
    for entry in entries:
        real = Path(entry.source).resolve()  # Debian lists some files below /lib, which is a link to /usr/lib
        listed = run(["dpkg-query", "--search", f"*/{real.parent.name}/{real.name}"],
                     f"{real} is in the bundle, and belongs to no package whose licence is known")  # fmt: skip
        packages.setdefault(listed.partition(":")[0], []).append(entry)
    for package, files in packages.items():
        version = run(["dpkg-query", "--show", "--showformat=${Version}\n", package], "dpkg-query failed").split()[0]
        licence = next((expression for start, expression in OF_THE_SYSTEM.items() if package.startswith(start)), None)
        if licence is None:
            raise SetupError(f"The licence of Debian's {package} is not named in inventory.py.")
        text = Path("/usr/share/doc") / package / "copyright"
        yield Part(
            name=package,
            version=version,
            purl=f"pkg:deb/debian/{package}@{version.replace('+', '%2B').replace(':', '%3A')}",
            licence=licence,
            texts=(text.resolve(),) if text.exists() else (),
            files=tuple(files),
        )
