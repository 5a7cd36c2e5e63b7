"""What is said where Qt would end the program: no screen, no libraries, a screen that turns the user away."""

from types import SimpleNamespace

import pytest

from app.system import libraries as qt_libraries
from app.system import libraries as screen
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
    monkeypatch.setattr("shutil.which", lambda name: f"/usr/bin/{name}")

    def load(name: str) -> None:
        if name in absent:
            raise OSError(name)

    monkeypatch.setattr(qt_libraries, "ctypes", SimpleNamespace(CDLL=load))
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
    monkeypatch.setattr("shutil.which", lambda name: None)
    assert (screen.window_obstacle() or "").endswith("libraries: libEGL.so.1, libxcb-cursor.so.0.")
    lacking -= {"libEGL.so.1"}
    monkeypatch.setenv("QT_QPA_PLATFORM", "offscreen")
    assert screen.window_obstacle() is None


def test_qt_that_cannot_be_imported_is_that_sentence_too(
    lacking: set[str], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def fail(_: object) -> int:
        raise ImportError("libEGL.so.1: cannot open shared object file: No such file or directory")

    monkeypatch.setattr("app.cli.gui.run", fail)
    lacking |= {"libEGL.so.1"}
    assert run_here(capsys, ["gui"], 1).err == f"{MISSING} libEGL.so.1. {COMMAND} libegl1\n"
    lacking.clear()
    assert "Unexpected error" in run_here(capsys, ["gui"], 1).err


# The system libraries that Qt needs on Linux: which, and whether they are there
