"""Fills in the manifests for Flatpak and winget:  .venv/bin/python packaging/fill_manifests.py FOLDER

FOLDER contains the packages, such as dist/. Writes the manifests of those that are there to FOLDER/manifests, with
name, checksum and URL. The manifests were never tried with Flatpak and winget.
"""

import hashlib
import sys
from pathlib import Path
from typing import Final

from environment import ROOT
from release import Release, project, read_release

TEMPLATES: Final = ROOT / "packaging" / "manifests"
_PACKAGES: Final = {"flatpak.yml": "*-linux-x86_64.tar.gz", "winget.yaml": "*-windows-x86_64-setup.exe"}


def fill_manifests(folder: Path, release: Release) -> list[Path]:
    """Write the manifests; returns their paths."""
    written = []
    for name, pattern in _PACKAGES.items():
        for package in folder.glob(pattern):
            target = folder / "manifests" / name
            target.parent.mkdir(exist_ok=True)
            target.write_text(
                filled((TEMPLATES / name).read_text(encoding="utf-8"), package, release), encoding="utf-8"
            )
            written.append(target)
    return written


def filled(text: str, package: Path, release: Release) -> str:
    words = {key.upper(): value for key, value in project().items()} | {
        "VERSION": release.version,
        "DATE": f"{release.time:%Y-%m-%d}",
        "FILE": package.name,
        "SHA256": hashlib.sha256(package.read_bytes()).hexdigest(),
    }
    for word, value in words.items():
        text = text.replace(f"@{word}@", value)
    return text


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    for path in fill_manifests(Path(sys.argv[1]), read_release()):
        print(path)
