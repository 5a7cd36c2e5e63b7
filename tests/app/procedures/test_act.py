"""Acts: refused in the engine, at most one frame for one permit, logged before and after, never claimed too much."""

from dataclasses import replace
from typing import Any

import pytest

from app.engine.procedure import Cancelled, PortLost, is_alive
from app.engine.session import Run
from app.procedures.act import SECOND_MODULE_S, SENTENCES, Armed, Performed, perform, rehearse
from app.procedures.read import read_everything
from app.procedures.stream import StreamSwitch, watch
from app.procedures.who_is_there import who_is_there
from app.safety.acts import REQUESTS, Act
from app.safety.interlocks import Interlock
from app.safety.journal import Outcome
from app.safety.permit import Origin, Permit
from app.text.i18n import CHINESE, set_language
from protocol.catalogue import BY_NAME, Hazard
from protocol.events import Received
from tests.support.journals import FakeJournal
from tests.support.line.frames import at_each_frame
from tests.support.line.odd_module import restart_silently
from tests.support.line.sim_line import Rig
from tests.support.thorough import some

READY: dict[Act, dict[str, Any]] = {
    Act.ACTIVATE: {},
    Act.ZERO: {"tilt": 4},
    Act.SHUTDOWN: {},
    Act.FORBID_DEPLOY: {},
    Act.DEPLOY: {"active": True},
}
"""A module in the state in which the act is allowed."""


def opened(options: dict[str, Any] | None = None) -> Rig:
    """Return a rig on a port that has been open for so long that a second module would have shown."""
    rig = Rig(options)
    rig.run(is_alive())
    rig.step_for(SECOND_MODULE_S)
    return rig


def permit_for(rig: Rig, act: Act, **changes: Any) -> Permit:
    return replace(rig.permit(act), **changes)


def do(rig: Rig, act: Act, journal: Any = None, **more: Any) -> Performed:
    more.setdefault("permit", permit_for(rig, act))
    return rig.run(perform(act, journal or FakeJournal(), **more))


def acts_sent(rig: Rig) -> list[bytes]:
    """Every host frame that is not a question."""
    return [request.encode() for request in rig.line.requests if request.hazard is not Hazard.NONE]


def test_a_boot_count_that_only_lets_late_answers_pass_tells_of_a_restart_too() -> None:
    rig = opened({"stream_at_boot": True})
    rig.run(read_everything())
    restart_silently(rig.bench, rig.clock())
    done = do(rig, Act.ACTIVATE)
    heard = [event for event in rig.session.take_events() if isinstance(event, Received)]
    assert any(event.frame.raw[2] == 0x23 and event.frame.raw[4] == 38 for event in heard), "the fence brought it"
    assert rig.session.device.view(rig.clock()).restarts == 1
    known = rig.session.device.view(rig.clock()).values.get("boot_count")
    assert known is not None
    assert known.value == 38
    assert done.outcome is Outcome.CONFIRMED


@pytest.mark.promise("h")
def test_a_module_that_reports_its_activation_late_is_not_said_to_be_still_locked() -> None:
    rig = opened({"active_late_ms": 500})
    began = rig.clock()
    done = do(rig, Act.ACTIVATE)
    assert rig.clock() - began < 0.7, "it is asked often"
    assert rig.bench.module.state.is_active
    assert done.outcome is Outcome.CONFIRMED
    assert len(acts_sent(rig)) == 1


def test_a_module_that_acknowledges_the_activation_and_stays_locked_is_found_out() -> None:
    rig = opened({"activates": False})
    done = do(rig, Act.ACTIVATE)
    assert done.outcome is Outcome.REFUSED


@pytest.mark.parametrize("act", READY)
def test_an_act_that_is_allowed_is_done_once_and_confirmed(act: Act) -> None:
    rig, journal = opened(READY[act]), FakeJournal()
    journal.line_length = lambda: len(rig.line.sent)
    rig.run(who_is_there())
    begun = rig.clock()
    done = do(rig, act, journal)
    assert done.outcome is Outcome.CONFIRMED
    asks_threshold = BY_NAME["attitude_threshold"].query() in rig.line.requests
    assert asks_threshold is (act is Act.ACTIVATE), "only an activation compares the tilt with it"
    # Before zeroing it has to lie still for two seconds; a second report of firing, and a silence, take their time.
    assert rig.clock() - begun < {Act.ZERO: 2.4, Act.DEPLOY: 1.5, Act.SHUTDOWN: 4.0}.get(act, 0.5)
    frame = REQUESTS[act].encode()
    assert acts_sent(rig) == [frame]
    assert journal.outcomes == {0: Outcome.CONFIRMED}
    assert journal.intents[0][:2] == (act, frame)
    assert bytes(rig.line.sent).find(frame) >= journal.sent_before[0]  # the intent came first
    module = rig.bench.module
    assert module.state.is_active is (act in (Act.ACTIVATE, Act.DEPLOY))
    assert module.is_triggered is (act is Act.DEPLOY)
    assert module.is_on is (act is not Act.SHUTDOWN)
    assert module.state.is_forbidden is (act is Act.FORBID_DEPLOY)
    assert module.memory.zero_tilt_deg == (4 if act is Act.ZERO else 0)


@pytest.mark.parametrize("act", READY)
@pytest.mark.parametrize("what", ["no permit", "old", "spent", "ahead", "other act", "armed", "log", "log fails"])
@pytest.mark.promise("h")
def test_an_open_condition_is_named_and_nothing_is_sent(act: Act, what: str) -> None:
    rig, journal = opened(READY[act]), FakeJournal()
    permit: Permit | None = permit_for(rig, act)
    armed = Armed()
    match what:
        case "no permit":
            permit = None
        case "old":
            permit = permit_for(rig, act, granted_at=rig.clock() - 6)
        case "spent":
            permit = permit_for(rig, act, is_spent=True)
        case "ahead":
            permit = permit_for(rig, act, granted_at=rig.clock() + 60)
        case "other act":
            permit = permit_for(rig, Act.LOCK, origin=Origin.RITUAL)
        case "armed":
            armed.act = Act.CHANGE_BAUD
        case "log":
            journal.is_ready = False
        case _:
            journal.is_broken = True
    done = do(rig, act, journal, permit=permit, armed=armed)
    assert done.outcome is Outcome.NOT_SENT
    assert len(done.refusals) == 1
    assert done.sentence.startswith("Nothing was sent. ")
    assert acts_sent(rig) == []
    assert not journal.intents


@pytest.mark.parametrize(
    ("act", "options", "condition"),
    [
        (Act.ACTIVATE, {"active": True}, Interlock.IS_LOCKED),
        (Act.ACTIVATE, {"tilt": 60}, Interlock.BELOW_TILT),
        (Act.ACTIVATE, {"mute_codes": frozenset((0x20,))}, Interlock.BELOW_TILT),
        (Act.ACTIVATE, {"mute_codes": frozenset((0x32,))}, Interlock.FRESH_STATUS),
        (Act.ZERO, {"active": True}, Interlock.IS_LOCKED),
        (Act.SHUTDOWN, {"active": True}, Interlock.IS_LOCKED),
        (Act.DEPLOY, {}, Interlock.IS_ACTIVE),
        (Act.DEPLOY, {"active": True, "tilt": 80}, Interlock.NOT_TRIGGERED),
        (Act.DEPLOY, {"active": True, "mute": True}, Interlock.ONLINE),
    ],
)
def test_the_modules_own_state_refuses(act: Act, options: dict[str, Any], condition: Interlock) -> None:
    rig = opened(options)
    rig.step_for(0.05)
    done = do(rig, act)
    assert condition in {refusal.condition for refusal in done.refusals}
    assert acts_sent(rig) == []


@pytest.mark.parametrize("act", [Act.DEPLOY, Act.ZERO, Act.FORBID_DEPLOY])
@pytest.mark.promise("e")
def test_one_permit_is_one_frame(act: Act) -> None:
    """Also where the module would be in the right state for a second one."""
    rig = opened(READY[act])
    permit = permit_for(rig, act)
    runs = [Run(perform(act, FakeJournal(), permit=permit)) for _ in range(3)]
    for run in runs:
        rig.session.run(run)
    rig.step_until(lambda: all(run.is_done for run in runs))
    assert permit.is_spent
    assert len(acts_sent(rig)) == 1
    assert [run.result.outcome for run in runs if run.result] == [Outcome.CONFIRMED, *[Outcome.NOT_SENT] * 2]


@pytest.mark.parametrize("act", READY)
def test_a_rehearsal_shows_the_bytes_and_sends_nothing(act: Act) -> None:
    rig, journal = opened(READY[act]), FakeJournal()
    permit = permit_for(rig, act, is_rehearsal=True)
    done = do(rig, act, journal, permit=permit)
    assert permit.is_spent
    assert (done.outcome, done.is_rehearsal) == (Outcome.NOT_SENT, True)
    assert REQUESTS[act].encode().hex(" ").upper() in done.sentence
    assert acts_sent(rig) == []
    assert not journal.intents
    with pytest.raises(ValueError, match="no rehearsal"):
        rehearse(act, permit_for(rig, act))


def test_an_unanswered_deploy_is_to_be_treated_as_fired() -> None:
    rig, journal = opened({"active": True, "mute_codes": frozenset((0x11,))}), FakeJournal()
    done = do(rig, Act.DEPLOY, journal)
    assert (done.outcome, journal.outcomes) == (Outcome.UNKNOWN, {0: Outcome.UNKNOWN})
    assert done.sentence == "Sent, not confirmed: treat it as fired."
    assert len(acts_sent(rig)) == 1


def test_a_deploy_whose_answer_was_lost_is_confirmed_by_the_report() -> None:
    rig = opened({"active": True})
    at_each_frame(rig.bench, lambda request: rig.bench.change(drop=float(request == REQUESTS[Act.DEPLOY])))
    done = do(rig, Act.DEPLOY)
    assert done.outcome is Outcome.CONFIRMED


@pytest.mark.promise("c")
def test_the_port_is_lost_after_the_frame_left() -> None:
    rig, journal = opened({"active": True}), FakeJournal()
    run = rig.started(perform(Act.DEPLOY, journal, permit=permit_for(rig, Act.DEPLOY)))
    rig.step_until(lambda: acts_sent(rig))
    rig.session.close(why=PortLost())
    assert rig.end(run).outcome is Outcome.UNKNOWN
    assert journal.outcomes == {0: Outcome.UNKNOWN}


FAULTS: tuple[dict[str, Any], ...] = (
    {"drop": 0.06, "direction": "both"},
    {"corrupt": 0.01, "direction": "both"},
    {"double": 0.5},
    {"delay_ms": 30.0, "jitter_ms": 60.0},
    {"stream_at_boot": True, "drop": 0.05, "delay_ms": 30.0},
)


@pytest.mark.parametrize("faults", FAULTS, ids="-".join)
@pytest.mark.parametrize("act", READY)
def test_on_bad_lines_at_most_one_frame_and_no_claim_too_much(act: Act, faults: dict[str, Any]) -> None:
    outcomes = set()
    for seed in some(range(25), one_in=3):
        rig, journal = opened({**READY[act], **faults, "seed": seed * 31 + 7}), FakeJournal()
        done = do(rig, act, journal, permit=permit_for(rig, act))
        outcomes.add(done.outcome)
        sent = acts_sent(rig)
        assert sent == ([] if done.outcome is Outcome.NOT_SENT else [REQUESTS[act].encode()])
        assert len(journal.intents) >= len(sent)
        assert all(outcome is done.outcome for outcome in journal.outcomes.values())
        module = rig.bench.module
        is_true = {
            Act.ACTIVATE: module.state.is_active,
            Act.ZERO: module.memory.zero_tilt_deg == 4,
            Act.SHUTDOWN: not module.is_on,
            Act.FORBID_DEPLOY: module.state.is_forbidden,
            Act.DEPLOY: module.is_triggered,
        }[act]
        if done.outcome is Outcome.CONFIRMED:
            assert is_true
        if done.outcome in (Outcome.REFUSED, Outcome.NOT_SENT):
            assert not is_true
    # Where questions are answered twice there may be two modules.
    assert (Outcome.NOT_SENT if "double" in faults else Outcome.CONFIRMED) in outcomes


def test_every_outcome_has_its_sentence() -> None:
    said = {(act, outcome) for act in REQUESTS if act is not Act.LOCK for outcome in Outcome}
    said = {one for one in said if one[1] is not Outcome.NOT_SENT}
    assert set(SENTENCES) == said


@pytest.mark.parametrize("act", READY)
def test_a_disk_that_takes_its_time_does_not_hold_the_line_up(act: Act) -> None:
    """The intent is not on disk yet: the module is heard, its answers come, and nothing dangerous leaves."""
    rig, journal = opened(READY[act]), FakeJournal()
    journal.is_held = True
    permit = permit_for(rig, act)
    run = rig.started(perform(act, journal, permit=permit))
    rig.session.run_in_background(watch(StreamSwitch(is_wanted=False)))
    rig.step_until(lambda: journal.intents)
    heard = rig.session.link_view().counters.bytes_received
    rig.step_for(0.8)
    assert rig.session.link_view().counters.bytes_received > heard + 40
    assert not acts_sent(rig)
    journal.flush()
    ended = rig.end(run)
    assert ended.outcome is Outcome.CONFIRMED
    assert acts_sent(rig) == [REQUESTS[act].encode()]


@pytest.mark.promise("h")
def test_the_module_is_asked_again_after_a_long_wait_for_the_disk() -> None:
    """Somebody else activated it meanwhile."""
    rig, journal = opened(), FakeJournal()
    journal.is_held = True
    run = rig.started(perform(Act.ACTIVATE, journal, permit=permit_for(rig, Act.ACTIVATE)))
    rig.step_until(lambda: journal.intents)
    rig.bench.module.activate(is_active=True)
    rig.step_for(0.8)
    journal.flush()
    ended = rig.end(run)
    assert Interlock.IS_LOCKED in {refusal.condition for refusal in ended.refusals}
    assert Interlock.FRESH_STATUS not in {refusal.condition for refusal in ended.refusals}, "it was asked"
    assert acts_sent(rig) == []
    assert journal.outcomes == {0: Outcome.NOT_SENT}


@pytest.mark.promise("h")
def test_an_intent_that_is_never_durable_is_given_up() -> None:
    rig, journal = opened({"active": True}), FakeJournal()
    journal.is_held = True
    begun = rig.clock()
    done = do(rig, Act.DEPLOY, journal)
    assert rig.clock() - begun == pytest.approx(1.0, abs=0.3)
    assert [refusal.condition for refusal in done.refusals] == [Interlock.INTENT_DURABLE]
    assert "too slow" in done.sentence
    set_language(CHINESE)
    assert done.sentence.endswith("磁盘写入过慢。")
    assert acts_sent(rig) == []
    assert journal.outcomes == {0: Outcome.NOT_SENT}


@pytest.mark.parametrize("why", ["cancelled", "port lost"])
def test_what_is_broken_off_while_the_disk_works_is_written_down_as_not_sent(why: str) -> None:
    rig, journal = opened(), FakeJournal()
    journal.is_held = True
    run = rig.started(perform(Act.ZERO, journal, permit=permit_for(rig, Act.ZERO)))
    rig.step_until(lambda: journal.intents)
    if why == "cancelled":
        run.cancel()
        rig.step_for(0.1)
    else:
        rig.session.close(why=PortLost())
    assert isinstance(run.error, Cancelled if why == "cancelled" else PortLost)
    assert journal.outcomes == {0: Outcome.NOT_SENT}
    assert acts_sent(rig) == []


def test_a_doubled_heartbeat_is_no_sign_of_life_after_a_shutdown() -> None:
    for seed in range(20):
        rig = opened({"double_codes": "01", "double_ms": "120", "seed": seed})
        assert do(rig, Act.SHUTDOWN).outcome is Outcome.CONFIRMED
        assert not rig.bench.module.is_on


@pytest.mark.parametrize("mute", ["31", "32/2", "32/3", "31,32/2"])
@pytest.mark.promise("f")
def test_not_fired_needs_every_witness(mute: str) -> None:
    rig = opened({"active": True, "mute_codes": mute, "double_codes": "32", "double_ms": "25"})
    rig.bench.module.state.is_forbidden = True
    fire = rig.bench.module.fire
    rig.bench.module.fire = lambda *_args: False  # type: ignore[method-assign]
    assert do(rig, Act.DEPLOY).outcome is not Outcome.REFUSED
    rig.bench.module.fire = fire  # type: ignore[method-assign]


def test_a_module_that_did_not_fire_is_believed_when_every_witness_says_so() -> None:
    rig = opened({"active": True})
    rig.bench.module.fire = lambda *_args: False  # type: ignore[method-assign]
    assert do(rig, Act.DEPLOY).outcome is Outcome.REFUSED
