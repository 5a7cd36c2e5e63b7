"""The packages in the folder that DPS_S_DIST names. Without it (an ordinary test run) nothing here is collected."""

import os
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.packages.programs import ROOT, Program
from tests.support.setup_files import PACKAGING

DIST = "DPS_S_DIST"
collect_ignore_glob = [] if DIST in os.environ else ["test_*.py"]
if "DPS_S_INSTALLERS" not in os.environ:
    collect_ignore_glob.append("test_installers.py")
if not sys.platform.startswith("linux"):
    collect_ignore_glob.append("test_deb.py")


@pytest.fixture(scope="session")
def dist() -> Path:
    return Path(os.environ[DIST]).resolve()


@pytest.fixture(scope="session")
def version() -> str:
    """The one version."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    return str(project["version"])


@pytest.fixture(scope="session")
def bundle(dist: Path, version: str) -> Path:
    """The folder of the bundle; of the .app on macOS the one with its programs."""
    if sys.platform == "darwin":
        return dist / "DPS-S Configurator.app" / "Contents" / "MacOS"
    return next(path for path in dist.glob(f"dps-s-configurator-{version}-*") if path.is_dir())


@pytest.fixture
def program(bundle: Path, tmp_path: Path) -> Program:
    """`dps-s` of the bundle, with a home of its own."""
    return Program((str(bundle / ("dps-s.exe" if sys.platform == "win32" else "dps-s")),), tmp_path / "home")


@pytest.fixture(scope="session")
def packaging_on_path() -> Iterator[None]:
    """The files of packaging/ can be imported, as the build does it."""
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(PACKAGING))
        yield


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """The longest begins first: begun last it would be waited for alone."""
    items.sort(key=lambda item: item.name != "test_wheel_and_sdist_install_and_run")
