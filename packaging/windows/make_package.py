"""Builds bundle and installer for Windows on Linux: by the Python for Windows under Wine, and by NSIS."""

import shutil
from pathlib import Path

from environment import ROOT, SetupError, say
from package import build_wheel, write_sums
from release import read_release

from windows import wine
from windows.installer import FILE_TYPES_NAME, SCRIPT, arguments, write_file_types

SOURCE = wine.DRIVE / "source"
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
        folder="/place/prefix/drive_c/source", limit_s=LIMIT_S,
        SOURCE_DATE_EPOCH=str(release.epoch),
    )  # fmt: skip
    wine.shut_down()
    if made.returncode != 0:
        raise SetupError(f"{made.stdout}\nThe bundle could not be built; it says why above.", exit_code=4)
    bundle = next(path for path in (SOURCE / "dist").iterdir() if path.is_dir())
    if list(bundle.rglob("icuuc.dll")):
        raise SetupError("The stub of icuuc.dll got into the bundle.")
    say("Building the installer ...")
    shutil.rmtree(PACKAGES, ignore_errors=True)
    PACKAGES.mkdir()
    target = PACKAGES / f"{bundle.name}-setup.exe"
    icon = SOURCE / "build" / "package" / "icons" / "dps-s-configurator.ico"
    file_types = icon.with_name(FILE_TYPES_NAME)
    write_file_types(file_types)
    words = [
        word.replace(str(wine.PLACE), "/place").replace(str(SCRIPT), f"/checkout/{SCRIPT.relative_to(ROOT)}")
        for word in arguments(release, bundle, target, icon, file_types)
    ]
    done = wine.inside(["makensis", "-DTARGET=amd64-unicode", *words], limit_s=LIMIT_S)
    if done.returncode != 0 or not target.is_file():
        raise SetupError(f"{done.stdout}\nNSIS failed; it says why above.", exit_code=4)
    for path in bundle.parent.iterdir():
        if path.is_file():
            shutil.copy(path, PACKAGES)
    write_sums(PACKAGES)
    return target
