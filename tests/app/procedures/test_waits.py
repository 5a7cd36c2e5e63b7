"""The stream while it is watched, reports around an act, and what they say of it."""

from typing import Any

import pytest

from app.engine.device import StatusSample
from app.engine.procedure import Cancelled
from app.procedures.act import READINGS, ZEROED_WITHIN_DEG, Performed, _Observed, _outcome, perform
from app.procedures.stream import StreamSwitch
from app.procedures.who_is_there import who_is_there
from app.safety.acts import REQUESTS, Act
from app.safety.journal import Outcome
from protocol.catalogue import HEARTBEAT, SERIAL_OUTPUT, STATUS, Request
from tests.support.journals import FakeJournal
from tests.support.line.frames import at_each_frame
from tests.support.line.sim_line import Rig, end_watch, settled_rig, watched

ON, OFF = SERIAL_OUTPUT.set(True), SERIAL_OUTPUT.set(False)


@pytest.mark.parametrize(("off_after_s", "frames"), [(1.4, [ON, OFF, ON]), (1.6, [ON, OFF])])
def test_a_stream_that_does_not_begin_within_a_second_and_a_half_is_not_switched_on_again(
    off_after_s: float, frames: list[Request]
) -> None:
    rig, switch = settled_rig(stream="acknowledged"), StreamSwitch()
    watched(rig, switch)
    rig.step_until(lambda: ON in rig.line.requests)
    assert rig.clock() - rig.session.opened_at == pytest.approx(2.2, abs=0.1)
    rig.step_for(off_after_s)
    switch.is_wanted = False
    rig.step_for(0.15)
    switch.is_wanted = True
    rig.step_for(0.15)
    assert [request for request in rig.line.requests if request in (ON, OFF)] == frames


def test_off_is_sent_three_times_to_a_module_that_does_not_answer_it() -> None:
    rig = settled_rig()
    watched(rig)
    rig.step_for(4)
    rig.bench.change(mute_codes=frozenset({SERIAL_OUTPUT.code}))
    background = rig.session.background
    end_watch(rig)
    assert rig.line.requests.count(OFF) == 3
    assert background is not None
    assert isinstance(background.error, Cancelled)


def test_a_module_that_answers_is_asked_once() -> None:
    rig = settled_rig()
    assert rig.run(who_is_there())
    assert rig.line.requests.count(STATUS.query()) == 1


# Reports before and after an act


def do(rig: Rig, act: Act) -> None:
    rig.run(perform(act, FakeJournal(), permit=rig.permit(act)))


def test_a_module_counts_as_on_after_two_answers_half_a_second_apart() -> None:
    """A doubled reply to an earlier heartbeat answers once."""
    rig = Rig({"shuts_down": False})
    sent: list[tuple[float, Request]] = []
    at_each_frame(rig.bench, lambda request: sent.append((rig.clock(), request)))
    do(rig, Act.SHUTDOWN)
    frames = [request for _, request in sent]
    beats_s = [at for at, request in sent[frames.index(REQUESTS[Act.SHUTDOWN]) :] if request == HEARTBEAT.query()]
    assert beats_s[1] - beats_s[0] > 0.5


@pytest.mark.parametrize(("options", "fences"), [({}, 0), ({"mute_codes": frozenset((0x10,))}, 1)])
def test_only_the_first_report_after_an_unanswered_act_waits_behind_another_question(
    options: dict[str, Any], fences: int
) -> None:
    rig = Rig(options)
    do(rig, Act.ACTIVATE)
    sent = rig.line.requests
    afterwards = sent[sent.index(REQUESTS[Act.ACTIVATE]) + 1 :]
    assert afterwards[fences : fences + READINGS] == [STATUS.query()] * READINGS


LOCKED = StatusSample(0.0, 0, 1.0, triggered=False, active=False)
ACTIVE, FIRED = LOCKED._replace(active=True), LOCKED._replace(triggered=True, active=True)
CONFIRMED, REFUSED, UNKNOWN = Outcome.CONFIRMED, Outcome.REFUSED, Outcome.UNKNOWN


@pytest.mark.parametrize(
    ("raw", "reports", "outcome"),
    [
        (1, (ACTIVE, ACTIVE), CONFIRMED),
        (None, (ACTIVE, ACTIVE), CONFIRMED),
        (1, (ACTIVE,), UNKNOWN),
        (1, (LOCKED, ACTIVE), UNKNOWN),
        (1, (LOCKED, LOCKED), REFUSED),
        (0, (LOCKED, LOCKED), REFUSED),
        (None, (LOCKED, LOCKED), UNKNOWN),
        (1, (), UNKNOWN),
    ],
)
def test_an_activation_is_what_two_reports_say(
    raw: int | None, reports: tuple[StatusSample, ...], outcome: Outcome
) -> None:
    last = reports[-1].active if reports else None
    assert _outcome(Act.ACTIVATE, _Observed(raw == 1, raw, reports, is_active=last)) is outcome


@pytest.mark.parametrize("says", [None, True, False])
def test_an_activation_that_30_denies_is_not_confirmed(says: bool | None) -> None:
    for reports in ((ACTIVE, ACTIVE), (LOCKED, LOCKED)):
        is_same = says is reports[0].active
        outcome = _outcome(Act.ACTIVATE, _Observed(True, 1, reports, is_active=says))
        assert (outcome is UNKNOWN) is not is_same


@pytest.mark.parametrize(
    ("raw", "has_fired", "reports", "outcome"),
    [
        (1, False, (LOCKED, LOCKED), CONFIRMED),
        (0, True, (LOCKED, LOCKED), CONFIRMED),
        (0, False, (LOCKED, FIRED), CONFIRMED),
        (0, False, (LOCKED, LOCKED), REFUSED),
        (0, None, (LOCKED, LOCKED), UNKNOWN),
        (0, False, (LOCKED,), UNKNOWN),
        (None, False, (LOCKED, LOCKED), UNKNOWN),
        (2, False, (LOCKED, LOCKED), UNKNOWN),
    ],
)
def test_not_fired_is_said_only_where_everything_says_so(
    raw: int | None, has_fired: bool | None, reports: tuple[StatusSample, ...], outcome: Outcome
) -> None:
    assert _outcome(Act.DEPLOY, _Observed(raw == 1, raw, reports, has_fired=has_fired)) is outcome


@pytest.mark.parametrize(
    ("act", "raw", "is_alive", "outcome"),
    [
        (Act.SHUTDOWN, 1, True, REFUSED),
        (Act.SHUTDOWN, 1, False, CONFIRMED),
        (Act.SHUTDOWN, None, False, UNKNOWN),
        (Act.ZERO, 1, None, CONFIRMED),
        (Act.ZERO, 0, None, REFUSED),
        (Act.FORBID_DEPLOY, None, None, UNKNOWN),
    ],
)
def test_what_follows_from_an_acknowledgement(
    act: Act, raw: int | None, is_alive: bool | None, outcome: Outcome
) -> None:
    assert _outcome(act, _Observed(raw == 1, raw, is_alive=is_alive)) is outcome


@pytest.mark.parametrize(
    ("tilt_deg", "sentence"),
    [
        (0, "Acknowledged. Tilt now 0°."),
        (1, "Acknowledged. Tilt now 1°."),
        (2, "Acknowledged. Tilt now 2°, not 0°: check the mounting."),
        (None, "Acknowledged. Could not read the tilt: check it."),
    ],
)
def test_after_zeroing_the_tilt_is_said(tilt_deg: int | None, sentence: str) -> None:
    assert ZEROED_WITHIN_DEG == 1
    status = None if tilt_deg is None else StatusSample(0.0, tilt_deg, 1.0, False, False)
    done = Performed(act=Act.ZERO, outcome=CONFIRMED, status=status)
    assert done.sentence == sentence
    assert done.is_level is (tilt_deg in (0, 1))
