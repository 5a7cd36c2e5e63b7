"""How often the module is asked for its status before and after an act."""

from typing import Any

import pytest

from app.procedures.act import READINGS, REPORTS_EVERY_S, WATCH_S, perform
from app.safety.acts import REQUESTS, Act
from app.safety.permit import Origin, Permit
from protocol.catalogue import STATUS
from tests.support.journals import FakeJournal
from tests.support.line.sim_line import Rig


def do(rig: Rig, act: Act) -> None:
    rig.run(perform(act, FakeJournal(), permit=Permit(act, Origin.CONFIRMATION, rig.clock())))


@pytest.mark.parametrize(("options", "fences"), [({}, 0), ({"mute_codes": frozenset((0x10,))}, 1)])
def test_only_the_first_report_after_an_unanswered_act_waits_behind_another_question(
    options: dict[str, Any], fences: int
) -> None:
    rig = Rig(options)
    do(rig, Act.ACTIVATE)
    sent = rig.line.requests
    afterwards = sent[sent.index(REQUESTS[Act.ACTIVATE]) + 1 :]
    assert len([request for request in afterwards if request != STATUS.query()]) == fences
    assert afterwards[fences:] == [STATUS.query()] * READINGS


def test_before_zeroing_reports_are_asked_for_at_a_steady_pace() -> None:
    rig = Rig({"tilt": 4})
    do(rig, Act.ZERO)
    reports = rig.line.requests.count(STATUS.query())
    assert 0.9 < reports / (WATCH_S / REPORTS_EVERY_S) < 1.2, reports
