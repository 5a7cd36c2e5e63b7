"""The manifests for Flatpak and winget, filled in:  .venv/bin/python packaging/fill_manifests.py FOLDER

FOLDER has the packages, as dist/ has. Writes FOLDER/manifests with those whose package is there: it states its name,
its sum and where it will be downloaded. What they are for was never run by us.
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
    """Those that were written."""
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
