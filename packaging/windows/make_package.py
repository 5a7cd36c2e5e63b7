"""Builds bundle and installer for Windows on Linux: by the Python for Windows under Wine, and by NSIS."""

import shutil
from pathlib import Path

from environment import SetupError, say
from package import build_wheel, write_sums
from release import read_release

from windows import wine
from windows.installer import arguments

PACKAGES = wine.PLACE / "packages"
LIMIT_S = 1800


def make_package() -> Path:
    """Build everything in `PACKAGES`; returns the installer. Raises SetupError."""
    release = read_release()
    wine.copy_source()
    say("Building the wheel ...")
    shutil.rmtree(wine.PLACE / "wheel", ignore_errors=True)
    wheel = shutil.copy(build_wheel(release, wine.PLACE / "wheel"), wine.DRIVE)
    say("Building the bundle on the Python for Windows ...")
    made = wine.inside(
        ["wine", wine.PYTHON, "packaging/package.py", "--only-from", f"C:\\{Path(wheel).name}"],
        folder=wine.SOURCE, limit_s=LIMIT_S, SOURCE_DATE_EPOCH=str(release.epoch),
    )  # fmt: skip
    wine.shut_down()
    if made.returncode != 0:
        raise SetupError(f"{made.stdout}\nThe bundle could not be built; it says why above.", exit_code=4)
    bundle = next(path for path in (wine.SOURCE / "dist").iterdir() if path.is_dir())
    if list(bundle.rglob("icuuc.dll")):
        raise SetupError("The stub of icuuc.dll got into the bundle.")
    say("Building the installer ...")
    shutil.rmtree(PACKAGES, ignore_errors=True)
    PACKAGES.mkdir()
    words = arguments(release, bundle, PACKAGES, wine.SOURCE / "build" / "package" / "icons")
    done = wine.inside(["makensis", "-DTARGET=amd64-unicode", *words], limit_s=LIMIT_S)
    target = next(PACKAGES.glob("*-setup.exe"), None)
    if done.returncode != 0 or target is None:
        raise SetupError(f"{done.stdout}\nNSIS failed; it says why above.", exit_code=4)
    for path in bundle.parent.iterdir():
        if path.is_file():
            shutil.copy(path, PACKAGES)
    write_sums(PACKAGES)
    return target
