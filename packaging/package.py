"""Builds and tests all packages:  python3 packaging/bootstrap.py package

Builds wheel, sdist and bundle, on Linux the .deb, on Windows the installer if NSIS is installed, on macOS the disk
image, and SHA256SUMS, in a new dist/. Then runs tests/packages, which install, start and use them.
"""

import argparse
import hashlib
import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from bundle import make_bundle, pack, write_tar
from environment import ROOT, SetupError, run, say
from release import Release, read_release, refusals

DIST = ROOT / "dist"
WORK = ROOT / "build" / "package"
SUMS = "SHA256SUMS"


def build(wheel: Path | None = None) -> None:
    """Build everything for this system, or what is built from this wheel. Raises SetupError."""
    release = read_release()
    for folder in (DIST, WORK):
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
    if wheel is None:
        say("Building wheel and sdist ...")
        wheel = build_wheel(release, DIST)
    say("Building bundle ...")
    bundle = make_bundle(release, wheel, work=WORK, dist=DIST)
    say("Packing it ...")
    pack(bundle, release)
    if sys.platform.startswith("linux"):
        from linux.debian import make_deb

        say("Building .deb ...")
        make_deb(release, bundle, work=WORK, dist=DIST)
    elif sys.platform == "win32":
        from windows.installer import make_installer

        say("Building installer ...")
        make_installer(release, bundle, DIST, WORK / "icons")
    write_sums(DIST)


def build_wheel(release: Release, dist: Path) -> Path:
    """The wheel is built from the sdist, so that untracked files of the checkout do not get into it."""
    command = [sys.executable, "-m", "build", "--no-isolation", "--outdir", str(dist), str(ROOT)]
    run(command, "The wheel could not be built", variables={"SOURCE_DATE_EPOCH": str(release.epoch)})
    _settle_sdist(next(dist.glob("*.tar.gz")), release)
    return next(dist.glob("*.whl"))


def _settle_sdist(sdist: Path, release: Release) -> None:
    """Pack it again without the time and the user's name, which setuptools writes into it."""
    with tempfile.TemporaryDirectory() as folder:
        shutil.unpack_archive(sdist, folder)  # without a filter, which Python has only since 3.11.4
        write_tar(sdist, next(Path(folder).iterdir()), release.epoch)


def write_sums(dist: Path) -> None:
    """Write the sums for `sha256sum --check`."""
    lines = [
        f"{hashlib.sha256(path.read_bytes()).hexdigest()}  {path.name}\n"
        for path in sorted(dist.iterdir())
        if path.is_file() and path.name != SUMS
    ]
    (dist / SUMS).write_text("".join(lines), encoding="utf-8", newline="\n")


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(prog="bootstrap.py package", description="Build and test all packages in dist/.")
    part = parser.add_mutually_exclusive_group()
    part.add_argument("--only-build", action="store_true", help="do not run their tests")
    part.add_argument("--only-from", type=Path, metavar="WHEEL", help="build from this wheel, and do not run the tests")
    part.add_argument("--only-test", action="store_true", help="test what was built before")
    parser.add_argument("--release", action="store_true", help="build only what may be passed on")
    parser.add_argument("--installers", action="store_true", help="install the wheel by pipx and by uv, too")
    chosen = parser.parse_args(arguments)
    reasons = refusals() if chosen.release else []
    if reasons:
        print("\n".join(["This cannot be released:", *reasons]), file=sys.stderr)
        return 3
    started = time.monotonic()
    try:
        if not chosen.only_test:
            build(chosen.only_from)
    except SetupError as error:
        print(error, file=sys.stderr)
        return error.exit_code
    for path in sorted(DIST.iterdir()):
        say(f"  {path.relative_to(ROOT)}" + (f"  {path.stat().st_size / 1e6:.1f} MB" if path.is_file() else "/"))
    say(f"Built in {time.monotonic() - started:.0f} s.")
    if chosen.only_build or chosen.only_from:
        return 0
    variables = {"QT_QPA_PLATFORM": "offscreen", **os.environ, "DPS_S_DIST": str(DIST)}
    if chosen.installers:
        variables["DPS_S_INSTALLERS"] = "1"
    command = [sys.executable, "-m", "pytest", "-n", "2", "--dist", "worksteal", "tests/packages"]
    return subprocess.run(command, cwd=ROOT, env=variables, check=False).returncode


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
