"""A third-party part of a bundle, and where its licence texts lie."""

import re
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path
from typing import Final

from bundle_contents import Entry
from environment import ROOT

LICENCE_FOLDER: Final = ROOT / "packaging" / "licences"


@dataclass(frozen=True, slots=True, kw_only=True)
class Part:
    """A third-party work: `licence` is an SPDX expression, `files` are its files in the bundle."""

    name: str
    version: str | None
    purl: str | None
    licence: str
    texts: tuple[Path, ...]
    files: tuple[Entry, ...]
    inside: str | None = None
    """The work that it is built into, whose files `files` are."""
    note: str | None = None

    @property
    def folder(self) -> str:
        """Folder of its texts below `licences`; that of a built-in work lies in the folder of the outer one."""
        plain = _plain(self.name)
        if (self.purl or "").startswith("pkg:cargo/"):
            plain = f"crate-{plain}"  # a crate is called openssl
        return plain if self.inside is None else f"inside-{_plain(self.inside)}/{plain}"


def _plain(name: str) -> str:
    return re.sub(r"[^a-z0-9]+", "-", name.lower()).strip("-")


def texts_of(distribution: metadata.Distribution) -> tuple[Path, ...]:
    """The licence texts that a distribution brings, the one of the whole first."""
    files = [file for file in distribution.files or () if ".dist-info" in file.as_posix()]
    texts = [file for file in files if re.search("LICEN[CS]E|COPYING", file.name)]
    return tuple(Path(str(distribution.locate_file(text))) for text in sorted(texts, key=lambda text: len(text.parts)))
