"""What bootstrap.py installs, asks and runs, with pip, venv and apt-get replaced by a recorder."""

import os
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from app.system import libraries as qt_libraries
from tests.support.setup_files import PACKAGING, ROOT, SetupFiles


class Checkout:
    """A checkout in a temporary folder on a Debian, where programs are recorded instead of run."""

    def __init__(self, root: Path, setup: SetupFiles, patch: pytest.MonkeyPatch) -> None:
        self.setup, self.patch = setup, patch
        self.commands: list[list[str]] = []
        self.failing = ""
        self.lacking: set[str] = set()
        self.uv: str | None = None
        self.user = 0
        self.answer: str | None = None
        """What somebody at a terminal types; None where there is no terminal."""
        self.lock = root / "lock.txt"
        root.mkdir()
        self.lock.write_text(
            "# program\nnumpy==1.0\n\n# tests\npytest==1.0\n\n# packages\nbuild==1.0\n", encoding="utf-8"
        )
        (root / "pyproject.toml").write_text("[project]\n", encoding="utf-8")
        self.venv = root / ".venv"
        self.python = self.venv / "bin" / "python"
        places = {"ROOT": root, "LOCK": self.lock, "PYPROJECT": root / "pyproject.toml", "VENV": self.venv}
        places |= {
            "FONT": root / "fonts",
            "BIN": self.python.parent,
            "VENV_PYTHON": self.python,
            "STAMP": self.venv / "made-from.txt",
        }
        for name, path in places.items():
            patch.setattr(setup.environment, name, path)
        patch.setattr(sys, "platform", "linux")
        patch.setattr(subprocess, "run", self._run)
        patch.setattr(shutil, "which", self._which)
        patch.setattr(os, "geteuid", lambda: self.user, raising=False)  # Windows has none
        patch.setattr(qt_libraries, "ctypes", SimpleNamespace(CDLL=self._load))
        patch.setattr(sys, "stdin", self)
        patch.setattr("builtins.input", lambda _question: self.answer)
        patch.delenv("CI", raising=False)

    def _load(self, name: str) -> None:
        if name in self.lacking:
            raise OSError(name)

    def isatty(self) -> bool:
        return self.answer is not None

    def _which(self, name: str, path: str | None = None) -> str | None:
        if name == "uv":
            return self.uv
        return None if name in self.lacking else f"/usr/bin/{name}"

    def _run(self, command: list[str], **_: object) -> "subprocess.CompletedProcess[str]":
        self.commands.append([str(word) for word in command])
        has_failed = bool(self.failing) and self.failing in command
        if "venv" in command and not has_failed:
            shutil.rmtree(self.venv, ignore_errors=True)
            self.python.parent.mkdir(parents=True)
            self.python.touch()
        if "apt-get" in command and "install" in command:
            self.lacking.clear()
        return subprocess.CompletedProcess(command, returncode=int(has_failed), stdout="fonts, and what apt says")

    def make_ready(self, extent: str = "tests", *, is_yes: bool = False) -> list[str]:
        """Make it ready; what was run for it."""
        self.commands.clear()
        self.setup.environment.make_ready(extent, is_yes=is_yes)
        known = ("apt-get", "venv", "install", "check")
        kinds = [next((word for word in known if word in command), "") for command in self.commands]
        return [kind for kind in kinds if kind]

    def installed(self) -> list[str]:
        """The packages of Debian."""
        return [word for command in self.commands if command[:2] == ["apt-get", "install"] for word in command[5:]]

    def refusal(self, extent: str = "tests") -> str:
        with pytest.raises(self.setup.environment.SetupError) as caught:
            self.make_ready(extent)
        return str(caught.value)


@pytest.fixture
def checkout(tmp_path: Path, setup: SetupFiles, monkeypatch: pytest.MonkeyPatch) -> Checkout:
    return Checkout(tmp_path / "a checkout", setup, monkeypatch)


WHOLE = ["venv", "install", "install", "check"]
PACKAGES_ONLY = ["install", "install", "check"]


def test_the_first_call_makes_all_and_the_second_nothing(checkout: Checkout) -> None:
    assert checkout.make_ready() == WHOLE
    assert (checkout.venv / "requirements.txt").read_text(encoding="utf-8").split() == ["numpy==1.0", "pytest==1.0"]
    assert not [word for command in checkout.commands for word in command if "://" in word or "index" in word]
    assert checkout.make_ready() == []


def test_what_is_needed_in_addition_comes_when_it_is_needed(checkout: Checkout) -> None:
    assert checkout.make_ready("program") == WHOLE
    assert checkout.make_ready("tests") == PACKAGES_ONLY
    assert checkout.make_ready("program") == [], "what tests need is enough for the program"
    assert checkout.make_ready("packages") == PACKAGES_ONLY
    assert checkout.make_ready("tests") == []


def test_uv_installs_where_it_is_there_and_pip_where_uv_cannot(checkout: Checkout) -> None:
    checkout.uv = "/home/u/.local/bin/uv"
    checkout.make_ready()
    assert {command[0] for command in checkout.commands[-3:]} == {checkout.uv}
    checkout.lock.write_text("# program\nnumpy==2.0\n", encoding="utf-8")
    checkout.failing = checkout.uv
    checkout.make_ready()
    assert checkout.commands[-1][:3] == [str(checkout.python), "-m", "pip"]


def test_an_interrupted_installation_is_begun_again(checkout: Checkout) -> None:
    checkout.failing = "--editable"
    assert "what apt says" in checkout.refusal()
    checkout.failing = ""
    assert checkout.make_ready() == WHOLE


@pytest.mark.parametrize("harm", ["no Python", "another place", "made by somebody else"])
def test_a_venv_that_does_not_fit_is_made_again(checkout: Checkout, harm: str) -> None:
    checkout.make_ready()
    if harm == "no Python":
        checkout.python.unlink()
    elif harm == "another place":
        checkout.patch.setattr(checkout.setup.environment, "ROOT", checkout.venv.parent / "moved")
    else:
        (checkout.venv / "made-from.txt").unlink()
    assert checkout.make_ready() == WHOLE


# What the system has to have

EVERYTHING = {"libEGL.so.1", "libGL.so.1", "libxcb-cursor.so.0", "initdb", "fc-list"}
PACKAGES = {"libegl1", "libgl1", "libxcb-cursor0", "postgresql", "fonts-wqy-microhei"}


def test_root_gets_all_at_once(checkout: Checkout) -> None:
    checkout.lacking = set(EVERYTHING)
    assert checkout.make_ready()[:2] == ["apt-get", "apt-get"]
    assert set(checkout.installed()) == PACKAGES


def test_a_user_gets_one_command_for_everything(checkout: Checkout) -> None:
    checkout.lacking, checkout.user = set(EVERYTHING), 1000
    said = checkout.refusal()
    assert "libEGL.so.1" in said
    assert set(said.partition("Type: sudo apt-get install ")[2].split()) == PACKAGES
    assert not [command for command in checkout.commands if "fc-list" not in command[0]]


def test_what_only_some_things_need_stops_nothing(checkout: Checkout, capsys: pytest.CaptureFixture[str]) -> None:
    checkout.lacking, checkout.user = {"initdb", "libxcb-cursor.so.0"}, 1000
    assert checkout.make_ready() == WHOLE
    assert "Type: sudo apt-get install libxcb-cursor0 postgresql" in capsys.readouterr().out


def test_another_system_gets_the_list_of_libraries(checkout: Checkout) -> None:
    checkout.lacking = {"apt-get", "libEGL.so.1", "libGL.so.1"}
    assert re.match(r"The system lacks libGL\.so\.1, libEGL\.so\.1\. Install the packages", checkout.refusal())


@pytest.mark.parametrize(("answer", "is_done"), [("", True), ("y", True), ("n", False)])
def test_at_a_terminal_root_is_asked(checkout: Checkout, answer: str, is_done: bool) -> None:
    checkout.lacking, checkout.answer = {"libEGL.so.1"}, answer
    if is_done:
        checkout.make_ready()
    else:
        assert "Type: sudo apt-get install libegl1" in checkout.refusal()
    assert checkout.installed() == (["libegl1"] if is_done else [])


# The commands


@pytest.fixture
def ready(setup: SetupFiles, monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """Everything is installed; what was asked for, and which programs were run."""
    asked: list[Any] = []

    def call(program: list[Any], **_: str) -> int:
        asked.append([str(word) for word in program[1:]])
        return 7

    monkeypatch.setattr(setup.commands, "make_ready", lambda extent, *, is_yes: asked.append((extent, is_yes)))
    monkeypatch.setattr(setup.commands, "call", call)
    return asked


@pytest.mark.parametrize(
    ("arguments", "needs", "words"),
    [
        (["test", "-k", "foo"], ("tests", False), ["-m", "pytest", "-n", "4", "--dist", "worksteal", "-k", "foo"]),
        (["--yes", "run", "read"], ("program", True), ["read"]),
        (["run", "--yes", "lock", "--yes"], ("program", True), ["lock", "--yes"]),
        (["translations", "check", "--yes"], ("tests", True), ["docs/generate/translations.py", "check"]),
    ],
)
def test_arguments_are_passed_on_and_yes_stands_before_the_command_or_after_it(
    setup: SetupFiles,
    ready: list[Any],
    monkeypatch: pytest.MonkeyPatch,
    arguments: list[str],
    needs: tuple[str, bool],
    words: list[str],
) -> None:
    monkeypatch.setattr(os, "cpu_count", lambda: 2)
    assert setup.commands.main(arguments) == 7
    assert ready == [needs, words]


@pytest.mark.parametrize("obstacle", ["", "No screen."])
def test_demo_opens_the_window_or_leaves_evidence(
    setup: SetupFiles, ready: list[Any], monkeypatch: pytest.MonkeyPatch, obstacle: str
) -> None:
    monkeypatch.setattr(setup.commands, "_why_no_window", lambda: obstacle)
    assert setup.commands.main(["demo", "--lang", "zh_CN"]) == 7
    assert ready[1][:2] == ["gui", "--demo"]
    assert ready[1][-2:] == ["--lang", "zh_CN"]
    assert ("--evidence" in ready[1]) == bool(obstacle)


def test_help_of_a_command_installs_nothing(
    setup: SetupFiles, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(setup.commands, "is_current", lambda extent: False)
    monkeypatch.setattr(setup.commands, "make_ready", lambda *_, **__: pytest.fail("something would be installed"))
    assert setup.commands.main(["test", "--help"]) == 0
    assert setup.commands.COMMANDS["test"][0] in capsys.readouterr().out


def test_a_missing_requirement_is_code_3_and_an_unknown_command_code_2(
    setup: SetupFiles, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def refuse(extent: str, *, is_yes: bool) -> None:
        raise setup.environment.SetupError("Type: sudo apt-get install libegl1")

    monkeypatch.setattr(setup.commands, "make_ready", refuse)
    assert setup.commands.main(["test"]) == 3
    assert capsys.readouterr().err == "Type: sudo apt-get install libegl1\n"
    assert setup.commands.main(["dance"]) == 2
    assert setup.commands.main([]) == 2


def test_only_the_standard_library_is_imported() -> None:
    """In a fresh interpreter without any package, as in a fresh clone."""
    code = f"import sys; sys.path[:0] = [{str(PACKAGING)!r}, {str(ROOT)!r}]; import commands"
    done = subprocess.run([sys.executable, "-I", "-S", "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


# The lock

SYSTEMS = [
    {"sys_platform": system, "python_version": version, "python_full_version": f"{version}.0"}
    for system in ("linux", "win32", "darwin")
    for version in ("3.11", "3.12", "3.13", "3.14")
]


@pytest.mark.parametrize("system", SYSTEMS, ids=lambda system: f"{system['sys_platform']}-{system['python_version']}")
def test_the_lock_is_exact_and_fits_the_project(system: dict[str, str], setup: SetupFiles) -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    wanted = {"program": [*project["project"]["dependencies"], *project["build-system"]["requires"]]}
    wanted["tests"] = wanted["program"] + project["project"]["optional-dependencies"]["dev"]
    wanted["packages"] = wanted["tests"] + project["project"]["optional-dependencies"]["package"]
    for extent, requirements in wanted.items():
        locked = [Requirement(line) for line in setup.environment.locked(extent)]
        fitting = [one for one in locked if one.marker is None or one.marker.evaluate(system)]
        versions = {canonicalize_name(one.name): next(iter(one.specifier)).version for one in fitting}
        assert len(versions) == len(fitting), "each is there once"
        for requirement in map(Requirement, requirements):
            assert requirement.specifier.contains(versions[canonicalize_name(requirement.name)]), requirement
    program = {canonicalize_name(Requirement(line).name) for line in setup.environment.locked("program")}
    assert not {"pytest", "mypy", "ruff", "pyinstaller"} & program
