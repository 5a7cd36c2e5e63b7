"""Every example of docs/integrating.md runs against the independent module, and prints what the page says."""

import doctest
import json
import re
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.module.line import Line, now
from tests.module.module import Module
from tests.support.processes import ROOT, environment, ran_code

PAGE = (ROOT / "docs" / "integrating.md").read_text(encoding="utf-8")
PYTHON = re.findall(r"```python\n(.*?)```\n\n```text\n(.*?)```", PAGE, re.DOTALL)
(SHELL,) = re.findall(r"```sh\n(.*?)```", PAGE, re.DOTALL)
PROFILE = 'format = 1\nname = "Survey"\n[settings]\nattitude_threshold_deg = 65\nfreefall_time_s = 1.4\n'
pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo-terminals")


def module(boots: int = 1) -> Module:
    one = Module(now=now())
    one.readings.boots = boots
    return one


@pytest.mark.parametrize(("code", "said"), PYTHON, ids=["app", "protocol"])
def test_an_example_in_python_prints_what_the_page_says(code: str, said: str) -> None:
    one = module()
    with Line(one) as line:
        done = ran_code(code.replace("/dev/ttyUSB0", line.port), LC_ALL="C.UTF-8")
    assert done.stderr == ""
    assert doctest.OutputChecker().check_output(said, done.stdout, doctest.ELLIPSIS), done.stdout
    assert one.log.acts() == []


def test_the_link_needs_no_more_than_the_page_says() -> None:
    code = PYTHON[1][0]
    assert "import serial" in code
    assert len(code.splitlines()) <= 24


def test_a_production_line_names_what_it_checked(tmp_path: Path) -> None:
    """A person moves the plug when told to."""
    first, second = module(3), module(7)
    (tmp_path / "survey.toml").write_text(PROFILE, encoding="utf-8")
    script = f'set -e\ndps-s() {{ "{sys.executable}" -m app "$@"; }}\n{SHELL.replace("--timeout 600", "--timeout 60")}'
    with Line(first) as line, subprocess.Popen(
        ["bash", "-c", script], cwd=tmp_path, encoding="utf-8", stderr=subprocess.PIPE,
        env=environment(DPS_S_PORT=line.port, LC_ALL="C.UTF-8", QT_QPA_PLATFORM="offscreen"),
    ) as hall:  # fmt: skip
        said = []
        assert hall.stderr is not None
        for told in hall.stderr:
            said.append(told)
            if "UNPLUG" in told and line.modules == (first,):
                line.modules = ()
                time.sleep(0.7)
                line.modules = (second,)
        assert hall.wait() == 0, "".join(said)
    batch = json.loads((tmp_path / "batch.json").read_text("utf-8"))
    assert batch["complete"] is True
    assert [one["name"] for one in batch["modules"]] == ["M-001", "M-002"]
    assert (tmp_path / "labels.pdf").read_bytes().startswith(b"%PDF")
    report = json.loads((tmp_path / "report.json").read_text("utf-8"))
    assert {one["module"] for one in report["modules"]} == {"M-001", "M-002"}
    assert "M-001" in (tmp_path / "M-001.json").read_text("utf-8")
    assert "ports" in json.loads((tmp_path / "ports.json").read_text("utf-8"))
    for one in (first, second):
        assert (one.settings[0x20], one.settings[0x22]) == (65, 140)
        assert one.log.acts() == []
