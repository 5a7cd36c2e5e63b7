"""Where Qt or another package is not installed: every command but the window works, or names what is missing."""

import json
from pathlib import Path

import pytest

from tests.support.processes import ran_code

QT = ("PySide6", "shiboken6", "pyqtgraph")
OTHERS = ("cryptography", "jinja2", "mcap", "numpy", "segno", "shtab", "tomlkit", "zstandard", "psycopg")
_WITHOUT = """
import sys

missing = sys.argv.pop(1).split()

class Blocker:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in missing:
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)

sys.meta_path.insert(0, Blocker())
from dps_s_configurator import main
sys.exit(main())
"""
ENTRY = str(Path(__file__).parents[2] / "packaging" / "entry")


def without(packages: tuple[str, ...], *words: str) -> "tuple[int, str, str]":
    done = ran_code(_WITHOUT, " ".join(packages), *words, PYTHONPATH=ENTRY, LC_ALL="C.UTF-8")
    return done.returncode, done.stdout, done.stderr


@pytest.mark.parametrize(
    "line",
    ["history", "preflight"],
)
def test_a_command_on_a_port_needs_no_qt(line: str) -> None:
    code, out, errors = without(QT, *line.split(), "--port", "sim://", "--json")
    assert code in (0, 1), errors
    assert "error" not in json.loads(out.splitlines()[-1])


@pytest.mark.parametrize("line", ["read", "set freefall_time_s=1.4", "lock", "monitor --seconds 0.1", "find"])
def test_three_packages_are_enough_to_read_and_write(line: str) -> None:
    """As docs/integrating.md says: pyserial, msgspec and platformdirs."""
    code, out, errors = without((*QT, *OTHERS), *line.split(), "--port", "sim://", "--json")
    assert code == 0, errors
    assert out.startswith("{")


def test_no_command_needs_qt_to_be_imported() -> None:
    code, out, _ = without(QT, "completion", "bash")  # knows all commands with their options
    assert code == 0
    assert "monitor" in out


@pytest.mark.parametrize(
    ("packages", "words", "missing"),
    [
        (QT, [], "PySide6"),
        (("serial",), ["read", "--port", "sim://"], "serial"),
        (("msgspec",), ["read", "--port", "sim://"], "msgspec"),
        (("platformdirs",), ["lock", "--port", "sim://"], "platformdirs"),
        ((*QT, "serial", "msgspec", "platformdirs", "numpy", "tomlkit", "mcap", "cryptography"), ["ports"], "msgspec"),
    ],
)
def test_what_is_missing_is_named(packages: tuple[str, ...], words: list[str], missing: str) -> None:
    code, _, errors = without(packages, *words)
    assert code == 1, errors
    assert errors == f"The Python package {missing} is missing. Install the program again.\n"


def test_the_report_without_qt_says_so_and_the_check_counts(tmp_path: Path) -> None:
    words = ("preflight", "--port", "sim://", "--report", str(tmp_path / "check.pdf"))
    code, out, errors = without(QT, *words)
    assert code == 1
    assert out.startswith("NO-GO")
    assert "PySide6" in errors
    assert "Traceback" not in errors
