"""Third-party works that are built into Qt, numpy and cryptography, or shipped with them or psycopg."""

import json
import re
import sys
from collections.abc import Iterator, Sequence
from importlib import metadata
from pathlib import Path
from typing import Final, NamedTuple

from bundle_contents import Entry
from environment import SetupError
from parts import LICENCE_FOLDER, Part, texts_of

QT_NOTICES: Final = LICENCE_FOLDER / "qt"
"""Written by docs/generate/qt_notices.py."""
_QT_LIBRARY: Final = re.compile(r"(?:.*/)?(?:lib)?Qt6?(\w+?)(?:\.so\.6|\.dll|)$")
_VERSIONS_IN_QT: Final = {
    "libpng.txt": re.compile(rb"libpng version (\d+\.\d+\.\d+)"),
    "pcre2.txt": re.compile(rb"\0(\d+\.\d+) \d{4}-\d\d-\d\d\0"),
}
"""Version strings in Qt's libraries, where a part may be newer than in the documentation."""


class Library(NamedTuple):
    """A work in libraries beside those of `around`. `files`: their places; `version` finds it in them."""

    around: str
    name: str
    files: str
    licence: str
    texts: tuple[str, ...]
    """Files in LICENCE_FOLDER, or a distribution and one of its texts."""
    version: re.Pattern[bytes] | None = None


_APACHE: Final = "cryptography/LICENSE.APACHE"
_NUMPYS: Final = ("numpy/LICENSE.txt",)
_OPENBLAS: Final = r"numpy.*/libscipy_openblas"
_OPENSSL: Final = re.compile(rb"OpenSSL (\d+\.\d+\.\d+)[\w-]* \d+ \w{3} \d{4}")
_PSYCOPG: Final = "psycopg-binary"
_OF_PSYCOPG: Final = "psycopg_binary.*/lib"
LIBRARIES: Final = (
    Library("Qt", "ICU", "PySide6/.*libicu", "ICU", ("ICU.txt",), re.compile(rb"icudt(\d+)")),
    Library("numpy", "OpenBLAS", _OPENBLAS, "BSD-3-Clause", _NUMPYS),
    Library("numpy", "LAPACK", _OPENBLAS, "BSD-3-Clause-Open-MPI", _NUMPYS),
    # In numpy's wheels for Windows these are in the one file of OpenBLAS.
    Library(
        "numpy", "libgfortran", rf"numpy.*/libgfortran|{_OPENBLAS}.*\.dll",
        "GPL-3.0-or-later WITH GCC-exception-3.1", _NUMPYS,
    ),
    Library(
        "numpy", "libquadmath", rf"numpy.*/libquadmath|{_OPENBLAS}.*\.dll", "LGPL-2.1-or-later",
        (*_NUMPYS, "LGPL-2.1.txt"),
    ),
    # Most texts are those of Debian's packages of the same works.
    Library(_PSYCOPG, "libpq", f"{_OF_PSYCOPG}pq", "PostgreSQL", ("psycopg/postgresql.txt",)),
    Library(_PSYCOPG, "OpenSSL", f"{_OF_PSYCOPG}(crypto|ssl)", "Apache-2.0", (_APACHE,), _OPENSSL),
    # The rest is for Linux and macOS; on Windows libpq asks the system.
    Library(
        _PSYCOPG, "MIT Kerberos", f"{_OF_PSYCOPG}(gssapi_krb5|k5crypto|krb5)",
        "MIT AND BSD-2-Clause AND BSD-3-Clause AND Brian-Gladman-3-Clause AND HPND-export-US AND OpenVision",
        ("psycopg/krb5.txt",), re.compile(rb"KRB5_BRAND: krb5-(\d+\.\d+(?:\.\d+)?)"),
    ),
    Library(_PSYCOPG, "com_err", f"{_OF_PSYCOPG}com_err", "LicenseRef-SIPB", ("psycopg/com_err.txt",)),
    Library(_PSYCOPG, "OpenLDAP", f"{_OF_PSYCOPG}(lber|ldap)", "OLDAP-2.8", ("psycopg/openldap.txt",)),
    Library(
        _PSYCOPG, "Cyrus SASL", f"{_OF_PSYCOPG}sasl2", "BSD-4-Clause-UC AND BSD-3-Clause",
        ("psycopg/cyrus-sasl.txt",), re.compile(rb"\0(\d+\.\d+\.\d+)\0"),
    ),
    Library(
        _PSYCOPG, "libxcrypt", f"{_OF_PSYCOPG}crypt[-.]",
        "LGPL-2.1-or-later AND BSD-3-Clause AND BSD-2-Clause AND 0BSD", ("psycopg/libxcrypt.txt", "LGPL-2.1.txt"),
    ),
    Library(
        _PSYCOPG, "keyutils", f"{_OF_PSYCOPG}keyutils", "LGPL-2.1-or-later",
        ("psycopg/keyutils.txt", "LGPL-2.1.txt"), re.compile(rb"keyutils-(\d+\.\d+\.\d+)"),
    ),
)  # fmt: skip
CRATES: Final = {
    "asn1": "rust/asn1.txt",
    "asn1_derive": "rust/asn1.txt",
    "openssl-sys": "rust/openssl-sys.txt",
    "pem": "rust/pem.txt",
    "unicode-ident": "rust/unicode-ident.txt",
}
"""Rust crates in cryptography whose licence is not, or not only, Apache's."""


def enclosed_parts(entries: Sequence[Entry]) -> Iterator[Part]:
    """Works inside `entries`, the files of a bundle. Raises SetupError if a library of psycopg's is none of them."""
    yield from _of_qt(entries)
    of_psycopg = {entry for entry in entries if re.match(_OF_PSYCOPG, entry.place)}
    for library in LIBRARIES:
        files = tuple(entry for entry in entries if re.match(library.files, entry.place))
        of_psycopg -= {*files}
        if files:
            yield Part(
                name=library.name, version=_version(library.version, files), purl=None, licence=library.licence,
                texts=tuple(map(text, library.texts)), files=files, inside=library.around,
            )  # fmt: skip
    for entry in of_psycopg:
        raise SetupError(f"{entry.place} came with {_PSYCOPG}: name it with its licence in enclosed_parts.py.")
    yield from _of_cryptography(tuple(entry for entry in entries if "/_rust." in entry.place))


def _version(pattern: re.Pattern[bytes] | None, files: Sequence[Entry]) -> str | None:
    matches = (pattern.search(Path(file.source).read_bytes()) for file in files) if pattern is not None else ()
    return next((match[1].decode() for match in matches if match), None)


def _of_qt(entries: Sequence[Entry]) -> Iterator[Part]:
    libraries = {match[1]: entry for entry in entries if (match := _QT_LIBRARY.fullmatch(entry.place))}
    listed = json.loads((QT_NOTICES / "parts.json").read_text(encoding="utf-8"))
    for part in listed["parts"]:
        if part["library"] in libraries and sys.platform in part["systems"]:
            files = (libraries[part["library"]],)
            version = _version(_VERSIONS_IN_QT.get(part["file"]), files)
            yield Part(
                name=part["name"], version=version or part["version"], purl=None, licence=part["licence"],
                texts=(QT_NOTICES / part["file"],), files=files, inside="Qt",
                note=f"version: Qt {listed['documentation']}" if version is None and part["version"] else None,
            )  # fmt: skip


def _of_cryptography(files: tuple[Entry, ...]) -> Iterator[Part]:
    """OpenSSL and Rust crates, from the lists that its makers put into its wheels; without tools of their build."""
    brought = [file for file in metadata.files("cryptography") or () if file.parent.name == "sboms"] if files else []
    for listed in brought:
        for work in json.loads(listed.read_text(encoding="utf-8"))["components"]:
            name, purl = work["name"], work["purl"]
            if work.get("scope") != "excluded" and "download_url=file:" not in purl:  # the latter are its own
                licence = "Apache-2.0" if name == "openssl" else work["licenses"][0]["expression"]
                texts = [_APACHE if "Apache-2.0" in licence else None, CRATES.get(name)]
                yield Part(
                    name=name, version=work["version"], purl=purl, licence=licence, files=files, inside="cryptography",
                    texts=tuple(text(one) for one in texts if one is not None),
                )  # fmt: skip


def text(name: str) -> Path:
    """The licence text that a table here names."""
    if (LICENCE_FOLDER / name).is_file():
        return LICENCE_FOLDER / name
    distribution, _, file = name.partition("/")
    return next(path for path in texts_of(metadata.distribution(distribution)) if path.name == file)
