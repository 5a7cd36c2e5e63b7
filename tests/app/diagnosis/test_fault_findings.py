"""Regressions found by the table of faults."""

import os
import subprocess
import sys

import pytest

from app.engine.device import Device, StaleReason
from app.engine.procedure import Ask, Cancelled, Procedure
from app.engine.session import Run
from app.engine.transport import holder_of
from protocol.catalogue import BY_NAME, SERIAL_OUTPUT, STATUS
from protocol.events import Answered, OutcomeUnknown
from protocol.link import Link
from protocol.messages import Acknowledgement
from tests.support.line.sim_line import Rig

THRESHOLD = BY_NAME["attitude_threshold"]


def ask(*requests: Ask) -> Procedure[list[object]]:
    outcomes: list[object] = []
    for one in requests:
        outcome = yield one
        outcomes.append(outcome)
    return outcomes


def test_an_abandoned_act_has_an_unknown_outcome() -> None:
    link = Link(0.0)
    link.ask(THRESHOLD.set(75), 0.0)
    assert link.abandon(0.5) == [OutcomeUnknown(THRESHOLD.set(75), 0.5, 0.5)]
    link.ask(STATUS.query(), 1.0)
    assert link.abandon(1.5) == []
    assert link.abandon(1.6) == []


def test_an_act_that_waits_for_its_heartbeat_was_not_sent() -> None:
    link = Link(0.0)
    link.ask(THRESHOLD.set(75), 0.0)
    link.abandon(0.1)
    link.ask(THRESHOLD.set(70), 0.2)  # after a heartbeat, because the first may still be answered
    assert link.abandon(0.3) == []


@pytest.mark.parametrize(("is_sent", "reason"), [(True, StaleReason.WRITE_UNCONFIRMED), (False, None)])
def test_a_write_that_is_cancelled_makes_the_known_value_stale_if_it_was_sent(
    is_sent: bool, reason: StaleReason | None
) -> None:
    rig = Rig()
    rig.run(ask(Ask(THRESHOLD.query())))
    rig.bench.change(mute=not is_sent)
    run = Run(ask(Ask(THRESHOLD.set(75))))
    rig.session.run(run)
    rig.session.step()
    if is_sent:
        rig.step_until(lambda: THRESHOLD.set(75) in rig.line.requests)
    run.cancel()
    rig.step_until(lambda: run.is_done)
    assert isinstance(run.error, Cancelled)
    assert (THRESHOLD.set(75) in rig.line.requests) is is_sent
    known = rig.session.device.value(THRESHOLD.key)
    assert known is not None
    assert known.stale_reason is reason


def test_a_second_cancel_does_not_interrupt_the_cleanup() -> None:
    def careful() -> Procedure[str]:
        try:
            yield Ask(STATUS.query(), (5.0,))
        except Cancelled:
            yield Ask(SERIAL_OUTPUT.set(False))
            return "cleaned up"
        return "not cancelled"

    rig = Rig({"delay_ms": "300"})
    run = Run(careful())
    rig.session.run(run)
    rig.session.step()
    for _ in range(200):
        run.cancel()
        rig.session.step()
    assert run.result == "cleaned up"


@pytest.mark.parametrize(("name", "value", "key"), [("deploy", True, "triggered"), ("zero_sensor", None, "tilt_deg")])
@pytest.mark.parametrize("is_answered", [True, False])
def test_values_reported_before_an_act_are_stale_after_it(
    name: str, value: bool | None, key: str, is_answered: bool
) -> None:
    command = BY_NAME[name]
    request = command.query() if value is None else command.set(value)
    rig = Rig({"active": "yes", "tilt": "4"})
    rig.run(ask(Ask(STATUS.query())))
    device: Device = rig.session.device
    if is_answered:
        device.apply(Answered(request, (Acknowledgement(request, 0x01),), 1, None, rig.clock.now_s))
    else:
        device.apply(OutcomeUnknown(request, 1.0, rig.clock.now_s))
    known = device.value(key)
    assert known is not None
    assert known.stale_reason is StaleReason.WRITE_UNCONFIRMED


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="/proc is Linux's")
def test_a_process_without_access_does_not_hide_another() -> None:
    master, slave = os.openpty()
    name = os.ttyname(slave)
    os.close(slave)
    code = "import sys; file = open(sys.argv[1]); print('open', flush=True); sys.stdin.read()"
    with subprocess.Popen(
        [sys.executable, "-c", code, name], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as other:
        try:
            assert other.stdout is not None
            assert other.stdout.readline() == "open\n"
            holder = holder_of(name)
            assert holder is not None
            assert holder.pid == other.pid
            assert holder_of("/dev/null-that-is-not-there") is None
        finally:
            other.communicate("", timeout=10)
            os.close(master)
