"""What Qt wants from Linux, with apt replaced by a recorder."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from app.system import qt_libraries
from tests.support.setup_files import SetupFiles


class Apt:
    """Records what a root or a user would do with apt."""

    def __init__(self, setup: SetupFiles, patch: pytest.MonkeyPatch, *, user: int) -> None:
        self.commands: list[list[str]] = []
        self.code = 0
        patch.setattr(setup.environment, "_quietly", self._run)
        patch.setattr(os, "geteuid", lambda: user, raising=False)  # Windows has none
        patch.setattr(setup.system_libraries, "package_manager", lambda: "apt")
        patch.setattr(qt_libraries, "_is_after_time_t_64", lambda: False)

    def _run(self, command: list[str], **variables: str) -> "subprocess.CompletedProcess[str]":
        assert variables == {"DEBIAN_FRONTEND": "noninteractive"}
        self.commands.append(command)
        return subprocess.CompletedProcess(command, returncode=self.code, stdout="apt says so")


def test_root_gets_missing_libraries_installed(setup: SetupFiles, monkeypatch: pytest.MonkeyPatch) -> None:
    apt, system = Apt(setup, monkeypatch, user=0), setup.system_libraries
    monkeypatch.setattr(qt_libraries, "_loads", lambda soname: soname != "libEGL.so.1" or bool(apt.commands))
    monkeypatch.setattr(system, "QT_PROVEN", Path(__file__))
    monkeypatch.setattr(sys, "platform", "linux")
    system.make_ready(Path(sys.executable), is_screen_wanted=False)
    assert [command[1] for command in apt.commands] == ["update", "install"]
    assert apt.commands[1][-1] == "libegl1"


def test_a_user_is_told_the_command(setup: SetupFiles, monkeypatch: pytest.MonkeyPatch) -> None:
    apt, system = Apt(setup, monkeypatch, user=1000), setup.system_libraries
    monkeypatch.setattr(qt_libraries, "_loads", lambda soname: soname not in ("libEGL.so.1", "libGL.so.1"))
    monkeypatch.setattr(sys, "platform", "linux")
    with pytest.raises(setup.environment.SetupError) as caught:
        system.make_ready(Path(sys.executable), is_screen_wanted=False)
    assert "Type: sudo apt-get install libgl1 libegl1" in str(caught.value)
    assert caught.value.exit_code == 3
    assert apt.commands == []


@pytest.mark.parametrize("manager", ["dnf", "pacman", "zypper"])
def test_other_package_managers_are_named(setup: SetupFiles, monkeypatch: pytest.MonkeyPatch, manager: str) -> None:
    system = setup.system_libraries
    monkeypatch.setattr(system, "package_manager", lambda: manager)
    monkeypatch.setattr(qt_libraries, "_loads", lambda soname: False)
    monkeypatch.setattr(sys, "platform", "linux")
    with pytest.raises(setup.environment.SetupError, match=qt_libraries.INSTALL[manager]) as caught:
        system.make_ready(Path(sys.executable), is_screen_wanted=False)
    names = str(caught.value).rpartition(qt_libraries.INSTALL[manager])[2].split()
    assert len(names) == len(set(names)) > 8


def test_a_failed_installation_says_what_apt_said(setup: SetupFiles, monkeypatch: pytest.MonkeyPatch) -> None:
    apt = Apt(setup, monkeypatch, user=0)
    apt.code = 100
    with pytest.raises(setup.environment.SetupError, match="apt says so"):
        setup.environment.install_with_apt(["libegl1"], reason="No EGL")


def test_debians_python_without_venv_gets_its_own_package(setup: SetupFiles, monkeypatch: pytest.MonkeyPatch) -> None:
    apt, environment = Apt(setup, monkeypatch, user=0), setup.environment
    monkeypatch.setattr(environment, "_has_venv_module", lambda: bool(apt.commands))
    monkeypatch.setattr(environment.shutil, "which", lambda name: f"/usr/bin/{name}")
    monkeypatch.setattr(sys, "base_prefix", "/usr")
    environment.need_venv_module()
    assert apt.commands[1][-1] == f"python3.{sys.version_info.minor}-venv"

    monkeypatch.setattr(sys, "base_prefix", "/opt/python")
    apt.commands.clear()
    with pytest.raises(environment.SetupError, match="without ensurepip"):
        environment.need_venv_module()


@pytest.mark.parametrize(
    ("environ", "problem", "part"),
    [
        ({}, None, "no screen here"),
        ({"DISPLAY": ":7", "QT_QPA_PLATFORM": "offscreen"}, None, "offscreen"),
        ({"DISPLAY": ":7"}, "could not connect to display", "The screen :7 does not let"),
        ({"DISPLAY": ":7"}, None, None),
        ({"WAYLAND_DISPLAY": "wayland-0"}, None, None),
    ],
)
def test_why_there_is_no_screen(
    setup: SetupFiles,
    monkeypatch: pytest.MonkeyPatch,
    environ: dict[str, str],
    problem: str | None,
    part: str | None,
) -> None:
    monkeypatch.setattr(sys, "platform", "linux")
    for variable in ("DISPLAY", "WAYLAND_DISPLAY", "QT_QPA_PLATFORM", "XDG_SESSION_TYPE"):
        monkeypatch.delenv(variable, raising=False)
    for variable, value in environ.items():
        monkeypatch.setenv(variable, value)
    monkeypatch.setattr(setup.system_libraries, "_problem_with_qt", lambda *_, **__: problem)
    why = setup.system_libraries.why_no_screen(Path(sys.executable))
    assert (why is None) == (part is None)
    assert (part or "") in (why or "")


def test_qt_is_really_tried(setup: SetupFiles) -> None:
    try_qt = setup.system_libraries._problem_with_qt
    assert try_qt(Path(sys.executable), platform="offscreen") is None
    assert "nosuch" in try_qt(Path(sys.executable), platform="nosuch")


def test_a_chinese_font_is_known_by_its_file(
    setup: SetupFiles, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    system = setup.system_libraries
    monkeypatch.setattr(system.shutil, "which", lambda name: None)
    monkeypatch.setattr(system, "_FONT_FOLDERS", (str(tmp_path), str(tmp_path / "missing")))
    (tmp_path / "DejaVuSans.ttf").touch()
    assert not system.has_chinese_font()
    (tmp_path / "wqy-microhei.ttc").touch()
    assert system.has_chinese_font()
