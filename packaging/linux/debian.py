"""Builds the .deb with dpkg-deb: the bundle below /usr/lib, and files for the desktop."""

import gzip
import platform
from pathlib import Path
from shutil import copytree
from typing import Final

from environment import ROOT, run
from icon_files import write_theme_icons
from release import COMMAND, NAME, Release, filled, project, set_rights, stamp_times

LINUX: Final = ROOT / "packaging" / "linux"
METAINFO: Final = "io.github.dps_s.configurator.metainfo.xml"
PLACE: Final = f"usr/lib/{NAME}"
PAPERS: Final = f"usr/share/doc/{NAME}"
COMPLETIONS: Final = {
    "bash": f"usr/share/bash-completion/completions/{COMMAND}",
    "zsh": f"usr/share/zsh/vendor-completions/_{COMMAND}",
    "fish": f"usr/share/fish/vendor_completions.d/{COMMAND}.fish",
}
_COMPRESSION: Final = ("-Zzstd", "-z9")
"""Takes a sixth of the time of xz, and is 7 % larger; Debian 12 and Ubuntu 22.04 can read it."""


def make_deb(release: Release, bundle: Path, *, work: Path, dist: Path) -> None:
    root = work / "deb"
    _lay_out(root, release, bundle)
    control = root / "DEBIAN"
    size = sum(path.lstat().st_size for path in root.rglob("*") if path.is_file() or path.is_symlink())
    stated = project()
    text = filled(
        LINUX / "control",
        VERSION=release.version,
        ARCHITECTURE=run(["dpkg", "--print-architecture"], "dpkg failed").strip(),
        MAINTAINER=f"{stated['maintainer']} <{stated['address']}>",
        SIZE=str(-(-size // 1024)),
        GLIBC=platform.libc_ver()[1],
        HOMEPAGE=stated["home_page"],
    )
    _write(control / "control", text.encode())
    scripts = [control / "postinst", control / "postrm"]
    for script in scripts:
        _write(script, (LINUX / script.name).read_bytes())
    set_rights(root, [root / PLACE / COMMAND, *scripts])
    stamp_times(root, release.epoch)
    command = ["dpkg-deb", "--root-owner-group", *_COMPRESSION, "--build", str(root), str(dist)]
    variables = {"SOURCE_DATE_EPOCH": str(release.epoch), "PATH": "/usr/sbin:/usr/bin:/sbin:/bin"}
    run(command, "dpkg-deb failed", variables=variables)


def _lay_out(root: Path, release: Release, bundle: Path) -> None:
    copytree(bundle, root / PLACE, symlinks=True)
    (root / PLACE / "README.txt").unlink()  # for the unpacked archive
    program = root / "usr/bin" / COMMAND
    program.parent.mkdir(parents=True)
    program.symlink_to(f"../lib/{NAME}/{COMMAND}")
    for folder, name in (
        ("usr/share/applications", f"{NAME}.desktop"),
        ("usr/share/mime/packages", f"{NAME}.xml"),
        ("usr/lib/udev/rules.d", "60-dps-s.rules"),
        (PAPERS, "copyright"),
    ):
        _write(root / folder / name, (LINUX / name).read_bytes())
    metainfo = filled(LINUX / METAINFO, VERSION=release.version, DATE=f"{release.time:%Y-%m-%d}")
    _write(root / "usr/share/metainfo" / METAINFO, metainfo.encode())
    write_theme_icons(root / "usr/share/icons/hicolor")
    english = {"LC_ALL": "C.UTF-8", "LANGUAGE": "en"}
    for shell, place in COMPLETIONS.items():
        command = [str(bundle / COMMAND), "completion", shell]
        _write(root / place, run(command, "The program printed no completions", variables=english).encode())
    _write_zipped(root / PAPERS / "changelog.gz", ROOT / "CHANGELOG.md")
    _write_zipped(root / "usr/share/man/man1" / f"{COMMAND}.1.gz", LINUX / f"{COMMAND}.1")


def _write(path: Path, content: bytes) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(content)


def _write_zipped(path: Path, source: Path) -> None:
    _write(path, gzip.compress(source.read_bytes(), 9, mtime=0))
