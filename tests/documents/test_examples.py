"""What README.md, docs/flight-logs.md and docs/integrating.md show can be done, and says what they say."""

import doctest
import json
import re
import shlex
import sys
from pathlib import Path

import numpy as np
import pytest

from app import __main__ as program
from tests.module.line import Line, now
from tests.module.module import Module
from tests.support.flights import log_bytes as made
from tests.support.processes import ROOT, ran_code
from tests.support.virtual_cli import PORT, VirtualCli

FLIGHT_LOGS = (ROOT / "docs" / "flight-logs.md").read_text(encoding="utf-8")
INTEGRATING = (ROOT / "docs" / "integrating.md").read_text(encoding="utf-8")
PYTHON = re.findall(r"```python\n(.*?)```\n\n```text\n(.*?)```", INTEGRATING, re.DOTALL)
(SHELL,) = re.findall(r"```sh\n(.*?)```", INTEGRATING, re.DOTALL)
PROFILE = 'format = 1\nname = "Survey"\n[settings]\nattitude_threshold_deg = 65\nfreefall_time_s = 1.4\n'
TIMES = np.arange(0, 20, 0.1)


@pytest.mark.usefixtures("qapp")  # what is printed otherwise makes an application of its own
def test_every_command_of_the_readme_does_what_it_says(tmp_path: Path) -> None:
    """One after the other, as some use what one before has left; the simulated module's check is NO-GO, code 1."""
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    lines = re.findall(r"(?m)^\.venv/bin/dps-s (\S.*?)\s+#", text)
    assert len(lines) > 5
    cli = VirtualCli()
    for line in lines:
        words = [str(tmp_path / word) if word.endswith((".toml", ".pdf")) else word for word in shlex.split(line)]
        done = cli.run(*words, port="", HOME=str(tmp_path))
        assert done.code == (1 if words[0] == "preflight" else 0), f"{line}: {done.err}"


# Flight logs


def flight_log_examples() -> list[list[str]]:
    """Each command line, and what it prints with its exit code."""
    block = re.findall(r"^```\n(.*?)^```", FLIGHT_LOGS, re.DOTALL | re.MULTILINE)[0]
    return [part.split("\n", 1) for part in block.split("$ dps-s ")[1:]]


@pytest.fixture
def logs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    tilts = np.where(TIMES >= 12.35, 61.2, 5.0)
    Path("crash.ulg").write_bytes(made.ulog_bytes(TIMES, tilts, 1.0))
    for name, head, per_s, rest in (
        ("calm.csv", "time_s,tilt_deg,acceleration_g", 1, ",1"),
        ("tilt-only.csv", "time_s,tilt_deg", 1, ""),
        ("odd.csv", "when,angle,load", 1000, ",1"),
    ):
        rows = "".join(f"{at_s * per_s:.1f},5{rest}\n" for at_s in TIMES)
        Path(name).write_text(f"{head}\n{rows}", encoding="utf-8")


@pytest.mark.usefixtures("logs")
@pytest.mark.parametrize(("line", "said"), flight_log_examples())
def test_an_example_of_flight_logs_prints_what_the_page_says(
    line: str, said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    code = program.main(shlex.split(line))
    assert f"{capsys.readouterr().out}(exit code {code})\n" == said


# Integrating


def test_the_example_of_the_integration_prints_what_the_page_says(capsys: pytest.CaptureFixture[str]) -> None:
    (code, said), cli = PYTHON[0], VirtualCli()
    with cli.in_time():
        exec(code.replace("/dev/ttyUSB0", PORT), {})
    assert doctest.OutputChecker().check_output(said, capsys.readouterr().out, doctest.ELLIPSIS)
    assert cli.module.log.acts() == []


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo-terminals")
def test_the_example_of_the_protocol_prints_what_the_page_says() -> None:
    """In real time: again where the machine stood still for a moment."""
    code, said = PYTHON[1]
    for _ in range(3):
        with Line(Module(now=now())) as line:
            done = ran_code(code.replace("/dev/ttyUSB0", line.port), LC_ALL="C.UTF-8")
        if is_right := doctest.OutputChecker().check_output(said, done.stdout, doctest.ELLIPSIS):
            break
    assert is_right, done.stdout + done.stderr


@pytest.mark.usefixtures("qapp")
def test_a_production_line_names_what_it_checked(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A person moves the plug when told to."""
    monkeypatch.chdir(tmp_path)
    Path("survey.toml").write_text(PROFILE, encoding="utf-8")
    cli = VirtualCli()
    first, second = cli.module, Module(now=cli.clock())
    second.readings.boots = 7

    def obey() -> None:
        if "UNPLUG" in cli.told:
            cli.modules[:] = [second]
            cli.line.move(second, 0.7, is_announced=True)
        else:
            cli.line.plan(0.2, obey)

    for line in SHELL.replace("\\\n", " ").splitlines():
        words, _, file = re.sub(r"\s#.*", "", line).removeprefix("dps-s ").partition(" > ")
        is_provision = words.startswith("provision")
        ran = cli.run(
            *shlex.split(words.replace("$DPS_S_PORT", PORT)), port="", meanwhile=obey if is_provision else None
        )
        assert ran.code == 0, ran.err
        Path(file.strip()).write_text(ran.out, encoding="utf-8")
    batch, report, history, ports = (json.loads(Path(f"{name}.json").read_text(encoding="utf-8"))
                                     for name in ("batch", "report", "M-001", "ports"))  # fmt: skip
    assert (batch["complete"], [one["name"] for one in batch["modules"]]) == (True, ["M-001", "M-002"])
    assert Path("labels.pdf").read_bytes().startswith(b"%PDF")
    assert {one["module"] for one in report["modules"]} == {"M-001", "M-002"}
    assert history["events"]
    assert "ports" in ports
    for one in (first, second):
        assert (one.settings[0x20], one.settings[0x22]) == (65, 140)
        assert one.log.acts() == []
