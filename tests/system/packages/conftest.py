"""Uses the packages in the folder DPS_S_DIST; without it nothing is collected."""

import os
import sys
import tomllib
from pathlib import Path

import pytest

from tests.system.packages.programs import ROOT, Program

DIST = "DPS_S_DIST"
collect_ignore_glob = [] if DIST in os.environ else ["test_*.py"]
if not sys.platform.startswith("linux"):
    collect_ignore_glob.append("test_deb.py")


@pytest.fixture(scope="session")
def dist() -> Path:
    return Path(os.environ[DIST]).resolve()


@pytest.fixture(scope="session")
def version() -> str:
    """Version of the packages."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    return str(project["version"])


@pytest.fixture(scope="session")
def bundle(dist: Path, version: str) -> Path:
    """The folder of the bundle; on macOS that of the executables in the .app."""
    if sys.platform == "darwin":
        return dist / "DPS-S Configurator.app" / "Contents" / "MacOS"
    return next(path for path in dist.glob(f"dps-s-configurator-{version}-*") if path.is_dir())


@pytest.fixture
def program(bundle: Path, tmp_path: Path) -> Program:
    """`dps-s` of the bundle with its own home folder."""
    return Program((str(bundle / ("dps-s.exe" if sys.platform == "win32" else "dps-s")),), tmp_path / "home")
