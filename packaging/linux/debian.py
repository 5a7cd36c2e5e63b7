"""Builds the .deb with dpkg-deb: the bundle below /usr/lib, and files for the desktop."""

import gzip
import hashlib
import subprocess
from collections.abc import Iterable
from pathlib import Path
from shutil import copytree
from typing import Final

from environment import ROOT, run
from icon_files import write_theme_icons
from release import COMMAND, NAME, TITLE, Release, project, set_rights, stamp_times

from linux.elf import glibc_wanted

LINUX: Final = ROOT / "packaging" / "linux"
RULE: Final = LINUX / "60-dps-s.rules"
METAINFO: Final = "io.github.dps_s.configurator.metainfo.xml"
PLACE: Final = f"usr/lib/{NAME}"
REVISION: Final = "1"
COMPLETIONS: Final = {
    "bash": f"usr/share/bash-completion/completions/{COMMAND}",
    "zsh": f"usr/share/zsh/vendor-completions/_{COMMAND}",
    "fish": f"usr/share/fish/vendor_completions.d/{COMMAND}.fish",
}
_COMPRESSION: Final = ("-Zzstd", "-z9")
"""Takes a sixth of the time of xz, and is 7 % larger; Debian 12 and Ubuntu 22.04 can read it."""
DEPENDS: Final = (
    "libdbus-1-3", "libegl1", "libfontconfig1", "libfreetype6", "libgcc-s1", "libgl1", "libglib2.0-0 | libglib2.0-0t64",
    "libstdc++6", "libwayland-client0", "libwayland-cursor0", "libwayland-egl1", "libx11-6", "libx11-xcb1",
    "libxcb-cursor0", "libxcb-glx0", "libxcb-icccm4", "libxcb-image0", "libxcb-keysyms1", "libxcb-randr0",
    "libxcb-render-util0", "libxcb-render0", "libxcb-shape0", "libxcb-shm0", "libxcb-sync1", "libxcb-util1",
    "libxcb-xfixes0", "libxcb-xkb1", "libxcb1", "libxkbcommon-x11-0", "libxkbcommon0", "libzstd1",
)  # fmt: skip
"""Packages of the libraries that the bundle takes from the system, besides the C library. tests/packages/test_deb.py
compares them with what the bundle asks for; Debian 13 and Ubuntu 24.04 call some of them …t64."""


def make_deb(release: Release, bundle: Path, *, work: Path, dist: Path) -> Path:
    """Build it from the bundle."""
    root = work / "deb"
    _lay_out(root, release, bundle)
    control = root / "DEBIAN"
    control.mkdir()
    architecture = run(["dpkg", "--print-architecture"], "dpkg failed").strip()
    (control / "control").write_text(control_text(release, root, bundle, architecture), encoding="utf-8")
    (control / "md5sums").write_text(_sums(root), encoding="utf-8")
    for script in ("postinst", "postrm"):
        (control / script).write_bytes((LINUX / script).read_bytes())
    set_rights(root, [root / PLACE / COMMAND, control / "postinst", control / "postrm"])
    stamp_times(root, release.epoch)
    target = dist / f"{NAME}_{release.version}-{REVISION}_{architecture}.deb"
    command = ["dpkg-deb", "--root-owner-group", *_COMPRESSION, "--build", str(root), str(target)]
    variables = {"SOURCE_DATE_EPOCH": str(release.epoch), "PATH": "/usr/sbin:/usr/bin:/sbin:/bin"}
    subprocess.run(command, env=variables, check=True, stdout=subprocess.DEVNULL)
    return target


def _lay_out(root: Path, release: Release, bundle: Path) -> None:
    copytree(bundle, root / PLACE, symlinks=True)
    (root / PLACE / "README.txt").unlink()  # for the unpacked archive
    program = root / "usr/bin" / COMMAND
    program.parent.mkdir(parents=True)
    program.symlink_to(f"../lib/{NAME}/{COMMAND}")
    _write(root / "usr/share/applications" / f"{NAME}.desktop", (LINUX / f"{NAME}.desktop").read_bytes())
    metainfo = (LINUX / METAINFO).read_text(encoding="utf-8")
    metainfo = metainfo.replace("@VERSION@", release.version).replace("@DATE@", f"{release.time:%Y-%m-%d}")
    _write(root / "usr/share/metainfo" / METAINFO, metainfo.encode())
    write_theme_icons(root / "usr/share/icons/hicolor")
    _write(root / "usr/lib/udev/rules.d" / RULE.name, RULE.read_bytes())
    _write(root / "usr/share/mime/packages" / f"{NAME}.xml", (LINUX / f"{NAME}.xml").read_bytes())
    for shell, place in COMPLETIONS.items():
        english = {"LC_ALL": "C.UTF-8", "LANGUAGE": "en"}
        script = run(
            [str(bundle / COMMAND), "completion", shell], "The program printed no completions", variables=english
        )
        _write(root / place, script.encode())
    _write_papers(root, release)


def _write_papers(root: Path, release: Release) -> None:
    papers = root / "usr/share/doc" / NAME
    _write(papers / "copyright", (LINUX / "copyright").read_bytes())
    _write_zipped(papers / "changelog.gz", (ROOT / "CHANGELOG.md").read_bytes())
    _write_zipped(papers / "changelog.Debian.gz", _changelog(release).encode())
    _write_zipped(root / "usr/share/man/man1" / f"{COMMAND}.1.gz", (LINUX / f"{COMMAND}.1").read_bytes())
    _write(root / "usr/share/lintian/overrides" / NAME, (LINUX / "lintian-overrides").read_bytes())


def _write(path: Path, content: bytes) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(content)


def _write_zipped(path: Path, content: bytes) -> None:
    _write(path, gzip.compress(content, 9, mtime=0))


def _maintainer() -> str:
    stated = project()
    return f"{stated['maintainer']} <{stated['address']}>"


def _changelog(release: Release) -> str:
    return (
        f"{NAME} ({release.version}-{REVISION}) unstable; urgency=medium\n\n"
        f"  * Version {release.version}; what changed is in changelog.gz.\n\n"
        f" -- {_maintainer()}  {release.time:%a, %d %b %Y %H:%M:%S} +0000\n"
    )


def control_text(release: Release, root: Path, bundle: Path, architecture: str) -> str:
    """The control file of the package in `root`, which `bundle` was copied to."""
    size = sum(path.lstat().st_size for path in root.rglob("*") if path.is_file() or path.is_symlink())
    fields = {
        "Package": NAME,
        "Version": f"{release.version}-{REVISION}",
        "Architecture": architecture,
        "Maintainer": _maintainer(),
        "Installed-Size": str(-(-size // 1024)),
        "Depends": ", ".join(("libc6 (>= {}.{})".format(*glibc_wanted(bundle)), *DEPENDS)),
        "Recommends": "fonts-wqy-microhei | fonts-noto-cjk",
        "Suggests": "libgtk-3-0 | libgtk-3-0t64",  # for a plugin of Qt with GTK's look and file dialogs
        "Homepage": project()["home_page"],
        "Section": "electronics",
        "Priority": "optional",
    }
    description = (
        "ground tool for DPS-S drone parachute modules\n"
        " Connects to a DPS-S module's serial port, shows attitude, acceleration, trigger\n"
        " and activation state, cell voltage, charge and light live, sets every\n"
        " threshold, rate and flag and proves that it stands, keeps the trigger records,\n"
        " and checks before a flight that the parachute will work.\n"
        " .\n"
        f" {TITLE} has a window and a command line (dps-s), and a simulated\n"
        " module to try both on. It comes with its own Python and Qt.\n"
    )
    return "".join(f"{key}: {value}\n" for key, value in fields.items()) + f"Description: {description}"


def _sums(root: Path) -> str:
    return "".join(
        f"{hashlib.md5(path.read_bytes(), usedforsecurity=False).hexdigest()}  {path.relative_to(root)}\n"
        for path in _files(root)
    )


def _files(root: Path) -> Iterable[Path]:
    files = (path for path in root.rglob("*") if path.is_file() and not path.is_symlink())
    return sorted(path for path in files if "DEBIAN" not in path.parts)
