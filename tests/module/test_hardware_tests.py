"""The tests of a real module, run at the independent one: else nobody would know that they work before there is one."""

import subprocess
import sys
from pathlib import Path

import pytest

from tests.module.line import Line, now
from tests.module.module import Module
from tests.module.options import Options

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo-terminals")
ROOT = Path(__file__).parents[2]


def hardware_tests(port: str, *words: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "pytest", "-q", "-n", "0", "-p", "no:cacheprovider", "tests/hardware"]
    return subprocess.run(
        [*command, "--port", port, *words], cwd=ROOT, capture_output=True, text=True, timeout=240, check=False
    )


PART = ("-k", "everything or attitude or locks")
"""All of them take half a minute."""


def test_they_pass_at_a_module_that_keeps_to_the_table_and_change_nothing() -> None:
    module = Module(Options(), now=now())
    before = dict(module.settings)
    with Line(module) as line:
        reading = hardware_tests(line.port, *PART)
        assert "1 passed, 2 skipped" in reading.stdout
        writing = hardware_tests(line.port, *PART, "--may-write")
    assert "3 passed" in writing.stdout
    assert module.settings == before


def test_a_module_that_keeps_nothing_is_noticed() -> None:
    module = Module(Options(ignored_sets={0x20: -1}), now=now())
    with Line(module) as line:
        ran = hardware_tests(line.port, "--may-write", "-k", "attitude")
    assert ran.returncode == 1, ran.stdout
