"""Whose work is in a bundle: the parts that PyInstaller collected, each with version, licence and licence text."""

import platform
import subprocess
import sys
import sysconfig
from collections.abc import Iterable
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path
from typing import Final

from bundle_contents import Entry
from environment import ROOT, SetupError

LICENCE_FOLDER: Final = ROOT / "packaging" / "licences"
_QT_TEXTS: Final = ("Qt.txt", "LGPL-3.0.txt", "GPL-3.0.txt")
_LICENCES: Final = {
    "colorama": "BSD-3-Clause",
    "cryptography": "BSD-3-Clause",
    "lz4": "BSD-3-Clause",
    "mcap": "MIT",
    "pyinstaller": "GPL-2.0-or-later WITH Bootloader-exception",
    "pyinstaller-hooks-contrib": "Apache-2.0",
    "pyqtgraph": "MIT",
    "pyserial": "BSD-3-Clause",
    "pyside6-essentials": "LGPL-3.0-only",
    "shiboken6": "LGPL-3.0-only",
}
"""SPDX expressions of distributions that do not state one, or that leave a choice."""
_TEXTS: Final = {
    "mcap": ("mcap.txt",),
    "pyserial": ("pyserial.txt",),
    "pyside6-essentials": _QT_TEXTS,
    "shiboken6": _QT_TEXTS,
}
"""Our copies, for distributions that carry no text."""
_ALWAYS: Final = ("pyinstaller", "pyinstaller-hooks-contrib")
"""In the executable itself: the loader, and what it runs before the program."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Part:
    """One work of others. `licence` is an SPDX expression; None where only its `texts` tell."""

    name: str
    version: str
    purl: str | None
    licence: str | None
    texts: tuple[Path, ...]
    is_program_library: bool = True
    """Of Python's world; else of the operating system's."""


def parts(collected: Iterable[Entry], own: Path) -> list[Part]:
    """Everything in the bundle but the program itself, whose files lie below `own` or in this checkout.

    Raises SetupError where the licence text of a part is nowhere: it may not be passed on without.
    """
    entries = [entry for entry in collected if entry.kind != "SYMLINK"]
    sources = {entry.source for entry in entries}
    distributions, rest = _owners(sources, own)
    found = [_from_distribution(metadata.distribution(name)) for name in sorted({*distributions, *_ALWAYS})]
    found += [_python(), _qt(), *_icu(entries)]
    if sys.platform.startswith("linux"):
        found += _system_parts(rest)
    for part in found:
        if not part.texts:
            raise SetupError(f"The licence text of {part.name} is not found; put it into {LICENCE_FOLDER}.")
    return sorted(found, key=lambda part: (part.name.lower(), part.version))


def _owners(sources: set[str], own: Path) -> tuple[set[str], set[str]]:
    """The distributions that some files belong to, and the files that are neither theirs, Python's nor our own."""
    site = Path(sysconfig.get_path("purelib"))
    owner: dict[str, str] = {}
    for distribution in metadata.distributions(path=[str(site)]):
        name = canonical(distribution.name)
        for file in distribution.files or ():
            owner[str(site / file)] = name
    libraries = [Path(sys.base_prefix), Path(sysconfig.get_path("stdlib"))]
    names, rest = set(), set()
    for source in sources:
        path = Path(source)
        if source in owner:
            names.add(owner[source])
        elif not any(path.is_relative_to(one) for one in (own, ROOT)) and not _is_python(path, libraries):
            rest.add(source)
    return names, rest


def _is_python(path: Path, libraries: list[Path]) -> bool:
    # A system's own Python has /usr as its prefix, where everything else lies too.
    roots = libraries[1:] if libraries[0] == Path("/usr") else libraries
    own = ("libpython3", "base_library.zip")  # the latter is the part of the standard library that is wanted first
    return not path.is_absolute() or any(path.is_relative_to(one) for one in roots) or path.name.startswith(own)


def canonical(name: str) -> str:
    """As package indexes spell it."""
    return name.lower().replace("_", "-").replace(".", "-")


def _from_distribution(distribution: metadata.Distribution) -> Part:
    name = canonical(distribution.name)
    stated = distribution.metadata.get_all("License-Expression") or [None]
    return Part(
        name=distribution.name,
        version=distribution.version,
        purl=f"pkg:pypi/{name}@{distribution.version}",
        licence=_LICENCES.get(name) or stated[0],
        texts=tuple(LICENCE_FOLDER / text for text in _TEXTS[name]) if name in _TEXTS else _own_texts(distribution),
    )


def _own_texts(distribution: metadata.Distribution) -> tuple[Path, ...]:
    named = {Path(text).name for text in distribution.metadata.get_all("License-File") or ()}
    files = [
        file
        for file in distribution.files or ()
        if ".dist-info" in file.as_posix()
        and (file.name in named if named else file.name.startswith(("LICENSE", "LICENCE", "COPYING")))
    ]
    return tuple(Path(str(distribution.locate_file(file))) for file in files)


def _python() -> Part:
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
    )


def _qt() -> Part:
    from PySide6.QtCore import qVersion

    texts = tuple(LICENCE_FOLDER / text for text in _QT_TEXTS)
    return Part(
        name="Qt", version=qVersion(), purl=f"pkg:generic/qt@{qVersion()}", licence="LGPL-3.0-only", texts=texts
    )


def _icu(entries: Iterable[Entry]) -> Iterable[Part]:
    """Unicode's tables and rules, which come with Qt for Linux; their files bear the version."""
    for entry in entries:
        name, _, version = Path(entry.place).name.partition(".so.")
        if name == "libicudata":
            texts = (LICENCE_FOLDER / "ICU.txt",)
            yield Part(name="ICU", version=version, purl=f"pkg:generic/icu@{version}", licence="ICU", texts=texts)


def _system_parts(sources: Iterable[str]) -> list[Part]:
    """The libraries of the system's that Python needs, by the Debian packages that they came from."""
    packages: dict[str, Part] = {}
    for source in sorted(sources):
        name = _debian_package(Path(source))
        if name is None:
            raise SetupError(
                f"{source} goes into the bundle, and nothing here tells what it is and how it is licensed."
            )
        if name not in packages:
            version = _output("dpkg-query", "--show", "--showformat=${Version}", name)
            plain = name.partition(":")[0]
            text = Path("/usr/share/doc") / plain / "copyright"
            packages[name] = Part(
                name=plain,
                version=version,
                purl=f"pkg:deb/debian/{plain}@{version.replace('+', '%2B').replace(':', '%3A')}",
                licence=None,
                texts=(text.resolve(),) if text.exists() else (),
                is_program_library=False,
            )
    return list(packages.values())


def _debian_package(path: Path) -> str | None:
    """Which package a library came with; Debian lists some of them below /lib, which is a link to /usr/lib."""
    real = path.resolve()
    for one in (path, real, Path("/", *real.parts[2:])):
        try:
            answer = _output("dpkg-query", "--search", str(one))
        except (OSError, subprocess.CalledProcessError):
            continue
        return answer.splitlines()[0].rpartition(": ")[0].split(", ")[0]
    return None


def _output(*command: str) -> str:
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()
