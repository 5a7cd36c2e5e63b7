"""What is said where Qt would end the program: no screen, no libraries, a screen that turns the user away."""

from pathlib import Path

import pytest

from app.__main__ import main
from app.system import qt_libraries, screen

SCREENS = ("DISPLAY", "WAYLAND_DISPLAY", "QT_QPA_PLATFORM", "XDG_SESSION_TYPE")
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
    assert main(words) == 3
    assert capsys.readouterr().err == "There is no screen here: neither DISPLAY nor WAYLAND_DISPLAY is set.\n"


def test_all_that_is_missing_is_named_in_one_command(lacking: set[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("DISPLAY", ":0")
    assert screen.window_obstacle() is None
    lacking |= {"libEGL.so.1"}
    assert screen.window_obstacle() is None, "importing Qt will tell whether it is missed"
    lacking |= {"libxcb-cursor.so.0"}
    said = screen.window_obstacle()
    assert said == f"Qt needs system libraries that are not here. {COMMAND} libegl1 libxcb-cursor0"
    monkeypatch.setattr(screen, "package_manager", lambda: None)
    assert (screen.window_obstacle() or "").endswith("here: libEGL.so.1, libxcb-cursor.so.0.")
    monkeypatch.setenv("QT_QPA_PLATFORM", "offscreen")
    assert screen.window_obstacle() is None


def test_a_bundle_asks_only_for_what_it_takes_from_the_system(
    lacking: set[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    (tmp_path / screen.ASKED).write_text("libEGL.so.1\nlibc.so.6\n", encoding="utf-8")
    monkeypatch.setattr("sys._MEIPASS", str(tmp_path), raising=False)
    monkeypatch.setenv("DISPLAY", ":0")
    lacking |= {"libxcb-cursor.so.0"}
    assert screen.window_obstacle() is None
    lacking |= {"libEGL.so.1"}
    assert (screen.window_obstacle() or "").endswith(f"{COMMAND} libegl1")


def test_qt_that_cannot_be_imported_is_that_sentence_too(
    lacking: set[str], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def fail(_: object) -> int:
        raise ImportError("libEGL.so.1: cannot open shared object file: No such file or directory")

    monkeypatch.setattr("app.__main__._open_window", fail)
    lacking |= {"libEGL.so.1"}
    assert main(["gui"]) == 3
    assert capsys.readouterr().err == f"Qt needs system libraries that are not here. {COMMAND} libegl1\n"
    lacking.clear()
    assert main(["gui"]) == 1
    assert "Unexpected error" in capsys.readouterr().err


def test_a_screen_that_turns_the_user_away_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in SCREENS:
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("DISPLAY", "/nowhere:99")
    monkeypatch.setattr(qt_libraries, "_loads", lambda soname: True)
    assert screen.window_obstacle() == "The screen /nowhere:99 does not let this user open a window."
