"""The packaged program: what it says where Qt would abort, and the library path of programs that it starts."""

import os
import sys
from pathlib import Path

import pytest

from app import frozen
from app.system import qt_libraries


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["read", "--port", "x"], None),
        (["--version"], None),
        (["gui", "--help"], None),
        ([], "There is no screen here"),
        (["--port", "x"], "There is no screen here"),
        (["gui", "--demo"], "There is no screen here"),
    ],
)
def test_a_window_without_a_screen_is_one_sentence(
    monkeypatch: pytest.MonkeyPatch, words: list[str], sentence: str | None
) -> None:
    monkeypatch.setattr("sys.platform", "linux")
    for name in ("DISPLAY", "WAYLAND_DISPLAY", "QT_QPA_PLATFORM"):
        monkeypatch.delenv(name, raising=False)
    said = frozen.what_qt_lacks(words)
    assert said is None if sentence is None else (said or "").startswith(sentence)


def test_missing_libraries_are_named_with_what_to_type(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    (tmp_path / "system-libraries.txt").write_text("libxcb-cursor.so.0\nlibc.so.6\n", encoding="utf-8")
    monkeypatch.setattr("sys.platform", "linux")
    monkeypatch.setattr("sys._MEIPASS", str(tmp_path), raising=False)
    monkeypatch.setenv("DISPLAY", ":0")
    monkeypatch.setenv("QT_QPA_PLATFORM", "xcb")
    monkeypatch.setattr(qt_libraries, "package_manager", lambda: "apt")
    monkeypatch.setattr(qt_libraries, "_loads", lambda soname: False)
    said = frozen.what_qt_lacks(["gui"])
    assert said == "Qt needs system libraries that are not here. Type: sudo apt-get install libxcb-cursor0"
    monkeypatch.setattr(qt_libraries, "_loads", lambda soname: soname == "libxcb-cursor.so.0")
    assert frozen.what_qt_lacks(["gui"]) is None


@pytest.mark.parametrize("original", [None, "/opt/lib"])
def test_other_programs_get_their_own_libraries(monkeypatch: pytest.MonkeyPatch, original: str | None) -> None:
    monkeypatch.setenv("LD_LIBRARY_PATH", "/bundle/_internal")
    monkeypatch.delenv("LD_LIBRARY_PATH_ORIG", raising=False)
    if original is not None:
        monkeypatch.setenv("LD_LIBRARY_PATH_ORIG", original)
    frozen.give_back_library_path()
    assert os.environ.get("LD_LIBRARY_PATH") == original


@pytest.mark.parametrize(("code", "shown"), [(0, []), (3, ["No module answers."])])
def test_without_a_console_an_error_is_shown_in_a_box(
    monkeypatch: pytest.MonkeyPatch, code: int, shown: list[str]
) -> None:
    def run() -> int:
        print("No module answers.")
        return code

    boxes: list[str] = []
    for stream in ("stdout", "stderr"):
        monkeypatch.setattr(sys, stream, None)
    monkeypatch.setattr("sys.platform", "win32")
    monkeypatch.setattr(frozen, "_run", run)
    monkeypatch.setattr(frozen, "_show_error", boxes.append)
    assert frozen.begin() == code
    assert boxes == shown
