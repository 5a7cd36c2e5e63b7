"""The .deb: installed by dpkg into a folder as root, over an older version, used and removed."""

import re
import subprocess
from pathlib import Path

import pytest

from app.system import libraries as qt_libraries
from tests.system.packages.programs import Program, check_window, has_record, leave_a_record

NAME = "dps-s-configurator"


@pytest.fixture(scope="session")
def deb(dist: Path) -> Path:
    return next(dist.glob("*.deb"))


class System:
    """A root folder with an empty package database."""

    def __init__(self, root: Path) -> None:
        self.root = root
        database = root / "var" / "lib" / "dpkg"
        for folder in ("info", "updates", "triggers"):
            (database / folder).mkdir(parents=True)
        (database / "status").touch()

    def dpkg(self, *words: str) -> None:
        """Ignores dependencies, which are not in that folder; scripts run outside of it with DPKG_ROOT."""
        forced = "--force-depends,script-chrootless,not-root,bad-path"
        log = self.root / "var" / "lib" / "dpkg" / "log"
        called("dpkg", f"--root={self.root}", forced, f"--log={log}", "--no-triggers", *words)

    def files(self) -> set[str]:
        """All files except dpkg's own."""
        found = (path.relative_to(self.root).as_posix() for path in self.root.rglob("*"))
        return {name for name in found if not name.startswith("var")}


def called(*command: str) -> str:
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def of_version(deb: Path, older: str, folder: Path) -> Path:
    """The same package as another version."""
    called("dpkg-deb", "--raw-extract", str(deb), str(folder / "raw"))
    control = folder / "raw" / "DEBIAN" / "control"
    text = re.sub(r"(?m)^Version: .*$", f"Version: {older}", control.read_text(encoding="utf-8"))
    control.write_text(text, encoding="utf-8")
    (folder / "raw/usr/lib" / NAME / "_internal/of_the_older.txt").touch()
    target = folder / "older.deb"
    called("dpkg-deb", "--root-owner-group", "-Znone", "--build", str(folder / "raw"), str(target))
    return target


def test_it_is_installed_over_an_older_version_runs_and_leaves_nothing(deb: Path, version: str, tmp_path: Path) -> None:
    system = System(tmp_path / "system")
    program = Program((str(system.root / "usr/bin/dps-s"),), tmp_path / "home")
    before = system.files()
    system.dpkg("--install", str(of_version(deb, "0.0.9-1", tmp_path)))
    leave_a_record(program, "M-07")
    system.dpkg("--install", str(deb))
    assert has_record(program, "M-07")
    assert {
        "usr/bin/dps-s",
        f"usr/share/applications/{NAME}.desktop",
        f"usr/share/doc/{NAME}/changelog.Debian.gz",
        f"usr/share/icons/hicolor/512x512/apps/{NAME}.png",
        "usr/share/man/man1/dps-s.1.gz",
        "usr/lib/udev/rules.d/60-dps-s.rules",
        f"usr/share/mime/packages/{NAME}.xml",
        "usr/share/bash-completion/completions/dps-s",
        "usr/share/zsh/vendor-completions/_dps-s",
    } <= system.files()
    assert not [name for name in system.files() if "of_the_older" in name]
    assert program.run("--version").stdout == f"DPS-S Configurator {version}\n"
    check_window(program, tmp_path / "evidence")
    system.dpkg("--purge", NAME)
    assert system.files() == before
    assert any((tmp_path / "home").rglob("*.sqlite*")), "the user's data stays"


@pytest.fixture(scope="module")
def tree(deb: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The unpacked content."""
    folder = tmp_path_factory.mktemp("tree")
    called("dpkg-deb", "--extract", str(deb), str(folder))
    return folder


OF_LIBC = re.compile(r"ld-linux.*|lib(c|dl|m|pthread|resolv|rt|util)\.so\.\d")
FURTHER = {
    "libX11.so.6": "libx11-6",
    "libcrypt.so.1": "libcrypt1",
    "libdrm.so.2": "libdrm2",
    "libfreetype.so.6": "libfreetype6",
    "libgcc_s.so.1": "libgcc-s1",
    "libgthread-2.0.so.0": "libglib2.0-0",
    "libstdc++.so.6": "libstdc++6",
    "libwayland-client.so.0": "libwayland-client0",
    "libwayland-cursor.so.0": "libwayland-cursor0",
    "libwayland-egl.so.1": "libwayland-egl1",
    "libxcb.so.1": "libxcb1",
    "libxcb-glx.so.0": "libxcb-glx0",
    "libxcb-image.so.0": "libxcb-image0",
    "libxcb-randr.so.0": "libxcb-randr0",
    "libxcb-render.so.0": "libxcb-render0",
    "libxcb-render-util.so.0": "libxcb-render-util0",
    "libxcb-shm.so.0": "libxcb-shm0",
    "libxcb-sync.so.1": "libxcb-sync1",
    "libxcb-util.so.1": "libxcb-util1",
    "libxcb-xfixes.so.0": "libxcb-xfixes0",
    "libxcb-xkb.so.1": "libxcb-xkb1",
    "libzstd.so.1": "libzstd1",
}
"""Packages of libraries that `app/system/libraries.py` does not name, because others there depend on them."""


def test_every_library_needed_is_a_dependency(deb: Path, tree: Path) -> None:
    known = qt_libraries.ALWAYS | qt_libraries.FOR_X | FURTHER
    folder = tree / "usr/lib" / NAME
    brought = {path.name for path in folder.rglob("*") if path.is_file()}
    asked = set()
    for path in folder.rglob("*"):
        is_library = path.is_file() and not path.is_symlink() and (".so" in path.name or path.name == "dps-s")
        if is_library and path.name != "libqgtk3.so":  # which Qt skips where it does not load
            asked |= set(re.findall(r"(?m)^\s+NEEDED\s+(\S+)$", called("objdump", "-p", str(path))))
    asked = {library for library in asked - brought if not OF_LIBC.fullmatch(library)}
    depends = set(re.split(r"[^\w.+-]+", called("dpkg-deb", "--field", str(deb), "Depends")))
    assert {"libc6", *(known[library] for library in asked)} <= depends


def test_desktop_entry_and_metadata_are_valid(tree: Path) -> None:
    called("desktop-file-validate", "--no-hints", str(tree / "usr/share/applications" / f"{NAME}.desktop"))
    called("appstreamcli", "validate", "--no-net", str(next((tree / "usr/share/metainfo").iterdir())))
    called("appstreamcli", "validate-tree", "--no-net", str(tree))


def test_files_belong_to_root_and_can_be_read_by_all(deb: Path) -> None:
    for line in called("dpkg-deb", "--contents", str(deb)).splitlines():
        rights, owner, *_, name = line.split()
        assert owner == "root/root", line
        is_program = name == f"./usr/lib/{NAME}/dps-s"
        assert rights in (["-rwxr-xr-x"] if is_program else ["drwxr-xr-x", "-rw-r--r--", "lrwxrwxrwx"]), line


def test_the_scripts_do_nothing_to_a_folder(deb: Path, tmp_path: Path) -> None:
    """With DPKG_ROOT no device is changed: udevadm is not called."""
    called("dpkg-deb", "--control", str(deb), str(tmp_path / "control"))
    tell = tmp_path / "udevadm"
    tell.write_text(f"#!/bin/sh\ntouch {tmp_path}/called\n", encoding="utf-8")
    tell.chmod(0o755)
    variables = {"PATH": f"{tmp_path}:/usr/bin:/bin", "DPKG_ROOT": str(tmp_path)}
    for script, word in (("postinst", "configure"), ("postrm", "remove"), ("postrm", "purge")):
        subprocess.run(["sh", str(tmp_path / "control" / script), word], env=variables, check=True)
    assert not (tmp_path / "called").exists()
