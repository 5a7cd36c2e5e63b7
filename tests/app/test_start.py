"""The start of an installed program: whether its packages are its own."""

import subprocess
import sys
from pathlib import Path

import pytest

from app import start

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


@pytest.mark.parametrize("name", ["app", "protocol", "ui"])
def test_a_package_that_another_program_took_along_is_noticed(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(start.OURS, name, "what_only_another_has.py")
    assert f"“{name}” in " in (start.foreign_package() or "")
