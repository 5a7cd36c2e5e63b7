"""The packaged program: the library path of programs that it starts, and what it says where there is no console."""

import os
import sys

import pytest

from app import frozen


@pytest.mark.parametrize("original", [None, "/opt/lib"])
def test_other_programs_get_their_own_libraries(monkeypatch: pytest.MonkeyPatch, original: str | None) -> None:
    monkeypatch.setenv("LD_LIBRARY_PATH", "/bundle/_internal")
    monkeypatch.delenv("LD_LIBRARY_PATH_ORIG", raising=False)
    if original is not None:
        monkeypatch.setenv("LD_LIBRARY_PATH_ORIG", original)
    frozen.restore_library_path()
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
