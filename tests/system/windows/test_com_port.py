"""The command line over a COM port: a pseudo-terminal with the simulated module in a Linux process behind it."""

import json

import pytest

from tests.support.processes import Running
from tests.system.windows.conftest import PORT, WindowsProgram


@pytest.mark.parametrize("words", ["read", "history", "monitor --seconds 2", "find", "set freefall_time_s=1.6"])
def test_a_command_works_as_elsewhere(words: str, dps_s: WindowsProgram, module: Running) -> None:
    done = dps_s.run(*words.split(), "--port", PORT, "--json")
    assert done.returncode == 0, done.stderr
    said = [json.loads(line) for line in done.stdout.splitlines()]
    expected = {"read": "status", "history": "records", "monitor": "tilt_deg", "find": "baud_rate", "set": "results"}
    assert all(expected[words.split()[0]] in one for one in said)
    assert said


def test_redirected_output_is_utf_8(dps_s: WindowsProgram, module: Running) -> None:
    done = dps_s.run("read", "--port", PORT)
    assert done.returncode == 0, done.stderr
    assert "60°" in done.stdout.replace(" ", "")
    assert "�" not in done.stdout
    assert "…" in dps_s.run("--help").stdout


@pytest.mark.parametrize("code_page", [437, 936])
def test_a_console_shows_every_letter_whatever_its_code_page(dps_s: WindowsProgram, code_page: int) -> None:
    seen = dps_s.on_a_console("ports", code_page=code_page, LANG="zh_CN.UTF-8")
    assert f"code page: {code_page}" in seen
    assert "串口" in seen


def test_a_port_that_is_not_there(dps_s: WindowsProgram) -> None:
    done = dps_s.run("read", "--port", "COM77")
    assert done.returncode == 3
    assert "no port COM77" in done.stderr


def test_a_report_with_a_name_of_any_letters_is_verified(dps_s: WindowsProgram, module: Running) -> None:
    from wine import DRIVE

    (DRIVE / "reports").mkdir(exist_ok=True)
    report = "C:\\reports\\检查 ä.pdf"
    done = dps_s.run("preflight", "--port", PORT, "--enable-triggers", "--report", report)
    assert done.returncode in (0, 1), done.stderr
    assert "INTACT" in dps_s.run("verify", report).stdout
