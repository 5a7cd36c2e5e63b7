"""The status is asked for again only while the module answers anything."""

from app.procedures.ask_status import TRIES, ask_status
from protocol.catalogue import HEARTBEAT, STATUS
from tests.support.line.sim_line import settled_rig


def test_a_silent_module_is_not_asked_again() -> None:
    rig = settled_rig(mute=True)
    began = rig.clock()
    assert not rig.run(ask_status())
    assert rig.clock() - began < 4.5, "three attempts of the question before it, and a heartbeat"
    assert STATUS.query() not in rig.line.requests
    assert rig.line.requests.count(HEARTBEAT.query()) == 1


def test_a_module_that_answers_all_but_the_status_is_asked_again() -> None:
    rig = settled_rig(**{"mute-codes": "32"})
    assert not rig.run(ask_status())
    assert rig.line.requests.count(HEARTBEAT.query()) == TRIES


def test_a_module_that_answers_is_asked_once() -> None:
    rig = settled_rig()
    assert rig.run(ask_status())
    assert rig.line.requests.count(STATUS.query()) == 1
