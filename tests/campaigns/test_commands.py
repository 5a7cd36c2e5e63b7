"""A part of the campaign of commands, another one each day; and that its judge notices what is false."""

import datetime
from pathlib import Path

import pytest

from tests.campaigns.commands import Case, campaign, judge
from tests.support.virtual_cli import VirtualCli

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


# What becomes otherwise after the command, and what the judge says then.
