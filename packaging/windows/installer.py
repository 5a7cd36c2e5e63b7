"""Not run here: written for Windows, never executed by us. The installer, by Inno Setup 6 from installer.iss."""

import os
import shutil
import subprocess
from pathlib import Path

from environment import ROOT, SetupError, say
from release import Release

SCRIPT = ROOT / "packaging" / "windows" / "installer.iss"


def make_installer(release: Release, bundle: Path, dist: Path) -> Path | None:
    """Build it; None, and a sentence, where Inno Setup is not installed. Raises SetupError where it fails."""
    compiler = _compiler()
    if compiler is None:
        say("Inno Setup 6 is not installed here, so there is no installer; the bundle and its .zip are complete.")
        return None
    name = f"{release.bundle_name}-setup"
    command = [str(compiler), "/Qp", f"/DAppVersion={release.version}", f"/DBundle={bundle}", f"/DOutput={dist}"]
    command += [f"/DOutputName={name}", f"/DIcons={ROOT / 'build' / 'package' / 'icons'}", str(SCRIPT)]
    done = subprocess.run(command, capture_output=True, text=True, errors="replace", check=False)
    if done.returncode != 0:
        raise SetupError(f"{done.stdout}{done.stderr}\nInno Setup failed; it says why above.", exit_code=4)
    return dist / f"{name}.exe"


def _compiler() -> Path | None:
    found = shutil.which("ISCC")
    if found is not None:
        return Path(found)
    for variable in ("ProgramFiles(x86)", "ProgramFiles"):
        place = Path(os.environ.get(variable, "")) / "Inno Setup 6" / "ISCC.exe"
        if place.is_file():
            return place
    return None
