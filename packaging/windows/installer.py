"""The installer for Windows, by NSIS from installer.nsi; NSIS runs on Windows and on Linux."""

import shutil
import subprocess
from pathlib import Path

from environment import SetupError, say
from release import Release

SCRIPT = Path(__file__).with_name("installer.nsi")


def make_installer(release: Release, bundle: Path, dist: Path, icons: Path) -> Path | None:
    """Build it; None, and a sentence, where NSIS is not installed. Raises SetupError where it fails."""
    compiler = shutil.which("makensis")
    if compiler is None:
        say("NSIS is not installed here, so there is no installer; the bundle and its .zip are complete.")
        return None
    target = dist / f"{bundle.name}-setup.exe"
    done = subprocess.run(
        [compiler, *arguments(release, bundle, target, icons / "dps-s-configurator.ico")],
        capture_output=True,
        text=True,
        errors="replace",
        check=False,
    )
    if done.returncode != 0:
        raise SetupError(f"{done.stdout}{done.stderr}\nNSIS failed; it says why above.", exit_code=4)
    return target


def arguments(release: Release, bundle: Path, target: Path, icon: Path) -> list[str]:
    """What makensis is told."""
    numbers = [int("".join(filter(str.isdigit, part)) or 0) for part in release.version.split("+")[0].split(".")]
    size = sum(path.stat().st_size for path in bundle.rglob("*") if path.is_file())
    defined = {
        "VERSION": release.version,
        "NUMBERS": ".".join(map(str, [*numbers, 0, 0, 0, 0][:4])),
        "BUNDLE": str(bundle),
        "OUTPUT": str(target),
        "ICON": str(icon),
        "SIZE_KB": str(size // 1024),
    }
    return ["-V2", "-WX", *(f"-D{name}={value}" for name, value in defined.items()), str(SCRIPT)]
