"""What the scripts of packaging/ install, ask and run, with pip, venv and apt-get replaced by a recorder; and what they
put into packages, as far as that can be told without making one."""

import os
import re
import shutil
import subprocess
import sys
import tomllib
from importlib import import_module
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from app.__main__ import PORT
from app.cli.commands import ENTRIES
from app.engine.ports import _FLIGHT_CONTROLLERS
from app.system import libraries
from tests.support.setup_files import PACKAGING, ROOT, registered_endings, tool

commands, environment, package, release = (
    tool("packaging", name) for name in ("commands", "environment", "package", "release")
)
LINUX = PACKAGING / "linux"
WHOLE, PACKAGES_ONLY = ["venv", "install", "install", "check"], ["install", "install", "check"]
EVERYTHING = {"libEGL.so.1", "libGL.so.1", "libxcb-cursor.so.0", "initdb", "fc-list"}
OF_DEBIAN = {"libegl1", "libgl1", "libxcb-cursor0", "postgresql", "fonts-wqy-microhei"}


@pytest.fixture(autouse=True)
def _path(monkeypatch: pytest.MonkeyPatch) -> None:
    """They import each other, some when they are called."""
    monkeypatch.syspath_prepend(str(PACKAGING))


class Checkout:
    """A checkout in a temporary folder on a Debian, where programs are recorded instead of run."""

    def __init__(self, root: Path, patch: pytest.MonkeyPatch) -> None:
        self.commands: list[list[str]] = []
        self.failing, self.user = "", 0
        self.lacking = set[str]()
        self.lock, self.venv = root / "lock.txt", root / ".venv"
        self.python = self.venv / "bin" / "python"
        root.mkdir()
        lock = "# program\nnumpy==1.0\n\n# tests\npytest==1.0\n\n# packages\nbuild==1.0\n"
        self.lock.write_text(lock, encoding="utf-8")
        (root / "pyproject.toml").write_text("[project]\n", encoding="utf-8")
        for name, path in {
            "ROOT": root, "LOCK": self.lock, "PYPROJECT": root / "pyproject.toml", "VENV": self.venv,
            "FONT": root / "fonts", "BIN": self.python.parent, "VENV_PYTHON": self.python,
            "STAMP": self.venv / "made-from.txt",
        }.items():  # fmt: skip
            patch.setattr(environment, name, path)
        patch.setattr(sys, "platform", "linux")
        patch.setattr(subprocess, "run", self._run)
        patch.setattr(shutil, "which", self._which)
        patch.setattr(os, "geteuid", lambda: self.user, raising=False)  # Windows has none
        patch.setattr(libraries, "ctypes", SimpleNamespace(CDLL=self._load))
        patch.setattr(sys, "stdin", None)  # nobody at a terminal is asked
        patch.delenv("CI", raising=False)

    def _load(self, name: str) -> None:
        if name in self.lacking:
            raise OSError(name)

    def _which(self, name: str, path: str | None = None) -> str | None:
        return None if name in self.lacking | {"uv"} else f"/usr/bin/{name}"

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

    def make_ready(self, extent: str = "tests") -> list[str]:
        """Make it ready; what was run for it."""
        self.commands.clear()
        environment.make_ready(extent)
        known = ("apt-get", "venv", "install", "check")
        return [kind for command in self.commands for kind in known if kind in command][: len(self.commands)]

    def installed(self) -> set[str]:
        """The packages of Debian."""
        return {word for command in self.commands if command[:2] == ["apt-get", "install"] for word in command[5:]}

    def refusal(self) -> str:
        with pytest.raises(environment.SetupError) as caught:
            self.make_ready()
        return str(caught.value)


@pytest.fixture
def checkout(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Checkout:
    return Checkout(tmp_path / "a checkout", monkeypatch)


def test_what_is_needed_comes_when_it_is_needed_and_once(checkout: Checkout) -> None:
    assert checkout.make_ready("program") == WHOLE
    assert checkout.make_ready("tests") == PACKAGES_ONLY
    assert (checkout.venv / "requirements.txt").read_text(encoding="utf-8").split() == ["numpy==1.0", "pytest==1.0"]
    assert not [word for command in checkout.commands for word in command if "://" in word or "index" in word]
    assert checkout.make_ready("program") == [], "what tests need is enough for the program"
    assert checkout.make_ready("packages") == PACKAGES_ONLY
    assert checkout.make_ready("tests") == []


def test_uv_installs_where_it_is_there_and_pip_where_uv_cannot(
    checkout: Checkout, monkeypatch: pytest.MonkeyPatch
) -> None:
    uv = "/home/u/.local/bin/uv"
    monkeypatch.setattr(shutil, "which", lambda name, path=None: uv if name == "uv" else f"/usr/bin/{name}")
    checkout.make_ready()
    assert {command[0] for command in checkout.commands[-3:]} == {uv}
    checkout.lock.write_text("# program\nnumpy==2.0\n", encoding="utf-8")
    checkout.failing = uv
    checkout.make_ready()
    assert checkout.commands[-1][:3] == [str(checkout.python), "-m", "pip"]


@pytest.mark.parametrize("harm", ["interrupted", "no Python", "another place", "made by somebody else"])
def test_a_venv_that_does_not_fit_is_made_again(checkout: Checkout, harm: str, monkeypatch: pytest.MonkeyPatch) -> None:
    if harm == "interrupted":
        checkout.failing = "--editable"
        assert "what apt says" in checkout.refusal()
        checkout.failing = ""
    else:
        checkout.make_ready()
    if harm == "no Python":
        checkout.python.unlink()
    elif harm == "another place":
        monkeypatch.setattr(environment, "ROOT", checkout.venv.parent / "moved")
    elif harm == "made by somebody else":
        (checkout.venv / "made-from.txt").unlink()
    assert checkout.make_ready() == WHOLE


# What the system has to have


def test_root_gets_all_at_once_and_a_user_one_command_for_everything(checkout: Checkout) -> None:
    checkout.lacking, checkout.user = set(EVERYTHING), 1000
    said = checkout.refusal()
    assert "libEGL.so.1" in said
    assert set(said.partition("Type: sudo apt-get install ")[2].split()) == OF_DEBIAN
    assert not [command for command in checkout.commands if "fc-list" not in command[0]]
    checkout.user = 0
    assert checkout.make_ready()[:2] == ["apt-get", "apt-get"]
    assert checkout.installed() == OF_DEBIAN


@pytest.mark.parametrize(("answer", "is_done"), [("", True), ("n", False)])
def test_at_a_terminal_root_is_asked(
    checkout: Checkout, answer: str, is_done: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "stdin", SimpleNamespace(isatty=lambda: True))
    monkeypatch.setattr("builtins.input", lambda _question: answer)
    checkout.lacking = {"libEGL.so.1"}
    if is_done:
        checkout.make_ready()
    else:
        assert "Type: sudo apt-get install libegl1" in checkout.refusal()
    assert checkout.installed() == ({"libegl1"} if is_done else set())


def test_another_system_gets_the_list_of_libraries(checkout: Checkout) -> None:
    checkout.lacking = {"apt-get", "libEGL.so.1", "libGL.so.1"}
    assert re.match(r"The system lacks libGL\.so\.1, libEGL\.so\.1\. Install the packages", checkout.refusal())


def test_what_only_some_things_need_stops_nothing(checkout: Checkout, capsys: pytest.CaptureFixture[str]) -> None:
    checkout.lacking, checkout.user = {"initdb", "libxcb-cursor.so.0"}, 1000
    assert checkout.make_ready() == WHOLE
    assert "Type: sudo apt-get install libxcb-cursor0 postgresql" in capsys.readouterr().out


# The commands


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """Everything is installed; what was asked for, and which programs were run."""
    asked: list[Any] = []

    def call(program: list[Any], **_: str) -> int:
        asked.append([str(word) for word in program[1:]])
        return 7

    monkeypatch.setattr(commands, "make_ready", lambda extent, *, is_yes: asked.append((extent, is_yes)))
    monkeypatch.setattr(commands, "call", call)
    return asked


@pytest.mark.parametrize(
    ("arguments", "needs", "words"),
    [
        (["test", "-k", "foo"], ("tests", False), ["-m", "pytest", "-n", "4", "--dist", "worksteal", "-k", "foo"]),
        (["--yes", "translations", "check"], ("tests", True), ["docs/generate/translations.py", "check"]),
        (["translations", "check", "--yes"], ("tests", True), ["docs/generate/translations.py", "check"]),
    ],
)
def test_arguments_are_passed_on_and_yes_stands_before_the_command_or_after_it(
    asked: list[Any],
    monkeypatch: pytest.MonkeyPatch,
    arguments: list[str],
    needs: tuple[str, bool],
    words: list[str],
) -> None:
    monkeypatch.setattr(os, "cpu_count", lambda: 2)
    assert commands.main(arguments) == 7
    assert asked == [needs, words]


@pytest.mark.parametrize("obstacle", ["", "No screen."])
def test_demo_opens_the_window_or_leaves_evidence(
    asked: list[Any], monkeypatch: pytest.MonkeyPatch, obstacle: str
) -> None:
    monkeypatch.setattr(commands, "_why_no_window", lambda: obstacle)
    assert commands.main(["demo", "--lang", "zh_CN"]) == 7
    assert (asked[1][:2], asked[1][-2:]) == (["gui", "--demo"], ["--lang", "zh_CN"])
    assert ("--evidence" in asked[1]) == bool(obstacle)


def test_help_installs_nothing_a_missing_requirement_is_code_3_and_an_unknown_command_code_2(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def refuse(extent: str, *, is_yes: bool) -> None:
        raise environment.SetupError("Type: sudo apt-get install libegl1")

    monkeypatch.setattr(commands, "is_current", lambda extent: False)
    monkeypatch.setattr(commands, "make_ready", refuse)
    assert commands.main(["test", "--help"]) == 0
    assert commands.COMMANDS["test"][0] in capsys.readouterr().out
    assert commands.main(["test"]) == 3
    assert capsys.readouterr().err == "Type: sudo apt-get install libegl1\n"
    assert (commands.main(["dance"]), commands.main([])) == (2, 2)


def test_only_the_standard_library_is_imported() -> None:
    """In a fresh interpreter without any package, as in a fresh clone."""
    code = f"import sys; sys.path[:0] = [{str(PACKAGING)!r}, {str(ROOT)!r}]; import commands"
    done = subprocess.run([sys.executable, "-I", "-S", "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("system", ["linux", "win32", "darwin"])
@pytest.mark.parametrize("version", ["3.11", "3.12", "3.13", "3.14"])
def test_the_lock_is_exact_and_fits_the_project(system: str, version: str) -> None:
    here = {"sys_platform": system, "python_version": version, "python_full_version": f"{version}.0"}
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    further = project["project"]["optional-dependencies"]
    wanted = {"program": [*project["project"]["dependencies"], *project["build-system"]["requires"]]}
    wanted["tests"] = wanted["program"] + further["dev"]
    wanted["packages"] = wanted["tests"] + further["package"]
    for extent, requirements in wanted.items():
        locked = [Requirement(line) for line in environment.locked(extent)]
        fitting = [one for one in locked if one.marker is None or one.marker.evaluate(here)]
        versions = {canonicalize_name(one.name): next(iter(one.specifier)).version for one in fitting}
        assert len(versions) == len(fitting), "each is there once"
        for requirement in map(Requirement, requirements):
            assert requirement.specifier.contains(versions[canonicalize_name(requirement.name)]), requirement
    program = {canonicalize_name(Requirement(line).name) for line in environment.locked("program")}
    assert not {"pytest", "mypy", "ruff", "pyinstaller"} & program


# What goes into packages


def test_the_installer_registers_what_the_window_opens_and_takes_nothing_of_the_users() -> None:
    from ui.main import PAGES

    pages = (getattr(import_module(f"ui.pages.{one.key}.page"), f"{one.key.capitalize()}Page") for one in PAGES)
    opened = {suffix for page in pages for suffix in page.suffixes}
    opened_where_chosen = {".html", ".htm", ".zip", ".gz"}  # too many files of other programs end so
    assert registered_endings() == opened - opened_where_chosen
    text = (PACKAGING / "windows" / "installer.nsi").read_text(encoding="utf-8")
    taken = re.findall(r"RMDir /r \"([^\"]+)\"", text[text.index('Section "Uninstall"') :])
    assert taken == ["$INSTDIR\\_internal", "$INSTDIR\\licences"]


def test_the_udev_rule_reads_as_one_and_has_the_usual_adapters_and_the_flight_controllers() -> None:
    """A word of it that is misspelt is no error to udev: nothing happens, and the port may not be opened."""
    rule = LINUX / "60-dps-s.rules"
    assert rule.name < "73-seat-late.rules", "which asks for `uaccess`"
    text = rule.read_text(encoding="ascii")
    assert set(re.findall(r'GOTO="(\w+)"', text)) == set(re.findall(r'LABEL="(\w+)"', text))
    covered = set[str]()
    for line in (line for line in text.splitlines() if line and not line.startswith("#")):
        for part in re.split(r",\s*(?=[A-Z])", line):
            assert re.fullmatch(r'[A-Z]+(\{[A-Za-z_]+\})?(==|!=|\+=|=)"[^"]*"', part), line
        if line.startswith("ATTRS"):
            assert line.endswith('TAG+="uaccess", ENV{ID_MM_DEVICE_IGNORE}="1", ENV{ID_MM_PORT_IGNORE}="1"')
            vendors, products = (re.findall(rf'{{{name}}}=="([^"]+)"', line) for name in ("idVendor", "idProduct"))
            for vendor in vendors[0].split("|"):
                covered |= {f"{vendor}:{product}" for product in "|".join(products).split("|")}
    assert {"0403:6001", "10c4:ea60", "1a86:7523", "1a86:55d4", "067b:2303", *_FLIGHT_CONTROLLERS} <= covered


def test_the_manual_names_every_command() -> None:
    text = (LINUX / "dps-s.1").read_text(encoding="utf-8").replace("\\-", "-")
    listed = text[text.index(".SH COMMANDS") : text.index(".SH OPTIONS")].split(".TP\n")[1:]
    assert listed == [f".B {entry.name}\n{entry.summary}\n" for entry in ENTRIES]
    assert f".B {PORT}" in text


def test_a_release_is_refused_while_a_placeholder_is_left(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(package, "build", lambda: pytest.fail("nothing may be built"))
    if release.refusals():
        assert package.main(["--release"]) == 3
        assert "homepage is a placeholder." in capsys.readouterr().err
    filled = tmp_path / "pyproject.toml"
    filled.write_text(release.PYPROJECT.read_text(encoding="utf-8").replace("localhost", "example.org"), "utf-8")
    monkeypatch.setattr(release, "PYPROJECT", filled)
    assert release.refusals() == []
