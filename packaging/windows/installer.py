"""Builds the installer for Windows with NSIS, which runs on Windows and Linux, from installer.nsi."""

import shutil
from pathlib import Path

from environment import run, say
from release import Release


def make_installer(release: Release, bundle: Path, dist: Path, icons: Path) -> None:
    """Build it if NSIS is installed. Raises SetupError if it fails."""
    compiler = shutil.which("makensis")
    if compiler is None:
        say("NSIS is not installed here, so there is no installer; the bundle and its .zip are complete.")
    else:
        run([compiler, *arguments(release, bundle, dist, icons)], "NSIS failed")


def arguments(release: Release, bundle: Path, dist: Path, icons: Path) -> list[str]:
    size = sum(path.stat().st_size for path in bundle.rglob("*") if path.is_file())
    defined = {
        "VERSION": release.version,
        "NUMBERS": ".".join(map(str, release.numbers)),
        "BUNDLE": bundle,
        "OUTPUT": dist / f"{bundle.name}-setup.exe",
        "ICON": icons / "dps-s-configurator.ico",
        "SIZE_KB": size // 1024,
    }
    script = Path(__file__).with_name("installer.nsi")
    return [
        "-V2",
        "-WX",
        "-INPUTCHARSET",
        "UTF8",
        *(f"-D{name}={value}" for name, value in defined.items()),
        str(script),
    ]
