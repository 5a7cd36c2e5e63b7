"""Third-party works that are built into Qt, numpy and cryptography, or shipped with psycopg."""

import json
import re
import sys
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path, PurePosixPath
from typing import Final, NamedTuple

from bundle_contents import Entry
from environment import SetupError
from parts import LICENCE_FOLDER, Part, canonical

QT_NOTICES: Final = LICENCE_FOLDER / "qt"
"""Written by docs/generate/qt_notices.py."""
_QT_LIBRARY: Final = re.compile(r"(?:lib)?Qt6?(\w+?)(?:\.so\.6|\.dll|)$")
_VERSIONS_IN_QT: Final = {
    "libpng.txt": re.compile(rb"libpng version (\d+\.\d+\.\d+)"),
    "pcre2.txt": re.compile(rb"\0(\d+\.\d+) \d{4}-\d\d-\d\d\0"),
}
"""Version strings in Qt's libraries, where a part may be newer than in the documentation."""


class _Library(NamedTuple):
    """`version` finds the version in the library, if it contains one."""

    name: str
    files: re.Pattern[str]
    licence: str
    texts: tuple[str, ...] = ()
    version: re.Pattern[bytes] | None = None


_OPENBLAS: Final = re.compile(r"libscipy_openblas")
_OF_NUMPY: Final = (
    _Library("OpenBLAS", _OPENBLAS, "BSD-3-Clause"),
    _Library("LAPACK", _OPENBLAS, "BSD-3-Clause-Open-MPI"),
    # In numpy's wheels for Windows these are in the one file of OpenBLAS.
    _Library(
        "libgfortran", re.compile(r"libgfortran|libscipy_openblas.*\.dll"), "GPL-3.0-or-later WITH GCC-exception-3.1"
    ),
    _Library(
        "libquadmath", re.compile(r"libquadmath|libscipy_openblas.*\.dll"), "LGPL-2.1-or-later", ("LGPL-2.1.txt",)
    ),
)
"""Libraries in numpy's wheels. Their texts are in numpy's LICENSE.txt."""
_OPENSSL: Final = re.compile(rb"OpenSSL (\d+\.\d+\.\d+)[\w-]* \d+ \w{3} \d{4}")
_OF_PSYCOPG: Final = (
    _Library("libpq", re.compile(r"libpq"), "PostgreSQL", ("psycopg/postgresql.txt",)),
    _Library("OpenSSL", re.compile(r"lib(?:crypto|ssl)"), "Apache-2.0", (), _OPENSSL),
    # The rest is for Linux and macOS; on Windows libpq asks the system.
    _Library(
        "MIT Kerberos", re.compile(r"lib(?:gssapi_krb5|k5crypto|krb5)"),
        "MIT AND BSD-2-Clause AND BSD-3-Clause AND Brian-Gladman-3-Clause AND HPND-export-US AND OpenVision",
        ("psycopg/krb5.txt",), re.compile(rb"KRB5_BRAND: krb5-(\d+\.\d+(?:\.\d+)?)"),
    ),
    _Library("com_err", re.compile(r"libcom_err"), "LicenseRef-SIPB", ("psycopg/com_err.txt",)),
    _Library("OpenLDAP", re.compile(r"lib(?:lber|ldap)"), "OLDAP-2.8", ("psycopg/openldap.txt",)),
    _Library(
        "Cyrus SASL", re.compile(r"libsasl2"), "BSD-4-Clause-UC AND BSD-3-Clause", ("psycopg/cyrus-sasl.txt",),
        re.compile(rb"\0(\d+\.\d+\.\d+)\0"),
    ),
    _Library(
        "libxcrypt", re.compile(r"libcrypt[-.]"), "LGPL-2.1-or-later AND BSD-3-Clause AND BSD-2-Clause AND 0BSD",
        ("psycopg/libxcrypt.txt", "LGPL-2.1.txt"),
    ),
    _Library(
        "keyutils", re.compile(r"libkeyutils"), "LGPL-2.1-or-later", ("psycopg/keyutils.txt", "LGPL-2.1.txt"),
        re.compile(rb"keyutils-(\d+\.\d+\.\d+)"),
    ),
)  # fmt: skip
"""Libraries in psycopg-binary. Most texts are those of Debian's packages of the same works."""
RUST_TEXTS: Final = LICENCE_FOLDER / "rust"
_LICENCES_OF_CRATES: Final = {"asn1": "BSD-3-Clause", "openssl-sys": "MIT", "pem": "MIT"}
"""Crates with a text in `RUST_TEXTS`; the others may be used under the Apache licence."""
_RUST_LIBRARY: Final = "_rust."
_CRATE: Final = re.compile(rb"[/\\]registry[/\\]src[/\\][^/\\\0]+[/\\]([A-Za-z0-9_-]+)-(\d+\.\d+\.\d+)[/\\]")


def enclosed_parts(entries: Sequence[Entry], around: Iterable[Part]) -> Iterator[Part]:
    """Works inside `entries`, the files of a bundle. `around` are the parts that these belong to.

    Raises SetupError if a text is missing.
    """
    texts = {canonical(part.name): part.texts for part in around}
    yield from _of_qt(entries)
    yield from _of_numpy(entries, texts.get("numpy", ()))
    apache = tuple(text for text in texts.get("cryptography", ()) if text.name == "LICENSE.APACHE")
    yield from _of_cryptography(entries, apache)
    yield from _of_psycopg(entries, apache)


def _of_qt(entries: Sequence[Entry]) -> Iterator[Part]:
    libraries = {match[1]: entry for entry in entries if (match := _QT_LIBRARY.fullmatch(_name(entry)))}
    listed = json.loads((QT_NOTICES / "parts.json").read_text(encoding="utf-8"))
    for part in listed["parts"]:
        if part["library"] in libraries and sys.platform in part["systems"]:
            entry = libraries[part["library"]]
            pattern = _VERSIONS_IN_QT.get(part["file"])
            version = pattern.search(Path(entry.source).read_bytes()) if pattern is not None else None
            yield Part(
                name=part["name"],
                version=version[1].decode() if version is not None else part["version"],
                purl=None,
                licence=part["licence"],
                texts=(_text(QT_NOTICES / part["file"]),),
                files=(entry,),
                inside="Qt",
                note=f"version: Qt {listed['documentation']}" if version is None and part["version"] else None,
            )


def _of_numpy(entries: Sequence[Entry], texts: tuple[Path, ...]) -> Iterator[Part]:
    whole = tuple(text for text in texts if text.name == "LICENSE.txt" and b"OpenBLAS" in text.read_bytes())
    for library in _OF_NUMPY:
        yield from _libraries(library, "numpy", entries, whole)


def _of_psycopg(entries: Sequence[Entry], apache: tuple[Path, ...]) -> Iterator[Part]:
    beside = [entry for entry in entries if "psycopg_binary" in entry.place]
    for library in _OF_PSYCOPG:
        yield from _libraries(library, "psycopg-binary", beside, () if library.texts else apache)
    known = [library.files for library in _OF_PSYCOPG]
    for entry in beside:
        name = _name(entry)
        if name.startswith("lib") and not any(pattern.match(name) for pattern in known):
            raise SetupError(f"{name} came with psycopg-binary: name it with its licence in enclosed_parts.py.")


def _libraries(library: _Library, around: str, entries: Sequence[Entry], texts: tuple[Path, ...]) -> Iterator[Part]:
    files = tuple(entry for entry in entries if library.files.match(_name(entry)))
    if files:
        matches = (library.version.search(Path(file.source).read_bytes()) for file in files) if library.version else ()
        yield Part(
            name=library.name,
            version=next((match[1].decode() for match in matches if match), None),
            purl=None,
            licence=library.licence,
            texts=tuple(_text(text) for text in (*texts, *(LICENCE_FOLDER / name for name in library.texts))),
            files=files,
            inside=around,
        )


def _name(entry: Entry) -> str:
    return PurePosixPath(entry.place.replace("\\", "/")).name


def _of_cryptography(entries: Sequence[Entry], apache: tuple[Path, ...]) -> Iterator[Part]:
    """OpenSSL and Rust crates, which are found by the source paths that the library contains."""
    for entry in entries:
        if not _name(entry).startswith(_RUST_LIBRARY):
            continue
        content = Path(entry.source).read_bytes()
        works: set[tuple[str, str, str, str | None]] = {
            ("OpenSSL", match[1].decode(), "Apache-2.0", None) for match in _OPENSSL.finditer(content)
        }
        for match in _CRATE.finditer(content):
            name, version = match[1].decode(), match[2].decode()
            works.add((name, version, _LICENCES_OF_CRATES.get(name, "Apache-2.0"), f"pkg:cargo/{name}@{version}"))
        for name, version, licence, purl in sorted(works, key=lambda work: work[:2]):
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
