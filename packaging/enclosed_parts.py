"""Whose work is inside the libraries of others: built into Qt, numpy and cryptography, so no file bears its name."""

import json
import re
import sys
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path, PurePosixPath
from typing import Final, NamedTuple

from bundle_contents import Entry
from environment import SetupError
from inventory import LICENCE_FOLDER, Part, canonical

QT_NOTICES: Final = LICENCE_FOLDER / "qt"
"""Written by docs/generate/qt_notices.py."""
_QT_LIBRARY: Final = re.compile(r"(?:lib)?Qt6?(\w+?)(?:\.so\.6|\.dll|)$")
_VERSIONS_IN_QT: Final = {
    "libpng.txt": re.compile(rb"libpng version (\d+\.\d+\.\d+)"),
    "pcre2.txt": re.compile(rb"\0(\d+\.\d+) \d{4}-\d\d-\d\d\0"),
}
"""What libraries of Qt say of themselves: such a part may be newer than in the documentation."""


class _OfNumpy(NamedTuple):
    name: str
    files: re.Pattern[str]
    licence: str
    texts: tuple[str, ...] = ()


_OPENBLAS: Final = re.compile(r"libscipy_openblas")
_OF_NUMPY: Final = (
    _OfNumpy("OpenBLAS", _OPENBLAS, "BSD-3-Clause"),
    _OfNumpy("LAPACK", _OPENBLAS, "BSD-3-Clause-Open-MPI"),
    # In numpy's wheels for Windows these are in the one file of OpenBLAS.
    _OfNumpy(
        "libgfortran", re.compile(r"libgfortran|libscipy_openblas.*\.dll"), "GPL-3.0-or-later WITH GCC-exception-3.1"
    ),
    _OfNumpy(
        "libquadmath", re.compile(r"libquadmath|libscipy_openblas.*\.dll"), "LGPL-2.1-or-later", ("LGPL-2.1.txt",)
    ),
)
"""What numpy's wheels bring, as the list in numpy's own LICENSE.txt says, which is their text too."""
RUST_TEXTS: Final = LICENCE_FOLDER / "rust"
_LICENCES_OF_CRATES: Final = {"asn1": "BSD-3-Clause", "openssl-sys": "MIT", "pem": "MIT"}
"""With a text of our own in `RUST_TEXTS`; the others leave the choice of the Apache licence."""
_RUST_LIBRARY: Final = "_rust."
_CRATE: Final = re.compile(rb"[/\\]registry[/\\]src[/\\][^/\\\0]+[/\\]([A-Za-z0-9_-]+)-(\d+\.\d+\.\d+)[/\\]")
_OPENSSL: Final = re.compile(rb"OpenSSL (\d+\.\d+\.\d+)[\w-]* \d+ \w{3} \d{4}")


def enclosed_parts(entries: Sequence[Entry], around: Iterable[Part]) -> Iterator[Part]:
    """All that `entries`, the files of a bundle, hold in themselves. `around` are the parts that they belong to.

    Raises SetupError where a text is missing.
    """
    texts = {canonical(part.name): part.texts for part in around}
    yield from _of_qt(entries)
    yield from _of_numpy(entries, texts.get("numpy", ()))
    yield from _of_cryptography(entries, texts.get("cryptography", ()))


def _of_qt(entries: Sequence[Entry]) -> Iterator[Part]:
    libraries = {
        found[1]: entry
        for entry in entries
        if (found := _QT_LIBRARY.fullmatch(PurePosixPath(entry.place.replace("\\", "/")).name))
    }
    listed = json.loads((QT_NOTICES / "parts.json").read_text(encoding="utf-8"))
    for part in listed["parts"]:
        if part["library"] in libraries and sys.platform in part["systems"]:
            entry = libraries[part["library"]]
            pattern = _VERSIONS_IN_QT.get(part["file"])
            said = pattern.search(Path(entry.source).read_bytes()) if pattern is not None else None
            yield Part(
                name=part["name"],
                version=said[1].decode() if said is not None else part["version"],
                purl=None,
                licence=part["licence"],
                texts=(_text(QT_NOTICES / part["file"]),),
                files=(entry,),
                inside="Qt",
                note=f"version: Qt {listed['documentation']}" if said is None and part["version"] else None,
            )


def _of_numpy(entries: Sequence[Entry], texts: tuple[Path, ...]) -> Iterator[Part]:
    whole = [text for text in texts if text.name == "LICENSE.txt" and b"OpenBLAS" in text.read_bytes()]
    for one in _OF_NUMPY:
        files = tuple(entry for entry in entries if one.files.match(PurePosixPath(entry.place.replace("\\", "/")).name))
        if files:
            own = (LICENCE_FOLDER / name for name in one.texts)
            yield Part(
                name=one.name,
                version=None,
                purl=None,
                licence=one.licence,
                texts=tuple(_text(text) for text in (*whole, *own)),
                files=files,
                inside="numpy",
            )


def _of_cryptography(entries: Sequence[Entry], texts: tuple[Path, ...]) -> Iterator[Part]:
    """OpenSSL and crates of Rust; the paths in the library name those that can report an error."""
    for entry in entries:
        if not PurePosixPath(entry.place.replace("\\", "/")).name.startswith(_RUST_LIBRARY):
            continue
        content = Path(entry.source).read_bytes()
        apache = tuple(text for text in texts if text.name == "LICENSE.APACHE")
        found: set[tuple[str, str, str, str | None]] = {
            ("OpenSSL", one[1].decode(), "Apache-2.0", None) for one in _OPENSSL.finditer(content)
        }
        for one in _CRATE.finditer(content):
            name, version = one[1].decode(), one[2].decode()
            found.add((name, version, _LICENCES_OF_CRATES.get(name, "Apache-2.0"), f"pkg:cargo/{name}@{version}"))
        for name, version, licence, purl in sorted(found, key=lambda one: one[:2]):
            yield Part(
                name=name,
                version=version,
                purl=purl,
                licence=licence,
                texts=(_text(RUST_TEXTS / f"{name}.txt"),) if name in _LICENCES_OF_CRATES else apache,
                files=(entry,),
                inside="cryptography",
            )


def _text(path: Path) -> Path:
    if not path.exists():
        raise SetupError(f"The licence text {path} is missing.")
    return path
