"""What Qt wants from Linux, with apt replaced by a recorder."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from app.system import qt_libraries
from tests.support.setup_files import SetupFiles


class Machine:
    """A Linux on which some things are not here, and where what apt does is recorded."""

    def __init__(self, setup: SetupFiles, patch: pytest.MonkeyPatch, tmp_path: Path) -> None:
        self.setup, self.patch = setup, patch
        self.commands: list[list[str]] = []
        self.code = 0
        self.lacking: set[str] = set()
        self.manager: str | None = "apt"
        self.user = 0
        self.answer: str | None = None
        """What somebody at a terminal types; None where there is no terminal."""
        self.asked: list[str] = []
        system, environment = setup.system_libraries, setup.environment
        patch.setattr(sys, "platform", "linux")
        patch.setattr(sys, "base_prefix", "/usr")
        for name in ("CI", environment.YES, "DISPLAY", "WAYLAND_DISPLAY", "QT_QPA_PLATFORM"):
            patch.delenv(name, raising=False)
        patch.setattr(subprocess, "run", self._run)
        patch.setattr(os, "geteuid", lambda: self.user, raising=False)  # Windows has none
        patch.setattr(system, "package_manager", lambda: self.manager)
        patch.setattr(system, "VENV_PYTHON", tmp_path / "python")
        patch.setattr(system, "has_venv_module", lambda: self.has("venv"))
        patch.setattr(system, "has_chinese_font", lambda: self.has("font"))
        patch.setattr(shutil, "which", lambda name, path: name if self.has(name) else None)
        patch.setattr(qt_libraries, "_loads", self.has)
        patch.setattr(qt_libraries, "_is_after_time_t_64", lambda: False)
        patch.setattr(sys, "stdin", self)
        patch.setattr("builtins.input", self._input)

    def has(self, name: str) -> bool:
        return name not in self.lacking or any("install" in command for command in self.commands if not self.code)

    def isatty(self) -> bool:
        return self.answer is not None

    def _input(self, question: str) -> str:
        self.asked.append(question)
        assert self.answer is not None
        return self.answer

    def _run(self, command: list[str], *, env: dict[str, str], **_: object) -> "subprocess.CompletedProcess[str]":
        assert env["DEBIAN_FRONTEND"] == "noninteractive"
        self.commands.append(command)
        return subprocess.CompletedProcess(command, returncode=self.code, stdout="apt says so")

    def make_ready(
        self, *, first: bool = True, screen: bool = False, packaging: bool = False, testing: bool = False
    ) -> list[str]:
        """The packages that were installed."""
        self.setup.system_libraries.make_ready(
            is_first=first, is_screen_wanted=screen, is_packaging=packaging, is_testing=testing
        )
        return self.installed()

    def installed(self) -> list[str]:
        return [word for command in self.commands if "install" in command for word in command[5:]]

    def refused(self, **wanted: bool) -> str:
        with pytest.raises(self.setup.environment.SetupError) as caught:
            self.make_ready(**wanted)
        assert caught.value.exit_code == 3
        return str(caught.value)


@pytest.fixture
def machine(setup: SetupFiles, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Machine:
    return Machine(setup, monkeypatch, tmp_path)


EVERYTHING = {"venv", "libEGL.so.1", "libGL.so.1", "libxcb-cursor.so.0", "font", "objdump"}
VENV = f"python3.{sys.version_info.minor}-venv"


def test_root_gets_all_at_once_for_screen_and_offscreen(machine: Machine) -> None:
    machine.lacking = EVERYTHING
    packages = ["libgl1", "libegl1", "libxcb-cursor0", "fonts-wqy-microhei"]
    assert machine.make_ready() == [VENV, *packages]
    assert [command[1] for command in machine.commands] == ["update", "install"]
    assert machine.asked == [], "there is no terminal"


def test_a_user_gets_one_command_for_everything(machine: Machine) -> None:
    machine.lacking, machine.user = EVERYTHING, 1000
    said = machine.refused(packaging=True)
    names = f"{VENV} libgl1 libegl1 binutils libxcb-cursor0 fonts-wqy-microhei"
    assert said.endswith(f". Type: sudo apt-get install {names}")
    assert machine.commands == []


def test_optional_libraries_are_reported_once_and_stop_nothing(
    machine: Machine, capsys: pytest.CaptureFixture[str]
) -> None:
    machine.lacking, machine.user = {"libxcb-cursor.so.0", "font"}, 1000
    assert machine.make_ready() == []
    assert "sudo apt-get install libxcb-cursor0 fonts-wqy-microhei" in capsys.readouterr().out
    machine.make_ready(first=False)
    assert capsys.readouterr().out == ""
    machine.patch.setenv("DISPLAY", ":7")
    assert "libxcb-cursor0" in machine.refused(screen=True), "on a screen it is needed"


def test_the_tests_get_a_database_server_and_run_without_one(
    machine: Machine, capsys: pytest.CaptureFixture[str]
) -> None:
    machine.lacking = {"initdb"}
    assert machine.make_ready() == []
    assert machine.make_ready(testing=True) == ["postgresql"]
    machine.commands.clear()
    machine.user = 1000
    assert machine.make_ready(testing=True) == []
    assert "archive server need PostgreSQL. Type: sudo apt-get install postgresql" in capsys.readouterr().out
    machine.user, machine.lacking = 0, {"initdb", "libEGL.so.1"}
    assert machine.make_ready(testing=True) == ["libegl1", "postgresql"], "all at once"


def test_the_tests_get_an_x_server(machine: Machine) -> None:
    machine.lacking = {"Xvfb", "xdotool"}
    assert machine.make_ready() == []
    assert machine.make_ready(testing=True) == ["xvfb", "xdotool"]


@pytest.mark.parametrize(("answer", "is_done"), [("", True), ("y", True), ("Yes", True), ("n", False), ("what", False)])
def test_at_a_terminal_root_is_asked_before_anything_is_installed(
    machine: Machine, capsys: pytest.CaptureFixture[str], answer: str, is_done: bool
) -> None:
    machine.lacking, machine.answer = {"libEGL.so.1"}, answer
    if is_done:
        assert machine.make_ready() == ["libegl1"]
    else:
        assert machine.refused() == "Nothing was installed. Type: apt-get install libegl1"
        assert machine.commands == []
    assert len(machine.asked) == 1
    assert "apt-get install --no-install-recommends libegl1" in capsys.readouterr().out


@pytest.mark.parametrize("variable", ["CI", "DPS_S_SETUP_YES"])
def test_a_variable_answers_the_question(machine: Machine, variable: str) -> None:
    machine.lacking, machine.answer = {"libEGL.so.1"}, "n"
    machine.patch.setenv(variable, "true")
    assert machine.make_ready() == ["libegl1"]
    assert machine.asked == []


@pytest.mark.parametrize("manager", ["dnf", "pacman", "zypper"])
@pytest.mark.parametrize("user", [0, 1000])
def test_other_package_managers_are_named(machine: Machine, manager: str, user: int) -> None:
    machine.manager, machine.user = manager, user
    machine.lacking = {alway.name for alway in qt_libraries.ALWAYS} | {"objdump"}
    said = machine.refused(packaging=True)
    command = f"Type: {'sudo ' if user else ''}{qt_libraries.INSTALL[manager]} "
    names = said.partition(command)[2].split()
    assert len(names) == len(set(names)) > 8
    assert "binutils" in names


def test_without_a_package_manager_the_libraries_are_named(machine: Machine) -> None:
    machine.manager, machine.lacking = None, {"libEGL.so.1", "objdump"}
    said = machine.refused(packaging=True)
    assert "missing: libEGL.so.1, objdump. Install the packages that contain them" in said


def test_a_failed_installation_says_what_apt_said(machine: Machine, capsys: pytest.CaptureFixture[str]) -> None:
    machine.lacking, machine.code = {"libegl.so.1", "font"}, 100
    assert machine.make_ready()  # English works without a font
    assert "apt says so" in capsys.readouterr().out
    machine.lacking = {"libEGL.so.1"}
    assert "apt says so" in machine.refused()


def test_a_python_without_ensurepip_is_reported(machine: Machine) -> None:
    machine.lacking = {"venv"}
    machine.patch.setattr(sys, "base_prefix", "/opt/python")
    assert "without ensurepip" in machine.refused()
    machine.setup.system_libraries.VENV_PYTHON.touch()
    assert machine.make_ready() == [], "there is a .venv: it is not needed again"
