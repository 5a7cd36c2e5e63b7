"""Wheel and sdist, installed by pip into an empty environment, used, and put over an older version."""

import hashlib
import os
import shutil
import subprocess
import sys
import tarfile
import zipfile
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.system.packages.programs import (
    LONGEST_S,
    ROOT,
    Program,
    check_reading,
    check_window,
    has_record,
    leave_a_record,
)

LOCK = ROOT / "packaging" / "lock.txt"
ENTRY = ROOT / "packaging" / "entry"


def pip(python: Path, *words: str) -> str:
    """The checkout's pip, working on another environment, with the index of its settings."""
    variables = {**os.environ, "PIP_DISABLE_PIP_VERSION_CHECK": "1", "PIP_USER": "0"}
    command = [sys.executable, "-m", "pip", "--python", str(python), *words]
    done = subprocess.run(command, env=variables, capture_output=True, text=True, timeout=5 * LONGEST_S, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.fixture
def environment(tmp_path: Path) -> Iterator[Path]:
    """The folder of executables of an empty environment."""
    place = tmp_path / "environment"
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", str(place)], check=True)
    yield place / ("Scripts" if os.name == "nt" else "bin")
    shutil.rmtree(place, ignore_errors=True)


def of_version(wheel: Path, version: str, older: str, folder: Path) -> Path:
    """The same wheel as another version."""
    target = folder / wheel.name.replace(version, older)
    with zipfile.ZipFile(wheel) as source, zipfile.ZipFile(target, "w") as made:
        for name in source.namelist():
            content = source.read(name)
            if name.endswith((".dist-info/METADATA", ".dist-info/RECORD")):
                content = content.replace(version.encode(), older.encode(), -1)
            made.writestr(name.replace(f"-{version}.", f"-{older}."), content)
    return target


def test_it_is_installed_over_an_older_version_used_and_removed(
    environment: Path, dist: Path, version: str, tmp_path: Path
) -> None:
    """The older wheel leaves a record, which the newer one finds; then the sdist takes its place."""
    python = environment / ("python.exe" if os.name == "nt" else "python")
    dps_s = environment / ("dps-s.exe" if os.name == "nt" else "dps-s")
    wheel, sdist = next(dist.glob("*.whl")), next(dist.glob("dps_s_configurator-*.tar.gz"))
    program = Program((str(dps_s),), tmp_path / "home")
    older = of_version(wheel, version, "0.0.9", tmp_path)
    # The versions of the lock, which were tested, instead of the newest.
    pip(python, "install", "--quiet", "--no-compile", "--constraint", str(LOCK), str(older))
    check_version(program, "0.0.9")
    leave_a_record(program, "M-07")
    pip(python, "install", "--quiet", "--no-compile", "--constraint", str(LOCK), str(wheel))
    check_version(program, version)
    assert has_record(program, "M-07")
    check_reading(program)
    check_window(program, tmp_path / "evidence")
    assert pip(python, "check").strip() == "No broken requirements found."
    pip(python, "uninstall", "--quiet", "--yes", "dps-s-configurator")
    assert not dps_s.exists()
    pip(python, "install", "--quiet", "--no-deps", "--no-compile", str(sdist))
    check_version(program, version)
    assert has_record(program, "M-07")


def check_version(program: Program, version: str) -> None:
    done = program.run("--version")
    assert (done.returncode, done.stdout) == (0, f"DPS-S Configurator {version}\n")


def test_both_hold_the_same_program(dist: Path) -> None:
    """The wheel contains exactly the files of the checkout's packages; the sdist contains all."""
    places = {
        path: path.relative_to(top.parent).as_posix()
        for top in (ROOT / "app", ROOT / "protocol", ROOT / "ui", ENTRY / "dps_s_configurator")
        for path in top.rglob("*")
        if path.is_file() and "__pycache__" not in path.parts
    }
    with zipfile.ZipFile(next(dist.glob("*.whl"))) as wheel:
        names = set(wheel.namelist())
    assert {name for name in names if not name.startswith("dps_s_configurator-")} == set(places.values())
    assert {name.partition(".data/data/")[2] for name in names if ".data/" in name} == {
        "share/applications/dps-s-configurator.desktop",
        "share/icons/hicolor/scalable/apps/dps-s-configurator.svg",
        "share/man/man1/dps-s.1",
    }
    with tarfile.open(next(dist.glob("dps_s_configurator-*.tar.gz"))) as sdist:
        in_sdist = {name.partition("/")[2] for name in sdist.getnames()}
    assert {path.relative_to(ROOT).as_posix() for path in places} <= in_sdist
    assert {"pyproject.toml", "README.md", "LICENSE", "packaging/bootstrap.py", "tests/conftest.py"} <= in_sdist


def test_every_file_has_its_sum(dist: Path) -> None:
    lines = (dist / "SHA256SUMS").read_text(encoding="utf-8").splitlines()
    stated = {name: digest for digest, _, name in (line.partition("  ") for line in lines)}
    files = {path.name: path for path in dist.iterdir() if path.is_file() and path.name != "SHA256SUMS"}
    assert stated == {name: hashlib.sha256(path.read_bytes()).hexdigest() for name, path in files.items()}
