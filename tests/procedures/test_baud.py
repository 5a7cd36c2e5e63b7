"""Change of baud rate: in all three behaviours (E9) the program says where the module is, and the port is there too."""

from typing import Any

import pytest

from app.engine.conversation import Interrupted
from app.procedures.find import look_for
from app.procedures.write import BaudChanged, SetReply, WriteFault, change_baud
from app.safety.journal import Act, Outcome
from protocol.events import EndReason
from tests.module.options import Options
from tests.module.wire import Question
from tests.support.journals import FakeJournal
from tests.support.line.module_line import ModuleRig

BAUD, ACTIVATION = 0x24, 0x10
RATES = {"old": 115200, "new": 9600}


def change(rig: ModuleRig, journal: FakeJournal) -> BaudChanged:
    return rig.run(change_baud(9600, journal, permit=rig.permit(Act.CHANGE_BAUD)), outlives=True)


@pytest.mark.parametrize(
    ("options", "fault", "heard"),
    [
        ({}, None, SetReply.ACKNOWLEDGED),
        ({"acknowledged_by_one": {BAUD}}, None, SetReply.ACKNOWLEDGED),
        ({"baud_answer": "new"}, None, SetReply.NOTHING),
        ({"baud_answer": "none"}, None, SetReply.NOTHING),
        ({"baud_at_once": False}, WriteFault.AT_RESTART, SetReply.ACKNOWLEDGED),
        ({"lost_sets": {BAUD: -1}}, WriteFault.UNCHANGED, SetReply.NOTHING),
    ],
)
def test_every_behaviour_is_said_as_what_it_is(
    options: dict[str, Any], fault: WriteFault | None, heard: SetReply
) -> None:
    rig, journal = ModuleRig(Options(**options)).begin(), FakeJournal()
    journal.line_length = lambda: len(rig.module.log.sets(BAUD))
    written = change(rig, journal).written
    assert (written.fault, written.heard, written.verified) == (fault, heard, fault is None)
    assert written.read_back == rig.line.baud_rate == rig.module.rate
    assert len(rig.module.log.sets(BAUD)) == 1
    assert rig.conversation.is_going
    assert [detail for _act, _frame, detail in journal.intents] == [RATES]
    outcome = {None: Outcome.CONFIRMED, WriteFault.UNCHANGED: Outcome.REFUSED}.get(fault, Outcome.UNKNOWN)
    assert journal.outcomes == {0: outcome}
    assert journal.sent_before == [0]


def test_a_lost_module_says_how_to_get_it_back_and_stays_written_down() -> None:
    rig, journal = ModuleRig().begin(), FakeJournal()

    def fall_silent(question: Question) -> None:
        if question.code == BAUD:
            rig.module.be_silent(rig.clock() + 0.005, 120.0)

    rig.module.at_frame = fall_silent
    rig.module.options.baud_answer = "none"
    changed = change(rig, journal)
    assert (changed.written.fault, changed.written.read_back) == (WriteFault.MODULE_LOST, None)
    assert "Find the baud rate" in changed.sentence
    assert rig.line.baud_rate == 115200
    assert journal.outcomes == {0: Outcome.UNKNOWN}, "it may have been carried out"
    rig.module.be_silent(rig.clock(), 0.0)
    assert rig.run(look_for(9600, 115200), outlives=True) == rig.module.rate


def test_a_break_in_the_middle_stays_written_down_as_unknown() -> None:
    rig, journal = ModuleRig().begin(), FakeJournal()
    job = rig.job(change_baud(9600, journal, permit=rig.permit(Act.CHANGE_BAUD)), outlives=True)
    rig.step_until(lambda: rig.module.log.sets(BAUD))
    rig.session.close(EndReason.PORT_LOST)
    assert isinstance(job.error, Interrupted)
    assert journal.outcomes == {0: Outcome.UNKNOWN}


@pytest.mark.parametrize("what", ["no permit", "active", "log", "another conversation"])
def test_what_is_not_allowed_is_not_sent(what: str) -> None:
    rig, journal = ModuleRig(), FakeJournal()
    rig.module.settings[ACTIVATION] = what == "active"
    rig.begin()
    permit = None if what == "no permit" else rig.permit(Act.CHANGE_BAUD)
    journal.is_broken = what == "log"
    if what == "another conversation":
        rig.session.treat_as_another()
        rig.begin()
    changed = rig.run(change_baud(9600, journal, permit=permit), outlives=True)
    assert changed.written.fault is WriteFault.NOT_ALLOWED
    assert changed.refusals
    assert changed.sentence.startswith("Nothing was sent. ")
    assert changed.sentence.endswith("The disk is full.") is (what == "log")
    assert not changed.written.is_sent
    assert rig.module.log.sets(BAUD) == []
