"""What is said where Qt would end the program: no screen, no libraries, a screen that turns the user away."""

import sys

import pytest

from app.system import qt_libraries, screen
from tests.support.cli_line import run_here

SCREENS = ("DISPLAY", "WAYLAND_DISPLAY", "QT_QPA_PLATFORM", "XDG_SESSION_TYPE")
MISSING = "Missing system libraries:"
COMMAND = "Type: sudo apt-get install"


@pytest.fixture
def lacking(monkeypatch: pytest.MonkeyPatch) -> set[str]:
    """A Debian without a screen; what is put into this set cannot be loaded there."""
    absent: set[str] = set()
    monkeypatch.setattr("sys.platform", "linux")
    for name in SCREENS:
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(screen, "package_manager", lambda: "apt")
    monkeypatch.setattr(screen, "_refuses_x", lambda: False)
    monkeypatch.setattr(qt_libraries, "_loads", lambda soname: soname not in absent)
    return absent


@pytest.mark.parametrize("words", [[], ["gui", "--demo"], ["--port", "x"]])
def test_a_window_without_a_screen_is_one_sentence(
    lacking: set[str], capsys: pytest.CaptureFixture[str], words: list[str]
) -> None:
    assert run_here(capsys, words, 3).err == "No screen: neither DISPLAY nor WAYLAND_DISPLAY is set.\n"


def test_all_that_is_missing_is_named_in_one_command(lacking: set[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("DISPLAY", ":0")
    assert screen.window_obstacle() is None
    lacking |= {"libEGL.so.1", "libxcb-cursor.so.0"}
    said = screen.window_obstacle()
    assert said == f"{MISSING} libEGL.so.1, libxcb-cursor.so.0. {COMMAND} libegl1 libxcb-cursor0"
    monkeypatch.setattr(screen, "package_manager", lambda: None)
    assert (screen.window_obstacle() or "").endswith("libraries: libEGL.so.1, libxcb-cursor.so.0.")
    lacking -= {"libEGL.so.1"}
    monkeypatch.setenv("QT_QPA_PLATFORM", "offscreen")
    assert screen.window_obstacle() is None


def test_qt_that_cannot_be_imported_is_that_sentence_too(
    lacking: set[str], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def fail(_: object) -> int:
        raise ImportError("libEGL.so.1: cannot open shared object file: No such file or directory")

    monkeypatch.setattr("app.__main__._open_window", fail)
    lacking |= {"libEGL.so.1"}
    assert run_here(capsys, ["gui"], 3).err == f"{MISSING} libEGL.so.1. {COMMAND} libegl1\n"
    lacking.clear()
    assert "Unexpected error" in run_here(capsys, ["gui"], 1).err


def test_a_screen_that_turns_the_user_away_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in SCREENS:
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("DISPLAY", "/nowhere:99")
    monkeypatch.setattr(qt_libraries, "_loads", lambda soname: True)
    assert screen.window_obstacle() == "The screen /nowhere:99 does not let this user open a window."


# The system libraries that Qt needs on Linux: which, by which package, and whether they are there


@pytest.mark.parametrize(
    ("release", "package"),
    [
        ('ID=debian\nVERSION_ID="12"\n', "libglib2.0-0"),
        ('ID=debian\nVERSION_ID="13"\n', "libglib2.0-0t64"),
        ("ID=debian\n", "libglib2.0-0t64"),
        ('ID=ubuntu\nID_LIKE=debian\nVERSION_ID="22.04"\n', "libglib2.0-0"),
        ('ID=ubuntu\nID_LIKE=debian\nVERSION_ID="24.04"\n', "libglib2.0-0t64"),
        ('ID=linuxmint\nID_LIKE="ubuntu debian"\nVERSION_ID="21.3"\n', "libglib2.0-0"),
        ('ID=linuxmint\nID_LIKE="ubuntu debian"\nVERSION_ID="22"\n', "libglib2.0-0t64"),
    ],
)
def test_glib_by_its_name_of_the_release(release: str, package: str) -> None:
    assert qt_libraries.has_time_t_64_names(release) == package.endswith("t64")


def test_a_library_is_found_or_missing() -> None:
    absent = qt_libraries.Requirement("libdps-s-absent.so.9", "a", "b", "c", "d")
    soname = {"win32": "kernel32.dll", "darwin": "libSystem.B.dylib"}.get(sys.platform, "libc.so.6")
    present = qt_libraries.Requirement(soname, "libc6", "glibc", "glibc", "glibc")
    assert qt_libraries.missing((present, absent)) == (absent,)


@pytest.mark.parametrize(
    ("environ", "is_screen_wanted", "extra"),
    [
        ({}, True, None),
        ({"DISPLAY": ":0"}, False, None),
        ({"DISPLAY": ":0"}, True, "FOR_X"),
        ({"DISPLAY": ":0", "QT_QPA_PLATFORM": "offscreen"}, True, None),
        ({"WAYLAND_DISPLAY": "wayland-0"}, True, "FOR_WAYLAND"),
        ({"DISPLAY": ":0", "WAYLAND_DISPLAY": "wayland-0"}, True, "FOR_X"),
        (
            {"DISPLAY": ":0", "WAYLAND_DISPLAY": "wayland-0", "XDG_SESSION_TYPE": "wayland"},
            True,
            "FOR_WAYLAND",
        ),
        ({"DISPLAY": ":0", "WAYLAND_DISPLAY": "wayland-0", "QT_QPA_PLATFORM": "xcb"}, True, "FOR_X"),
    ],
)
def test_the_libraries_for_the_screen_that_there_is(
    monkeypatch: pytest.MonkeyPatch,
    environ: dict[str, str],
    is_screen_wanted: bool,
    extra: str | None,
) -> None:
    for variable in ("DISPLAY", "WAYLAND_DISPLAY", "QT_QPA_PLATFORM", "XDG_SESSION_TYPE"):
        monkeypatch.delenv(variable, raising=False)
    for variable, value in environ.items():
        monkeypatch.setenv(variable, value)
    wanted = qt_libraries.wanted_libraries(is_screen_wanted=is_screen_wanted)
    assert wanted == qt_libraries.ALWAYS + (getattr(qt_libraries, extra) if extra else ())
