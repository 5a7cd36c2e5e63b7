"""A part of the campaign of commands, another one each day; and that its judge notices what is false."""

import datetime
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.campaigns.commands import Case, campaign, judge
from tests.module.log import GOT, Entry
from tests.module.module import ATTITUDE, ATTITUDE_OFF
from tests.support.virtual_cli import Ran, VirtualCli

RUNS = 60


@pytest.mark.promise("i")
def test_a_part_of_the_campaign_finds_nothing(tmp_path: Path) -> None:
    first = RUNS * datetime.datetime.now(datetime.UTC).date().toordinal()
    assert campaign(range(first, first + RUNS), tmp_path)[1] == []


@pytest.mark.parametrize(
    ("command", "verdict"), [("check", "READY"), ("check and activate", "GO"), ("set", None), ("read", None)]
)
def test_an_honest_module_gets_what_was_asked_for(command: str, verdict: str | None, tmp_path: Path) -> None:
    case = Case(1, command, VirtualCli())
    ran = case.run(tmp_path)
    assert judge(ran, case) == []
    assert (ran.returncode, ran.said.get("verdict")) == (0, verdict), ran.stderr


def _hears(case: Case, frame: str) -> None:
    case.module.log.add(Entry(case.cli.clock.now_s, GOT, bytes.fromhex(frame)))


# What becomes otherwise after the command, and what the judge says then.
FALSE: dict[str, tuple[str, Callable[[Ran, Case], object], str]] = {
    "wrong value": ("read", lambda _ran, case: case.module.settings.update({ATTITUDE: 61}), "the module holds 61"),
    "activated": ("read", lambda _ran, case: _hears(case, "42 61 10 02 01 13"), "activated unasked"),
    "not held": ("set", lambda _ran, case: case.module.settings.update({ATTITUDE: 60}), "called verified"),
    "traceback": ("set", lambda ran, _case: setattr(ran, "stderr", "Traceback (most"), "an error of its own"),
    "READY, off": ("check", lambda _ran, case: case.module.settings.update({ATTITUDE_OFF: 1}), "a trigger that is off"),
}


@pytest.mark.parametrize("name", FALSE)
@pytest.mark.promise("i")
def test_a_false_claim_is_noticed(name: str, tmp_path: Path) -> None:
    command, falsify, said = FALSE[name]
    case = Case(1, command, VirtualCli())
    ran = case.run(tmp_path)
    assert judge(ran, case) == []
    falsify(ran, case)
    assert any(said in one for one in judge(ran, case))
