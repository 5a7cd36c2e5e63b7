"""Builds and tests all packages:  python3 packaging/bootstrap.py package

Builds wheel, sdist and bundle with the notices of its parts, on Linux the .deb, on Windows the installer, on macOS the
disk image, and SHA256SUMS, in a new dist/. Then runs tests/system/packages, which install, start and use them.
"""

import argparse
import hashlib
import os
import shutil
import subprocess
import sys
from pathlib import Path

from bundle import make_bundle, make_disk_image, make_installer
from debian import make_deb
from environment import ROOT, SetupError, run, say
from release import DIST, WORK, epoch, refusals


def build(wheel: Path | None = None) -> None:
    """Build everything for this system, or what is built from this wheel. Raises SetupError."""
    for folder in (DIST, WORK):
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
    if wheel is None:
        say("Building wheel and sdist ...")
        wheel = build_wheel(DIST)
    say("Building bundle ...")
    bundle = make_bundle(wheel)
    say("Packing it ...")
    if sys.platform == "darwin":
        make_disk_image(bundle)
    elif sys.platform == "win32":
        shutil.make_archive(str(bundle), "zip", root_dir=DIST, base_dir=bundle.name)
        make_installer(bundle)
    else:
        shutil.make_archive(str(bundle), "gztar", root_dir=DIST, base_dir=bundle.name, owner="root", group="root")
        if shutil.which("dpkg-deb"):
            make_deb(bundle)
    files = sorted(path for path in DIST.iterdir() if path.is_file())
    sums = [f"{hashlib.sha256(path.read_bytes()).hexdigest()}  {path.name}\n" for path in files]
    (DIST / "SHA256SUMS").write_text("".join(sums), encoding="utf-8", newline="\n")
    for path in files:
        say(f"  {path.relative_to(ROOT)}  {path.stat().st_size / 1e6:.1f} MB")


def build_wheel(folder: Path) -> Path:
    """The wheel is built from the sdist, so that untracked files of the checkout do not get into it."""
    command = [sys.executable, "-m", "build", "--no-isolation", "--outdir", str(folder), str(ROOT)]
    run(command, "The wheel could not be built", variables={"SOURCE_DATE_EPOCH": str(epoch())})
    return next(folder.glob("*.whl"))


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(prog="bootstrap.py package", description="Build and test all packages in dist/.")
    parser.add_argument("--only-from", type=Path, metavar="WHEEL", help="build from this, and do not run the tests")
    parser.add_argument("--release", action="store_true", help="build only what may be passed on")
    chosen = parser.parse_args(arguments)
    reasons = refusals() if chosen.release else []
    if reasons:
        print("This cannot be released:", *reasons, sep="\n", file=sys.stderr)
        return 3
    try:
        build(chosen.only_from)
    except SetupError as error:
        print(error, file=sys.stderr)
        return 4
    if chosen.only_from:
        return 0
    variables = {"QT_QPA_PLATFORM": "offscreen", **os.environ, "DPS_S_DIST": str(DIST)}
    command = [sys.executable, "-m", "pytest", "-n", "2", "--dist", "worksteal", "tests/system/packages"]
    return subprocess.run(command, cwd=ROOT, env=variables, check=False).returncode


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
