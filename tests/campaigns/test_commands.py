"""A part of the campaign of commands, another one each day; and that its judge notices what is false."""

import datetime
import json
import sys
from collections.abc import Callable
from copy import copy
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import pytest

from tests.campaigns.commands import Case, Ran, campaign, judge, run, told
from tests.module.line import now
from tests.module.log import GOT, Entry, Log
from tests.module.module import ATTITUDE, ATTITUDE_OFF, Module

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo-terminals")
RUNS = 24


@pytest.mark.promise("i")
def test_a_part_of_the_campaign_finds_nothing(tmp_path: Path) -> None:
    first = RUNS * datetime.datetime.now(datetime.UTC).date().toordinal()
    texts, broken = told(campaign(range(first, first + RUNS), tmp_path))
    assert broken == 0, "\n".join(texts)


Honest = Callable[[str], Ran]
"""Runs this command at an honest module, once for all tests."""


@pytest.fixture(scope="module")
def honest(tmp_path_factory: pytest.TempPathFactory) -> Honest:
    @cache
    def ran(command: str) -> Ran:
        return run(Case(1, command, Module(now=now()), None), tmp_path_factory.mktemp("honest"))

    return ran


@pytest.mark.parametrize(
    ("command", "verdict"), [("check", "READY"), ("check and activate", "GO"), ("set", None), ("read", None)]
)
def test_an_honest_module_gets_what_was_asked_for(command: str, verdict: str | None, honest: Honest) -> None:
    ran = honest(command)
    assert judge(ran) == []
    assert (ran.code, ran.said.get("verdict")) == (0, verdict), ran.err


# What the judge must notice


def _shown(ran: Ran, **changed: Any) -> Ran:
    said = json.loads(json.dumps(ran.said))
    said["settings"] |= changed
    return replace(ran, said=said)


def _got(ran: Ran, frame: str) -> Ran:
    module = copy(ran.case.module)
    module.log = Log()
    module.log += [*ran.case.module.log, Entry(now(), GOT, bytes.fromhex(frame))]
    return replace(ran, case=replace(ran.case, module=module))


FALSE: dict[str, tuple[str, Callable[[Ran], Ran], str]] = {
    "wrong value": ("read", lambda ran: _shown(ran, attitude_threshold_deg=61), "the module holds 60"),
    "activated": ("read", lambda ran: _got(ran, "42 61 10 02 01 13"), "activated unasked"),
    "not held": ("set", lambda ran: replace(ran, held={**ran.held, ATTITUDE: 60}), "called verified"),
    "traceback": ("set", lambda ran: replace(ran, err="Traceback (most recent call last)"), "an error of its own"),
    "READY, off": ("check", lambda ran: replace(ran, held={**ran.held, ATTITUDE_OFF: 1}), "a trigger that is off"),
}


@pytest.mark.parametrize("name", FALSE)
@pytest.mark.promise("i")
def test_a_false_claim_is_noticed(name: str, honest: Honest) -> None:
    command, falsify, said = FALSE[name]
    ran = honest(command)
    assert judge(ran) == []
    assert any(said in one for one in judge(falsify(ran)))
