"""The installer in a fresh Windows: silent installation, use on a module, and removal."""

import json
import re
import shutil
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.support.processes import run_module
from tests.support.setup_files import registered_endings
from tests.system.windows.conftest import PORT, WindowsProgram

PNG = b"\x89PNG\r\n\x1a\n"
UNINSTALL_S, OPENED_S = 60, 180
SCREEN = ("xvfb-run", "-a", "-s", "-screen 0 1920x1080x24")
_CLASSES = "HKCU\\Software\\Classes"
_KEY = "HKCU\\Software\\Microsoft\\Windows\\CurrentVersion\\Uninstall\\dps-s-configurator"


@pytest.fixture(scope="module")
def fresh() -> Iterator[Path]:
    """A fresh Windows with the setup program and a simulated module on COM5."""
    from wine import PLACE, SOURCE, connect_com_port, new_prefix, shut_down

    prefix = PLACE / "installed"
    shutil.rmtree(prefix, ignore_errors=True)
    prefix.mkdir()
    new_prefix(prefix)
    shutil.copy(next((SOURCE / "dist").glob("*-setup.exe")), prefix / "drive_c" / "setup.exe")
    with run_module("--history", "2", "--cell", "4.1") as module:
        connect_com_port(5, Path(module.port), prefix)
        yield prefix
        shut_down(prefix)


def _wine(prefix: Path, *words: str) -> int:
    from wine import inside

    return inside(["wine", *words], prefix=prefix, limit_s=240).returncode


def _places(prefix: Path) -> tuple[Path, Path, Path]:
    """Folders of the program, its Start menu entry and the user's data."""
    local = prefix / "drive_c" / "users" / "root" / "AppData" / "Local"
    menu = prefix / "drive_c/users/root/AppData/Roaming/Microsoft/Windows/Start Menu/Programs"
    return local / "Programs" / "DPS-S Configurator", menu / "DPS-S Configurator.lnk", local


def _in_windows(prefix: Path, path: Path) -> str:
    return f"C:\\{path.relative_to(prefix / 'drive_c')}".replace("/", "\\")


def _registered_classes(prefix: Path) -> str:
    """The file types in the user's part of the registry."""
    assert _wine(prefix, "reg", "export", _CLASSES, "C:\\classes.reg", "/y") == 0
    return (prefix / "drive_c" / "classes.reg").read_text(encoding="utf-16")


def _files(folder: Path) -> list[Path]:
    return [path for path in folder.rglob("*") if path.is_file()]


def test_it_is_installed_used_and_taken_away(fresh: Path) -> None:
    program, entry, local = _places(fresh)
    # Entries of another program, which have to remain.
    assert _wine(fresh, "reg", "add", f"{_CLASSES}\\.csv\\OpenWithProgids", "/v", "Another.Table", "/f") == 0
    classes = _registered_classes(fresh)
    assert _wine(fresh, "C:\\setup.exe", "/S") == 0
    assert (program / "dps-s-window.exe").is_file()
    assert entry.is_file()
    assert not list(program.rglob("icuuc.dll"))
    dps_s = WindowsProgram((_in_windows(fresh, program / "dps-s.exe"),), prefix=fresh)

    said = json.loads(dps_s.run("read", "--port", PORT, "--json", limit_s=240).stdout)
    assert said["errors"] == {}
    assert said["settings"]["attitude_threshold_deg"] == 60

    checked = dps_s.run("preflight", "--port", PORT, "--enable-triggers", "--report", "C:\\check.pdf", limit_s=240)
    assert checked.returncode in (0, 1), checked.stderr
    report = (fresh / "drive_c" / "check.pdf").read_bytes()
    assert report.startswith(b"%PDF-")
    assert b"/FontFile" in report, "the fonts are embedded"
    assert "INTACT" in dps_s.run("verify", "C:\\check.pdf", limit_s=240).stdout

    _check_window(fresh, program)
    recorded = dps_s.run("record", "C:\\line.mcap", "--port", PORT, "--seconds", "2", limit_s=240)
    assert recorded.returncode == 0, recorded.stderr
    _check_open_command(fresh, local)
    now = _registered_classes(fresh)
    for ending in registered_endings():
        assert f"[HKEY_CURRENT_USER\\Software\\Classes\\{ending}\\OpenWithProgids]" in now

    data = {path for path in _files(local) if program not in path.parents}
    assert any(path.suffix == ".sqlite" or "dps-s" in path.as_posix() for path in data)
    assert _wine(fresh, _in_windows(fresh, program / "uninstall.exe"), "/S") == 0
    ends = time.monotonic() + UNINSTALL_S
    while program.exists() and time.monotonic() < ends:
        time.sleep(0.5)
    assert not program.exists()
    assert not entry.exists()
    assert _wine(fresh, "reg", "query", _KEY) != 0
    assert _registered_classes(fresh) == classes
    assert {path for path in data if "dps-s" in path.as_posix()} <= set(_files(local)), "the user's data stays"


def _check_window(prefix: Path, program: Path) -> None:
    """The window on Qt's windows platform, connected over the COM port."""
    from wine import inside

    window = _in_windows(prefix, program / "dps-s-window.exe")
    words = ["gui", "--port", PORT, "--offscreen-seconds", "20", "--evidence", "C:\\evidence"]
    done = inside([*SCREEN, "wine", window, *words], prefix=prefix, limit_s=300)
    assert done.returncode == 0, done.stdout
    evidence = prefix / "drive_c" / "evidence"
    assert (evidence / "live.png").read_bytes().startswith(PNG)


def _check_open_command(prefix: Path, local: Path) -> None:
    """Starts the command registered for recordings: the window opens one and is then killed.

    Wine itself does not use file types of the user's part of the registry.
    """
    command = _default(prefix, r"DPS-S.Flight\shell\open\command")
    words = [word.replace("%1", "C:\\line.mcap") for word in re.findall(r'"([^"]+)"', command)]

    def is_opened() -> bool:
        return any("line.mcap" in path.read_text(encoding="utf-8") for path in local.rglob("window.ini"))

    assert not is_opened()
    with WindowsProgram(tuple(words), prefix=prefix, screen=SCREEN).running():
        ends = time.monotonic() + OPENED_S
        while not is_opened() and time.monotonic() < ends:
            time.sleep(0.5)
    assert is_opened()


def _default(prefix: Path, key: str) -> str:
    from wine import inside

    said = inside(["wine", "reg", "query", f"{_CLASSES}\\{key}", "/ve"], prefix=prefix, limit_s=60).stdout
    return said.partition("REG_SZ")[2].strip()
