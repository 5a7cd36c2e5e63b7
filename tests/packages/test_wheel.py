"""Wheel and sdist, each installed by pip into an empty environment and used; what dist/ holds."""

import hashlib
import os
import re
import shutil
import subprocess
import sys
import tarfile
import zipfile
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.packages.programs import LONGEST_S, ROOT, Program, check_reading, check_window

LOCK = ROOT / "packaging" / "lock.txt"
INSTALLING_S = 5 * LONGEST_S


def pip(python: Path, *words: str) -> str:
    """The checkout's pip, working on another environment, with the index of its settings."""
    variables = {**os.environ, "PIP_DISABLE_PIP_VERSION_CHECK": "1", "PIP_USER": "0"}
    command = [sys.executable, "-m", "pip", "--python", str(python), *words]
    done = subprocess.run(command, env=variables, capture_output=True, text=True, timeout=INSTALLING_S, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.fixture
def environment(tmp_path: Path) -> Iterator[Path]:
    """The folder of executables of an empty environment."""
    place = tmp_path / "environment"
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", str(place)], check=True)
    yield place / ("Scripts" if os.name == "nt" else "bin")
    shutil.rmtree(place, ignore_errors=True)


def test_wheel_and_sdist_install_and_run(environment: Path, dist: Path, version: str, tmp_path: Path) -> None:
    """The wheel with all that it asks for; then the sdist in its place, which holds the same, as another test tells."""
    python = environment / ("python.exe" if os.name == "nt" else "python")
    dps_s = environment / ("dps-s.exe" if os.name == "nt" else "dps-s")
    wheel, sdist = next(dist.glob("*.whl")), next(dist.glob("dps_s_configurator-*.tar.gz"))
    program = Program((str(dps_s),), tmp_path / "home")
    # The versions of the lock, which were tested, instead of the newest.
    pip(python, "install", "--quiet", "--no-compile", "--constraint", str(LOCK), str(wheel))
    check_version(program, version)
    check_reading(program)
    check_window(program, tmp_path / "evidence")
    assert pip(python, "check").strip() == "No broken requirements found."
    pip(python, "uninstall", "--quiet", "--yes", "dps-s-configurator")
    assert not dps_s.exists()
    pip(python, "install", "--quiet", "--no-deps", "--no-compile", str(sdist))
    check_version(program, version)


def check_version(program: Program, version: str) -> None:
    done = program.run("--version")
    assert (done.returncode, done.stdout) == (0, f"DPS-S Configurator {version}\n")


def test_both_hold_the_same_program(dist: Path) -> None:
    """The wheel contains exactly the modules and pictures of the checkout's packages; the sdist contains all."""
    tops = ("app", "protocol", "ui")
    ours = {
        path.relative_to(ROOT).as_posix()
        for top in tops
        for path in (ROOT / top).rglob("*")
        if path.is_file() and "__pycache__" not in path.parts
    }
    with zipfile.ZipFile(next(dist.glob("*.whl"))) as wheel:
        names = set(wheel.namelist())
    in_wheel = {name for name in names if not name.startswith("dps_s_configurator-")}
    shared = {name.partition(".data/data/")[2] for name in names if ".data/" in name}
    assert shared == {
        "share/applications/dps-s-configurator.desktop",
        "share/icons/hicolor/scalable/apps/dps-s-configurator.svg",
        "share/man/man1/dps-s.1",
    }
    with tarfile.open(next(dist.glob("dps_s_configurator-*.tar.gz"))) as sdist:
        in_sdist = {name.partition("/")[2] for name in sdist.getnames()}
    assert in_wheel == ours
    assert ours <= in_sdist
    assert {"pyproject.toml", "README.md", "LICENSE", "CHANGELOG.md", "packaging/bootstrap.py"} <= in_sdist
    assert "tests/conftest.py" in in_sdist


# dist/


def test_every_file_has_its_sum(dist: Path) -> None:
    lines = (dist / "SHA256SUMS").read_text(encoding="utf-8").splitlines()
    stated = {name: digest for digest, _, name in (line.partition("  ") for line in lines)}
    files = {path.name: path for path in dist.iterdir() if path.is_file() and path.name != "SHA256SUMS"}
    assert stated == {name: hashlib.sha256(path.read_bytes()).hexdigest() for name, path in files.items()}


def test_every_package_is_there_with_the_version(dist: Path, version: str) -> None:
    wanted = [rf"dps_s_configurator-{version}-py3-none-any\.whl", rf"dps_s_configurator-{version}\.tar\.gz"]
    bundle = rf"dps-s-configurator-{version}-\w+-\w+"
    wanted += {
        "linux": [bundle, rf"{bundle}\.tar\.gz", rf"dps-s-configurator_{version}-1_\w+\.deb"],
        "win32": [bundle, rf"{bundle}\.zip"],
        "darwin": [r"DPS-S Configurator\.app", rf"{bundle}\.dmg"],
    }[sys.platform]
    wanted += [rf"{bundle}\.cdx\.json", "SHA256SUMS"]
    names = sorted(path.name for path in dist.iterdir() if not path.name.endswith("-setup.exe"))
    assert len(names) == len(wanted)
    for pattern in wanted:
        assert any(re.fullmatch(pattern, name) for name in names), pattern
