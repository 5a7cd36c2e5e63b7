"""Change of baud rate: in all three behaviours (E9) the program says where the module is, and the port is there too."""

import pytest

from app.engine.conversation import Interrupted
from app.procedures.baud import BaudChanged, change_baud
from app.procedures.find import look_for
from app.procedures.write import SetReply, WriteFault
from app.safety.acts import Act
from app.safety.journal import Outcome
from protocol.events import EndReason
from tests.support.journals import FakeJournal
from tests.support.line.frames import at_frame
from tests.support.line.odd_module import end_faults
from tests.support.line.sim_line import Rig, settled_rig


def rates(journal: FakeJournal) -> list[tuple[int, int]]:
    return [(int(str(detail["old"])), int(str(detail["new"]))) for _act, _frame, detail in journal.intents]


def change(rig: Rig, rate: int, journal: FakeJournal | None = None) -> BaudChanged:
    procedure = change_baud(rate, journal or FakeJournal(), permit=rig.permit(Act.CHANGE_BAUD))
    return rig.run(procedure, outlives=True)


def find(rig: Rig, new_rate: int, old_rate: int) -> int | None:
    return rig.run(look_for(new_rate, old_rate), outlives=True)


def sets(rig: Rig) -> int:
    return sum(request.command.code == 0x24 for request in rig.line.requests)


@pytest.mark.parametrize(
    ("how", "ack", "fault", "heard"),
    [
        ("old", "echo", None, SetReply.ACKNOWLEDGED),
        ("old", "one", None, SetReply.ACKNOWLEDGED),
        ("new", "echo", None, SetReply.NOTHING),
        ("restart", "echo", WriteFault.AT_RESTART, SetReply.ACKNOWLEDGED),
    ],
)
def test_every_behaviour_is_said_as_what_it_is(how: str, ack: str, fault: WriteFault | None, heard: SetReply) -> None:
    rig, journal = settled_rig(baud_ack=how, ack=ack), FakeJournal()
    journal.line_length = lambda: len(rig.line.sent)
    written = change(rig, 9600, journal).written
    assert (written.fault, written.heard, written.verified) == (fault, heard, fault is None)
    assert written.read_back == rig.line.baud_rate == rig.bench.module.baud_rate
    assert sets(rig) == 1
    assert rig.conversation.is_going
    assert rates(journal) == [(115200, 9600)]
    assert journal.outcomes == {0: Outcome.UNKNOWN if fault else Outcome.CONFIRMED}
    assert journal.sent_before[0] < len(rig.line.sent)


def test_a_lost_module_says_how_to_get_it_back_and_stays_written_down() -> None:
    rig, journal = settled_rig(), FakeJournal()
    at_frame(rig.bench, 1, lambda: rig.bench.change(mute=True), code=0x24)
    changed = change(rig, 9600, journal)
    assert (changed.written.fault, changed.written.read_back) == (WriteFault.MODULE_LOST, None)
    assert "Find the baud rate" in changed.sentence
    assert rig.line.baud_rate == 115200
    assert journal.outcomes == {0: Outcome.UNKNOWN}  # it may have been carried out
    end_faults(rig.bench)
    assert find(rig, *reversed(rates(journal)[0])) == 9600


def test_a_break_in_the_middle_stays_written_down_as_unknown() -> None:
    rig, journal = settled_rig(), FakeJournal()
    job = rig.job(change_baud(19200, journal, permit=rig.permit(Act.CHANGE_BAUD)), outlives=True)
    rig.step_until(lambda: sets(rig) == 1)
    rig.session.close(EndReason.PORT_LOST)
    assert isinstance(job.error, Interrupted)
    assert journal.outcomes == {0: Outcome.UNKNOWN}
    assert rates(journal) == [(115200, 19200)]


@pytest.mark.parametrize("what", ["no permit", "active", "log", "another conversation"])
def test_what_is_not_allowed_is_not_sent(what: str) -> None:
    rig, journal = settled_rig(active=what == "active"), FakeJournal()
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
    assert sets(rig) == 0
