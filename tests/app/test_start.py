"""The start of an installed or packaged program: its own packages, its library path, and where there is no console."""

import os
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from app import frozen, start
from tests.support.processes import ran

ROOT = Path(__file__).parents[2]


def started(folder: Path) -> "subprocess.CompletedProcess[str]":
    command = [sys.executable, "-c", "import sys; from app.start import main; sys.exit(main())", "--version"]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, encoding="utf-8", check=False)


def test_the_programs_own_packages_are_no_matter() -> None:
    assert start.foreign_package() is None


@pytest.mark.parametrize("name", ["protocol", "ui"])
def test_a_package_of_another_program_is_one_sentence(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    foreign = tmp_path / name
    foreign.mkdir()
    (foreign / "__init__.py").touch()
    monkeypatch.setenv("LC_ALL", "C.UTF-8")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    done = started(ROOT / "docs")
    assert done.returncode == start.FOREIGN
    assert done.stderr == f"“{name}” in {foreign} is not this program's: install it with pipx or uv tool.\n"


def test_an_overwritten_package_is_one_sentence(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where another wheel has a package `app`, its `__init__.py` replaces ours and the other files stay."""
    for package in start.OURS:
        shutil.copytree(ROOT / package, tmp_path / package, ignore=shutil.ignore_patterns("__pycache__"))
    (tmp_path / "app" / "__init__.py").write_text("", encoding="utf-8")
    monkeypatch.setenv("LC_ALL", "C.UTF-8")
    done = started(tmp_path)
    assert (done.returncode, done.stdout) == (start.FOREIGN, "")
    assert done.stderr == f"“app” in {tmp_path / 'app'} is not this program's: install it with pipx or uv tool.\n"


@pytest.mark.parametrize("name", ["app", "protocol", "ui"])
def test_a_package_that_another_program_took_along_is_noticed(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(start.OURS, name, "what_only_another_has.py")
    assert f"“{name}” in " in (start.foreign_package() or "")


@pytest.mark.skipif(sys.platform == "win32", reason="there a process sends Ctrl-C to its whole group")
@pytest.mark.parametrize("module", ["argparse", "app.text.i18n", "app.cli.decode", "the end"])
def test_ctrl_c_while_it_is_loaded_or_ends_is_quiet(module: str, tmp_path: Path) -> None:
    """The signal arrives while this module is imported; most often a traceback of the imports was printed."""
    (tmp_path / "sitecustomize.py").write_text(
        "import atexit, os, signal, sys\n"
        "class Interrupting:\n"
        "    def find_spec(self, name, path=None, target=None):\n"
        f"        if name == {module!r}:\n"
        "            os.kill(os.getpid(), signal.SIGINT)\n"
        "sys.meta_path.insert(0, Interrupting())\n"
        f"if {module!r} == 'the end':\n"
        "    atexit.register(os.kill, os.getpid(), signal.SIGINT)\n",
        encoding="utf-8",
    )
    command = [sys.executable, "-c", "import sys; from app.start import main; sys.exit(main())", "decode", "41"]
    done = ran(*command, PYTHONPATH=str(tmp_path), LC_ALL="C.UTF-8")
    assert done.stderr == ""
    assert done.returncode == (-signal.SIGINT if module == "the end" else start.INTERRUPTED)  # a shell calls both 130


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
