"""A third-party part of a bundle, and where its licence texts lie."""

import re
from dataclasses import dataclass
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


def canonical(name: str) -> str:
    """The normalized name of a distribution."""
    return name.lower().replace("_", "-").replace(".", "-")


def licence_folder(part: Part) -> str:
    """Folder of its texts below `licences`; that of a built-in work lies in the folder of the outer one."""
    plain = re.sub(r"[^a-z0-9]+", "-", part.name.lower()).strip("-")
    if (part.purl or "").startswith("pkg:cargo/"):
        plain = f"crate-{plain}"  # a crate is called openssl
    return plain if part.inside is None else f"inside-{canonical(part.inside)}/{plain}"
