"""Builds the bundle: a folder with the program, Python and Qt."""

import gzip
import json
import platform
import shutil
import sys
import tarfile
import zipfile
from collections.abc import Sequence
from pathlib import Path
from typing import Final

from bundle_contents import Entry
from environment import ROOT, run
from icon_files import write_program_icons
from inventory import parts
from linux.elf import make_run_paths_relative
from parts import Part
from release import COMMAND, NAME, TITLE, Release, filled, set_rights, stamp_times
from sbom import LICENCES, bill_of_materials

SPEC: Final = ROOT / "packaging" / "dps-s.spec"
BILL: Final = "sbom.cdx.json"
_LINUX_README: Final = ROOT / "packaging" / "linux" / "README.txt"
_WITH_DEBUG_TABLES: Final = ("libpython3*.so*", "zstandard/*.so", "lz4/**/*.so", "python3*/lib-dynload/*.so")
"""Stripping makes these smaller by a third to a half. Qt's and numpy's libraries stay as shipped."""


def make_bundle(release: Release, wheel: Path, *, work: Path, dist: Path) -> Path:
    """Build it from the wheel; returns the folder, on macOS the .app, in `dist`.

    Raises SetupError if PyInstaller fails or a licence is unknown.
    """
    site, icons, contents = work / "site", work / "icons", work / "contents.json"
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(site)  # noqa: S202  built by us
    write_program_icons(icons)
    _run_pyinstaller(release, work, {"DPS_S_SITE": site, "DPS_S_ICONS": icons, "DPS_S_CONTENTS": contents})
    listed = json.loads(contents.read_text(encoding="utf-8"))
    collected = [Entry(place.replace("\\", "/"), source, kind) for place, source, kind in listed]
    bundled = parts(collected, site)
    built = work / "frozen" / (f"{TITLE}.app" if sys.platform == "darwin" else NAME)
    folder = dist / (built.name if sys.platform == "darwin" else release.bundle_name)
    shutil.move(built, folder)
    papers, internal = folder, folder / "_internal"
    if sys.platform == "darwin":
        papers, internal = folder / "Contents" / "Resources", folder / "Contents" / "Frameworks"
    if sys.platform.startswith("linux"):
        _strip(internal)
        machine, glibc = release.system.partition("-")[2], platform.libc_ver()[1]
        readme = filled(_LINUX_README, VERSION=release.version, MACHINE=machine, GLIBC=glibc)
        (folder / "README.txt").write_text(readme, encoding="utf-8")
    _add_papers(papers, internal, release, bundled)
    shutil.copyfile(papers / BILL, dist / f"{release.bundle_name}.cdx.json")
    if sys.platform.startswith("linux"):
        set_rights(folder, [folder / COMMAND])
    elif sys.platform == "darwin":
        from macos.disk_image import sign_again

        sign_again(folder)
    stamp_times(folder, release.epoch)
    return folder


def _run_pyinstaller(release: Release, work: Path, places: dict[str, Path]) -> None:
    """Run it outside of the checkout, whose metadata it would include."""
    command = [sys.executable, "-m", "PyInstaller", "--noconfirm", "--log-level", "ERROR"]
    command += ["--distpath", str(work / "frozen"), "--workpath", str(work / "pyinstaller"), str(SPEC)]
    variables = {
        "PYTHONHASHSEED": "1",  # the order of names in compiled modules is then always the same
        "SOURCE_DATE_EPOCH": str(release.epoch),
        "PYINSTALLER_CONFIG_DIR": str(work / "cache"),
        **{name: str(place) for name, place in places.items()},
    }
    run(command, "PyInstaller failed", variables=variables, folder=work)


def _add_papers(folder: Path, internal: Path, release: Release, bundled: Sequence[Part]) -> None:
    """Write the list of parts, and a folder with the licence of each part."""
    bill = bill_of_materials(release, bundled, internal)
    (folder / BILL).write_text(f"{bill}\n", encoding="utf-8")
    own = folder / LICENCES / NAME
    own.mkdir(parents=True)
    shutil.copyfile(ROOT / "LICENSE", own / "LICENSE.txt")
    for part in bundled:
        place = folder / LICENCES / part.folder
        place.mkdir(parents=True)
        for number, text in enumerate(part.texts):
            name = text.name if not (place / text.name).exists() else f"{number}-{text.parent.name}-{text.name}"
            (place / name).write_bytes(text.read_bytes())


def _strip(internal: Path) -> None:
    """Remove paths of the build machine and debug information."""
    make_run_paths_relative(internal)
    for pattern in _WITH_DEBUG_TABLES:
        for library in sorted(internal.glob(pattern)):
            if not library.is_symlink():
                run(["strip", "--strip-debug", str(library)], "strip failed")


def pack(folder: Path, release: Release) -> None:
    """The bundle as one file beside it: .tar.gz on Linux, .zip on Windows, .dmg on macOS."""
    target = str(folder.parent / release.bundle_name)
    if sys.platform == "darwin":
        from macos.disk_image import make_disk_image

        make_disk_image(folder, Path(f"{target}.dmg"))
    elif sys.platform == "win32":
        shutil.make_archive(target, "zip", root_dir=folder.parent, base_dir=folder.name)
    else:
        write_tar(Path(f"{target}.tar.gz"), folder, release.epoch)


def write_tar(target: Path, folder: Path, epoch: int) -> None:
    """Pack a folder reproducibly: sorted, with one time and no owner."""

    def plain(info: tarfile.TarInfo) -> tarfile.TarInfo:
        info.uid = info.gid = 0
        info.uname = info.gname = ""
        info.mode = 0o755 if info.isdir() or info.mode & 0o100 else 0o644
        info.mtime = epoch
        return info

    with (
        target.open("wb") as file,
        gzip.GzipFile(filename="", mode="wb", fileobj=file, mtime=epoch, compresslevel=6) as zipped,
        tarfile.open(fileobj=zipped, mode="w", format=tarfile.PAX_FORMAT) as tar,
    ):
        tar.add(folder, arcname=folder.name, filter=plain)  # adds a folder's files in the order of their names
