"""Whose turn it is on the line: queued, urgent, in the background, cancelled, broken off; and what never leaves."""

import pytest

from app.engine.procedure import Ask, Cancelled, PortLost, Procedure
from app.engine.session import Run
from app.engine.transport import PortError, PortTrouble
from app.procedures.find import find_rate
from app.procedures.handshake import handshake
from app.procedures.lock import lock
from app.procedures.read import read_everything
from protocol.catalogue import BY_NAME, HEARTBEAT
from tests.support.line.sim_line import settled_rig, watched


def test_lock_is_sent_once_and_believed_only_when_the_module_says_so() -> None:
    rig = settled_rig(active=True)
    locked = rig.run(lock())
    assert (locked.is_acknowledged, locked.is_locked) == (True, True)
    assert [request.command.name for request in rig.line.requests] == ["activation", "active", "status"]
    assert not rig.bench.state().is_active


def test_no_read_gathers_while_an_answer_is_awaited() -> None:
    rig = settled_rig()
    read, gathered = rig.line.read, list[float]()

    def noted(longest_s: float, gather_s: float) -> bytes:
        gathered.append(gather_s)
        return read(longest_s, gather_s)

    rig.line.read = noted  # type: ignore[method-assign]
    rig.run(read_everything())
    assert set(gathered) == {0.0}


def test_a_cancelled_procedure_ends_at_once() -> None:
    rig = settled_rig(mute=True)
    run = Run(read_everything())
    rig.session.run(run)
    rig.step_for(0.1)
    run.cancel()
    start_s = rig.clock.now_s
    rig.step_until(lambda: run.is_done)
    assert rig.clock.now_s - start_s < 0.1
    assert isinstance(run.error, Cancelled)


def test_a_lost_port_ends_every_procedure() -> None:
    rig = settled_rig()
    watched(rig)
    run = Run(find_rate())
    rig.session.run(run)
    rig.bench.unplug()
    with pytest.raises(PortError) as lost:
        rig.step_for(1)
    assert lost.value.trouble is PortTrouble.LOST
    rig.session.close(why=lost.value)
    assert run.error is lost.value
    assert rig.line.is_closed
    assert all(known.is_stale for known in rig.session.device.view(0).values.values())


def test_closing_without_a_reason_says_port_lost() -> None:
    rig = settled_rig(mute=True)
    run = Run(handshake())
    rig.session.run(run)
    rig.session.close()
    rig.session.close()
    assert isinstance(run.error, PortLost)


def test_a_second_procedure_waits_for_the_first() -> None:
    rig = settled_rig()
    first, second = Run(read_everything()), Run(handshake())
    rig.session.run(first)
    rig.session.run(second)
    rig.step_until(lambda: first.is_done)
    assert not second.is_done
    rig.step_until(lambda: second.is_done)
    assert rig.line.requests[-1] == HEARTBEAT.query()


def test_an_urgent_procedure_goes_first_and_the_others_go_on() -> None:
    rig = settled_rig(active=True, **{"mute-codes": "14"})
    rig.run(handshake())
    reading, locking = Run(read_everything()), Run(lock())
    rig.session.run(reading)
    rig.step_until(lambda: rig.line.requests[-1].command.name == "light")
    start_s = rig.clock.now_s
    rig.session.run(locking, is_urgent=True)
    rig.step_until(lambda: locking.is_done)
    assert rig.clock.now_s - start_s < 0.1
    assert not rig.bench.state().is_active
    rig.step_until(lambda: reading.is_done)
    assert reading.result is not None
    assert list(reading.result.errors) == ["light_v"]


def test_the_background_does_not_hold_up_the_foreground() -> None:
    rig = settled_rig(**{"mute-codes": "14,32,33,34"})
    watched(rig)
    rig.step_for(0.05)
    start_s = rig.clock.now_s
    assert rig.run(handshake()).is_answered
    assert rig.clock.now_s - start_s < 0.1


def test_a_bug_in_a_procedure_ends_only_that_procedure() -> None:
    def broken() -> Procedure[None]:
        yield from handshake()
        raise ZeroDivisionError

    rig = settled_rig()
    with pytest.raises(ZeroDivisionError):
        rig.run(broken())
    assert rig.run(handshake()).is_answered


def test_a_dangerous_request_never_leaves_without_an_explicit_act() -> None:
    def careless() -> Procedure[None]:
        yield Ask(BY_NAME["zero_sensor"].query())

    rig = settled_rig()
    with pytest.raises(ValueError, match="explicit act"):
        rig.run(careless())
    assert rig.line.sent == b""
