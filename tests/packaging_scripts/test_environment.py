"""The .venv of a checkout, with pip and venv replaced by recorders; the real ones are the user's and CI's."""

import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.support.setup_files import SetupFiles


class Checkout:
    """A checkout in a temporary folder in which programs are recorded instead of run."""

    def __init__(self, root: Path, setup: SetupFiles, patch: pytest.MonkeyPatch) -> None:
        self.environment = setup.environment
        self.commands: list[list[str]] = []
        self.failing: str | None = None
        self.printed = ""
        self.uv: str | None = None
        self.lock = root / "packaging" / "lock.txt"
        self.lock.parent.mkdir(parents=True)
        self.lock.write_text(LOCK, encoding="utf-8")
        (root / "pyproject.toml").write_text("[project]\n", encoding="utf-8")
        self.venv = root / ".venv"
        self.python = self.venv / "bin" / "python"
        places = {
            "ROOT": root,
            "LOCK": self.lock,
            "PYPROJECT": root / "pyproject.toml",
            "VENV": self.venv,
            "BIN": self.python.parent,
            "VENV_PYTHON": self.python,
            "STAMP": self.venv / "bootstrap.json",
        }
        for name, path in places.items():
            patch.setattr(setup.environment, name, path)
        patch.setattr(subprocess, "run", self._run)
        patch.setattr(setup.environment, "_runs", self.python.exists)
        patch.setattr(shutil, "which", lambda _name: self.uv)

    def _run(self, command: list[str], **_: object) -> "subprocess.CompletedProcess[str]":
        self.commands.append(command)
        has_failed = self.failing is not None and self.failing in command
        if "venv" in command and not has_failed:
            self.python.parent.mkdir(parents=True)
            self.python.touch()
        return subprocess.CompletedProcess(command, returncode=int(has_failed), stdout=self.printed)

    def make_ready(self, extent: str = "everything") -> list[str]:
        """Make .venv ready; the kinds of programs that were run for it."""
        self.commands.clear()
        self.environment.make_ready(extent)
        return [next(word for word in ("venv", "install", "check") if word in command) for command in self.commands]


@pytest.fixture
def checkout(tmp_path: Path, setup: SetupFiles, monkeypatch: pytest.MonkeyPatch) -> Checkout:
    return Checkout(tmp_path / "a checkout", setup, monkeypatch)


LOCK = "numpy==1.0\n\n# what building and testing it need\npytest==1.0\n"
WHOLE = ["venv", "install", "install", "check"]
PACKAGES_ONLY = ["install", "install", "check"]


def test_the_first_call_makes_all_and_the_second_nothing(checkout: Checkout) -> None:
    assert checkout.make_ready() == WHOLE
    assert checkout.make_ready() == []


def test_pip_gets_the_lock_and_no_address(checkout: Checkout) -> None:
    checkout.make_ready()
    words = [word for command in checkout.commands for word in command]
    assert str(checkout.venv / "requirements.txt") in words
    assert (checkout.venv / "requirements.txt").read_text(encoding="utf-8") == "numpy==1.0\npytest==1.0\n"
    assert not [word for word in words if "://" in word or "index" in word]


def test_uv_installs_where_it_is_there_and_pip_where_uv_cannot(checkout: Checkout) -> None:
    checkout.uv = "/home/u/.local/bin/uv"
    assert checkout.make_ready() == WHOLE
    assert [command[:3] for command in checkout.commands[1:]] == [[checkout.uv, "pip", word] for word in WHOLE[1:]]
    assert all(str(checkout.python) in command for command in checkout.commands[1:])
    (checkout.venv / "bootstrap.json").unlink()
    checkout.failing = checkout.uv
    assert checkout.make_ready()[-2:] == ["check", "check"]
    assert checkout.commands[-1][:3] == [str(checkout.python), "-m", "pip"]


def test_the_program_alone_needs_less_and_the_rest_comes_when_it_is_wanted(checkout: Checkout) -> None:
    assert checkout.make_ready("program") == WHOLE
    assert (checkout.venv / "requirements.txt").read_text(encoding="utf-8") == "numpy==1.0\n"
    assert checkout.make_ready("program") == []
    assert checkout.make_ready() == PACKAGES_ONLY
    assert checkout.make_ready("program") == [], "everything is enough for the program"


@pytest.mark.parametrize("name", ["packaging/lock.txt", "pyproject.toml"])
def test_what_changed_is_installed_into_the_same_venv(checkout: Checkout, name: str) -> None:
    checkout.make_ready()
    (checkout.venv.parent / name).write_text("# changed\n", encoding="utf-8")
    assert checkout.make_ready() == PACKAGES_ONLY
    assert checkout.make_ready() == []


def test_an_interrupted_installation_is_rebuilt(checkout: Checkout, setup: SetupFiles) -> None:
    checkout.failing, checkout.printed = "--editable", "no space left"
    with pytest.raises(setup.environment.SetupError, match="no space left"):
        checkout.make_ready()
    (checkout.venv / "half").touch()
    checkout.failing = None
    assert checkout.make_ready() == WHOLE
    assert not (checkout.venv / "half").exists()


def test_an_interrupted_update_is_rebuilt(checkout: Checkout, setup: SetupFiles) -> None:
    checkout.make_ready()
    checkout.lock.write_text("# changed\n", encoding="utf-8")
    checkout.failing = "--requirement"
    with pytest.raises(setup.environment.SetupError):
        checkout.make_ready()
    checkout.failing = None
    assert checkout.make_ready() == WHOLE


def _remove_python(checkout: Checkout, patch: pytest.MonkeyPatch) -> None:
    checkout.python.unlink()


def _spoil_stamp(checkout: Checkout, patch: pytest.MonkeyPatch) -> None:
    checkout.environment.STAMP.write_text("{", encoding="utf-8")


def _take_other_python(checkout: Checkout, patch: pytest.MonkeyPatch) -> None:
    kept = checkout.environment.wanted_stamp("everything")
    patch.setattr(checkout.environment, "wanted_stamp", lambda extent: {**kept, "python": "cpython 3.99"})


def _move(checkout: Checkout, patch: pytest.MonkeyPatch) -> None:
    moved = checkout.venv.parent / "moved"
    moved.mkdir()
    patch.setattr(checkout.environment, "ROOT", moved)


@pytest.mark.parametrize("harm", [_remove_python, _spoil_stamp, _take_other_python, _move])
def test_a_venv_that_does_not_fit_is_rebuilt(
    checkout: Checkout, monkeypatch: pytest.MonkeyPatch, harm: Callable[[Checkout, pytest.MonkeyPatch], None]
) -> None:
    checkout.make_ready()
    harm(checkout, monkeypatch)
    assert checkout.make_ready() == WHOLE
    assert checkout.make_ready() == []


def test_a_venv_that_somebody_else_made_is_rebuilt(checkout: Checkout) -> None:
    checkout.python.parent.mkdir(parents=True)
    checkout.python.touch()
    assert checkout.make_ready() == WHOLE


def test_a_folder_that_cannot_be_written_is_reported(checkout: Checkout, setup: SetupFiles) -> None:
    checkout.venv.symlink_to(checkout.venv.parent / "nowhere" / "else")
    checkout.make_ready()  # a link that leads nowhere is replaced
    assert not checkout.venv.is_symlink()

    def refuse(*_: object, **__: object) -> None:
        raise PermissionError(13, "Permission denied")

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(checkout.environment, "_rebuild", refuse)
        checkout.python.unlink()
        with pytest.raises(setup.environment.SetupError, match="cannot be created"):
            checkout.make_ready()
