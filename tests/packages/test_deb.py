"""The .deb: installed by dpkg into a folder as root, used and removed."""

import gzip
import os
import re
import subprocess
from pathlib import Path

import pytest

from tests.packages.programs import ROOT, Program, check_window

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
        command = ["dpkg", f"--root={self.root}", forced, f"--log={log}", "--no-triggers", *words]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stdout + done.stderr

    def files(self) -> set[str]:
        """All files except dpkg's own."""
        found = (path.relative_to(self.root).as_posix() for path in self.root.rglob("*"))
        return {name for name in found if not name.startswith("var")}


@pytest.fixture(scope="module")
def system(tmp_path_factory: pytest.TempPathFactory) -> System:
    return System(tmp_path_factory.mktemp("system"))


def test_it_installs_runs_and_leaves_nothing(system: System, deb: Path, version: str, tmp_path: Path) -> None:
    before = system.files()
    system.dpkg("--install", str(deb))
    installed = system.files() - before
    assert {
        "usr/bin/dps-s",
        f"usr/lib/{NAME}/dps-s",
        f"usr/share/applications/{NAME}.desktop",
        f"usr/share/doc/{NAME}/copyright",
        f"usr/share/icons/hicolor/scalable/apps/{NAME}.svg",
        "usr/share/man/man1/dps-s.1.gz",
        "usr/lib/udev/rules.d/60-dps-s.rules",
        f"usr/share/mime/packages/{NAME}.xml",
        "usr/share/bash-completion/completions/dps-s",
        "usr/share/zsh/vendor-completions/_dps-s",
        "usr/share/fish/vendor_completions.d/dps-s.fish",
    } <= installed
    for side in (16, 22, 24, 32, 48, 64, 128, 256, 512):
        assert f"usr/share/icons/hicolor/{side}x{side}/apps/{NAME}.png" in installed
    program = Program((str(system.root / "usr/bin/dps-s"),), tmp_path / "home")
    assert program.run("--version").stdout == f"DPS-S Configurator {version}\n"
    check_window(program, tmp_path / "evidence")
    system.dpkg("--purge", NAME)
    assert system.files() == before


@pytest.fixture(scope="module")
def tree(deb: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The unpacked content."""
    folder = tmp_path_factory.mktemp("tree")
    subprocess.run(["dpkg-deb", "--extract", str(deb), str(folder)], check=True)
    return folder


def field(deb: Path, name: str) -> str:
    return subprocess.run(["dpkg-deb", "--field", str(deb), name], capture_output=True, text=True, check=True).stdout


def test_it_says_what_it_is(deb: Path, version: str) -> None:
    assert field(deb, "Package").strip() == NAME
    assert field(deb, "Version").strip() == f"{version}-1"


OF_LIBC = frozenset(
    {"ld-linux-x86-64.so.2", "ld-linux-aarch64.so.1", "libc.so.6", "libdl.so.2", "libm.so.6", "libpthread.so.0"}
    | {"libresolv.so.2", "librt.so.1", "libutil.so.1"}
)
FURTHER = {
    "libcrypt.so.1": "libcrypt1",
    "libdrm.so.2": "libdrm2",
    "libgcc_s.so.1": "libgcc-s1",
    "libgthread-2.0.so.0": "libglib2.0-0",
    "libwayland-server.so.0": "libwayland-server0",
    "libxcb.so.1": "libxcb1",
    "libxcb-glx.so.0": "libxcb-glx0",
    "libxcb-randr.so.0": "libxcb-randr0",
    "libxcb-render.so.0": "libxcb-render0",
    "libxcb-shm.so.0": "libxcb-shm0",
    "libxcb-sync.so.1": "libxcb-sync1",
    "libxcb-util.so.1": "libxcb-util1",
    "libxcb-xfixes.so.0": "libxcb-xfixes0",
}
"""Packages of libraries that are not in the tables of qt_libraries.py, because others there depend on them."""


def test_every_library_needed_is_a_dependency(deb: Path, tree: Path, packaging_on_path: None) -> None:
    from linux.elf import shown

    from app.system import qt_libraries

    tables = (*qt_libraries.ALWAYS, *qt_libraries.FOR_X, *qt_libraries.FOR_WAYLAND)
    known = {library.name: library.apt for library in tables} | FURTHER
    folder = tree / "usr/lib" / NAME
    asked = {
        library
        for path, said in shown(folder)
        if path.name != "libqgtk3.so"  # which Qt skips where it does not load
        for library in re.findall(r"^\s+NEEDED\s+(\S+)$", said, re.MULTILINE)
    }
    asked -= OF_LIBC | {path.name for path in folder.rglob("*") if path.is_file()}
    depends = set(re.split(r"[^\w.+-]+", field(deb, "Depends")))
    assert {"libc6", *(known[library] for library in asked)} <= depends
    assert {library.name for library in tables} <= asked, "the program asks for what it does not need"


def test_desktop_entry_and_metadata_are_valid(tree: Path) -> None:
    entry = tree / "usr/share/applications" / f"{NAME}.desktop"
    metainfo = next((tree / "usr/share/metainfo").iterdir())
    for command in (
        ["desktop-file-validate", "--no-hints", str(entry)],
        ["appstreamcli", "validate", "--no-net", str(metainfo)],
        ["appstreamcli", "validate-tree", "--no-net", str(tree)],
    ):
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stdout + done.stderr


def test_the_package_names_a_chinese_font_and_has_the_input_plugins(deb: Path, tree: Path) -> None:
    assert "fonts-wqy-microhei | fonts-noto-cjk" in field(deb, "Recommends")
    plugins = tree / "usr/lib" / NAME / "_internal/PySide6/Qt/plugins/platforminputcontexts"
    names = {path.name for path in plugins.iterdir()}
    assert {"libibusplatforminputcontextplugin.so", "libcomposeplatforminputcontextplugin.so"} <= names


def test_the_completions_know_every_command(tree: Path, packaging_on_path: None) -> None:
    from linux.debian import COMPLETIONS

    from app.cli.commands import ENTRIES

    for place in COMPLETIONS.values():
        script = (tree / place).read_text(encoding="utf-8")
        assert [entry.name for entry in ENTRIES if entry.name not in script] == [], place


def test_files_belong_to_root_and_can_be_read_by_all(deb: Path) -> None:
    listed = subprocess.run(["dpkg-deb", "--contents", str(deb)], capture_output=True, text=True, check=True).stdout
    for line in listed.splitlines():
        rights, owner = line.split()[:2]
        assert owner == "root/root", line
        assert rights in ("drwxr-xr-x", "-rw-r--r--", "lrwxrwxrwx", "-rwxr-xr-x"), line
    programs = {line.split()[5] for line in listed.splitlines() if line.startswith("-rwx")}
    assert programs == {f"./usr/lib/{NAME}/dps-s"}


def test_the_link_leads_to_the_program(tree: Path) -> None:
    link = tree / "usr/bin/dps-s"
    assert not link.readlink().is_absolute()
    assert link.resolve() == (tree / "usr/lib" / NAME / "dps-s").resolve()


def test_the_manual_is_the_one_of_the_checkout(tree: Path) -> None:
    manual = gzip.decompress((tree / "usr/share/man/man1/dps-s.1.gz").read_bytes())
    assert manual == (ROOT / "packaging" / "linux" / "dps-s.1").read_bytes()


def test_the_scripts_do_nothing_to_a_folder(tree: Path, deb: Path, tmp_path: Path) -> None:
    """With DPKG_ROOT no device is changed: udevadm is not called."""
    subprocess.run(["dpkg-deb", "--control", str(deb), str(tmp_path / "control")], check=True)
    tell = tmp_path / "udevadm"
    tell.write_text(f"#!/bin/sh\ntouch {tmp_path}/called\n", encoding="utf-8")
    tell.chmod(0o755)
    variables = {"PATH": f"{tmp_path}:{os.defpath}", "DPKG_ROOT": str(tmp_path)}
    for script, word in (("postinst", "configure"), ("postrm", "remove"), ("postrm", "purge")):
        subprocess.run(["sh", str(tmp_path / "control" / script), word], env=variables, check=True)
    assert not (tmp_path / "called").exists()
