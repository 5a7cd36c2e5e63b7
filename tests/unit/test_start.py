"""The start of an installed or packaged program: its own packages, its library path, and where there is no console."""

import os
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest

import dps_s_configurator
from dps_s_configurator import frozen
from tests.support.processes import ran

ROOT = Path(__file__).parents[2]
ENTRY = ROOT / "packaging" / "entry"
START = "import sys; from dps_s_configurator import main; sys.exit(main())"


def started(entry: Path, *words: str, folder: Path = ROOT, **variables: str) -> "subprocess.CompletedProcess[str]":
    """Run it as an installed command is: nothing but the entry can be imported by its place."""
    path = os.pathsep.join(filter(None, (variables.pop("PYTHONPATH", ""), str(entry))))
    environ = {**os.environ, "LC_ALL": "C.UTF-8", "PYTHONPATH": path, **variables}
    command = [sys.executable, "-P", "-c", START, *words]
    return subprocess.run(
        command, cwd=folder, env=environ, capture_output=True, text=True, encoding="utf-8", check=False
    )


@pytest.mark.parametrize("name", ["app", "protocol", "ui"])
def test_a_package_of_that_name_on_pythonpath_is_not_taken_for_ours(name: str, tmp_path: Path) -> None:
    (tmp_path / name).mkdir()
    (tmp_path / name / "__init__.py").write_text("raise SystemExit('foreign')\n", encoding="utf-8")
    done = started(ENTRY, "decode", "41", PYTHONPATH=str(tmp_path))
    assert done.stderr == ""
    assert done.returncode == 4  # no frame


@pytest.mark.parametrize("harm", ["another __init__.py", "no ui"])
@pytest.mark.promise("a")
def test_a_package_that_another_program_has_overwritten_or_removed_is_one_sentence(harm: str, tmp_path: Path) -> None:
    for package in (*dps_s_configurator.OURS, "packaging/entry/dps_s_configurator"):
        target = tmp_path / Path(package).name
        shutil.copytree(ROOT / package, target, ignore=shutil.ignore_patterns("__pycache__"))
    if harm == "no ui":
        shutil.rmtree(tmp_path / "ui")
    else:
        (tmp_path / "app" / "__init__.py").write_text("", encoding="utf-8")
    name = "ui" if harm == "no ui" else "app"
    done = started(tmp_path, "--version")
    assert (done.returncode, done.stdout) == (dps_s_configurator.INCOMPLETE, "")
    assert done.stderr.startswith(f"“{name}” in {tmp_path / name} is not DPS-S Configurator's")
    assert done.stderr.count("\n") == 1


@pytest.mark.parametrize(
    ("package", "words"),
    [
        ("numpy", ["fired", "flight.csv"]),
        ("mcap", ["record", "--port", "sim://", "--seconds", "0.2", "session.mcap"]),
        ("serial", ["read", "--port", "sim://"]),
        ("PySide6", ["gui", "--demo"]),
    ],
)
def test_a_missing_package_is_named_in_one_sentence(package: str, words: list[str], tmp_path: Path) -> None:
    (tmp_path / "sitecustomize.py").write_text(f"import sys\nsys.modules[{package!r}] = None\n", encoding="utf-8")
    done = started(ENTRY, *words, folder=tmp_path, PYTHONPATH=str(tmp_path), QT_QPA_PLATFORM="offscreen")
    assert done.returncode == 1
    assert done.stderr.splitlines()[-1] == f"The Python package {package} is missing. Install the program again."
    assert "Traceback" not in done.stderr


@pytest.mark.skipif(sys.platform == "win32", reason="there HOME is not read")
def test_without_a_home_lock_goes_on(tmp_path: Path) -> None:
    done = started(ENTRY, "lock", "--port", "sim://", folder=tmp_path, HOME="nowhere")
    assert done.returncode == 0, done.stderr
    assert "LOCKED" in done.stdout
    assert "Unexpected error" not in done.stderr


@pytest.mark.skipif(sys.platform == "win32", reason="there HOME is not read")
@pytest.mark.parametrize("words", [["archive", "report"], ["recordings", "list"], ["preflight", "--port", "sim://"]])
def test_without_a_home_what_cannot_be_kept_is_said(words: list[str], tmp_path: Path) -> None:
    done = started(ENTRY, *words, folder=tmp_path, HOME="nowhere")
    assert "Unexpected error" not in done.stderr
    assert not (tmp_path / "nowhere").exists()
    assert not (tmp_path / "~").exists()


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
    command = [sys.executable, "-c", START, "decode", "41"]
    done = ran(*command, PYTHONPATH=os.pathsep.join((str(tmp_path), str(ENTRY))), LC_ALL="C.UTF-8")
    assert done.stderr == ""
    assert done.returncode == (
        -signal.SIGINT if module == "the end" else dps_s_configurator.INTERRUPTED
    )  # a shell calls both 130


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
    monkeypatch.setattr(dps_s_configurator, "_run", run)
    monkeypatch.setattr(dps_s_configurator, "_show_error", boxes.append)
    assert dps_s_configurator.open_window() == code
    assert boxes == shown
