"""What may be another module than the one that is meant is asked questions and nothing else."""

from collections.abc import Callable

import pytest

from app.engine.device import Device
from app.engine.identity import (
    NO_EXPECTATION,
    Expected,
    Identity,
    IdentityCheck,
    IdentityEvidence,
    Trust,
    evidence_of,
    same_module,
    went_back,
)
from app.engine.procedure import Ask, Procedure
from app.preflight.evidence import Evidence as PreflightEvidence
from app.preflight.evidence import FlagState
from app.preflight.run import run_preflight
from app.procedures.act import perform
from app.procedures.baud import change_baud
from app.procedures.lock import lock
from app.procedures.read import read_everything
from app.procedures.write_all import SettingChange, WriteContext, why_not_verified, write_all
from app.safety.acts import REQUESTS, Act
from app.safety.interlocks import Interlock
from app.safety.permit import Origin, Permit
from protocol.catalogue import ACTIVATION, BY_NAME, SERIAL_OUTPUT
from protocol.events import Counters, OutcomeUnknown, Received, Role, Unanswered, WentOnline
from protocol.messages import Reading
from tests.support.journals import FakeJournal
from tests.support.line.odd_module import end_faults, restart_silently
from tests.support.line.sim_line import Rig, watched

FOUND = IdentityEvidence(
    37,
    {
        "light_threshold_v": 1.8,
        "attitude_threshold_deg": 60,
        "freefall_acceleration_g": 0.5,
        "freefall_time_s": 1.6,
    },
)
"""Of the simulated module as delivered."""
OPTIONS = {"uptime": 60, "noise": 0, "boots": 37}


def with_setting(key: str, value: float) -> IdentityEvidence:
    return FOUND._replace(settings={**FOUND.settings, key: value})


@pytest.mark.parametrize(
    ("before", "is_refuted"),
    [
        (FOUND, False),
        (FOUND._replace(boot_count=36), False),
        (FOUND._replace(boot_count=250), False),
        (FOUND._replace(boot_count=(37 - 127) % 256), False),
        (FOUND._replace(boot_count=38), True),
        (with_setting("attitude_threshold_deg", 85), True),
        (FOUND._replace(boot_count=None), False),
        (FOUND._replace(settings={}), False),
        (IdentityEvidence(), False),
    ],
    ids=["the same", "restarted", "over the wrap", "127 ahead", "gone back", "set otherwise", "no count", "no settings",
         "nothing"],
)  # fmt: skip
@pytest.mark.promise("a")
def test_readings_can_refute_and_never_prove(before: IdentityEvidence, is_refuted: bool) -> None:
    refuted = Trust.REFUTED if is_refuted else None
    assert same_module(before, FOUND) is (refuted or Trust.UNPROVEN)
    assert same_module(before, FOUND, is_said=True) is (refuted or Trust.PROVEN)
    assert same_module(before, FOUND, is_said=True, do_records_follow=False) is Trust.REFUTED
    assert FOUND.is_complete
    assert not FOUND._replace(settings={"attitude_threshold_deg": 60}).is_complete


@pytest.mark.parametrize(
    ("before", "now", "fell"),
    [(37, 12, True), (255, 0, False), (0, 127, False), (0, 128, True), (0, 255, True), (None, 3, False)],
)
def test_a_boot_count_never_falls_and_fell_where_it_grew_by_half_its_range(
    before: int | None, now: int, fell: bool
) -> None:
    assert went_back(before, now) is fell


def changes(rig: Rig) -> list[object]:
    return [request for request in rig.line.requests if not request.is_repeatable]


def trust(rig: Rig) -> Trust:
    return rig.session.identity.identity.trust


def ask(request: object) -> Procedure[object]:
    return (yield Ask(request, is_deliberate=True))  # type: ignore[arg-type]


@pytest.mark.parametrize("is_named", [False, True])
@pytest.mark.promise("a")
def test_after_a_lost_port_a_person_says_whether_it_is_the_same(*, is_named: bool) -> None:
    """A batch of new modules: the next one on the same adapter reads exactly like the last."""
    rig = Rig(OPTIONS, expected=Expected(FOUND, is_named=is_named))
    watched(rig)
    assert trust(rig) is Trust.OPEN
    rig.step_until(lambda: trust(rig) is not Trust.OPEN, limit_s=2)
    rig.step_for(30)
    assert (trust(rig), changes(rig)) == (Trust.UNPROVEN, [])
    rig.session.identity.confirm(rig.session.identity.identity)
    assert (trust(rig), rig.session.identity.identity.is_named) == (Trust.PROVEN, is_named)
    rig.step_until(lambda: changes(rig) == [SERIAL_OUTPUT.set(True)], limit_s=10)


@pytest.mark.parametrize("is_restarted", [False, True])
@pytest.mark.promise("a")
def test_of_the_former_module_nothing_is_known_once_a_person_says_that_it_is_another(*, is_restarted: bool) -> None:
    rig = Rig(OPTIONS)
    rig.run(read_everything())
    rig.session.identity.confirm(is_named=True)
    rig.session.device.apply(OutcomeUnknown(BY_NAME["attitude_trigger"].set(True), 0.0, rig.clock()))
    rig.bench.change(mute=True)
    rig.run(ask(BY_NAME["light"].query()))
    if is_restarted:
        rig.bench.restart()
    end_faults(rig.bench)
    rig.step_until(lambda: trust(rig) is Trust.UNPROVEN, limit_s=30)
    assert "freefall_time_s" in rig.session.device.view(rig.clock()).values
    rig.run(ask(BY_NAME["light"].query()))
    rig.session.treat_as_new(is_named=False)
    view = rig.session.device.view(rig.clock())
    assert set(view.values) >= {"light_v"}, "it is the next one's"
    assert view.values["baud_rate"].value == 115200, "which answered at it"
    assert not set(view.values) & {*FOUND.settings, "cell_voltage_v", "charging"}
    assert view.motion is None
    assert vars(rig.session.link_view().counters) == vars(Counters())
    assert trust(rig) is Trust.UNNAMED


@pytest.mark.parametrize(
    ("expected", "result"),
    [
        (Expected(FOUND._replace(boot_count=90)), Trust.REFUTED),
        (Expected(with_setting("freefall_time_s", 2.0)), Trust.REFUTED),
        (Expected(FOUND, is_adapter_same=False), Trust.UNPROVEN),
        (Expected(IdentityEvidence()), Trust.UNPROVEN),
        (Expected(IdentityEvidence(37)), Trust.UNPROVEN),
    ],
    ids=["boot count", "setting", "another device", "nothing known", "settings not known"],
)
@pytest.mark.promise("i")
def test_nothing_but_questions_goes_to_what_may_be_another_module(expected: Expected, result: Trust) -> None:
    rig = Rig(OPTIONS, expected=expected)
    watched(rig)
    rig.step_for(13.0)
    assert trust(rig) is result
    for request in (BY_NAME["attitude_threshold"].set(70), ACTIVATION.set(True), SERIAL_OUTPUT.set(True)):
        outcome = rig.run(ask(request))
        assert isinstance(outcome, Unanswered)
        assert outcome.attempts == 0
    rig.step_for(25)
    assert changes(rig) == []
    assert not {one.command.code for one in rig.line.requests} & {0x10, 0x11, 0x12, 0x13, 0x24, 0x25}


@pytest.mark.parametrize(("after_s", "result"), [(3.0, Trust.OPEN), (3.01, Trust.UNPROVEN)])
def test_a_person_is_asked_if_it_is_not_read_within_three_seconds(after_s: float, result: Trust) -> None:
    check, device = IdentityCheck(Expected(FOUND)), Device(115200)
    device.apply(WentOnline(100.0))
    for now in (100.0, 100.0 + after_s):
        check.on_device(device, now)
    assert check.identity.trust is result


NOT_PROVEN = "Module not proven: only queries are sent."


@pytest.mark.parametrize("act", [act for act in REQUESTS if act is not Act.LOCK])
@pytest.mark.promise("a")
def test_an_act_that_is_refused_for_it_says_so(act: Act) -> None:
    rig = Rig(OPTIONS, expected=Expected(FOUND._replace(boot_count=90)))
    watched(rig)
    rig.step_for(5)
    permit = Permit(act, Origin.RITUAL, rig.clock())
    done = rig.run(perform(act, FakeJournal(), permit=permit))
    assert Interlock.IS_IDENTITY_SETTLED in [refusal.condition for refusal in done.refusals]
    assert NOT_PROVEN in done.sentence
    assert changes(rig) == []


@pytest.mark.promise("a")
def test_a_write_that_is_refused_for_it_says_so() -> None:
    rig = Rig(OPTIONS, expected=Expected(FOUND._replace(boot_count=90)))
    watched(rig)
    rig.step_for(5)
    wanted, journal = SettingChange(BY_NAME["attitude_threshold"], 70), FakeJournal()
    report = rig.run(write_all([wanted], WriteContext(journal=journal, is_unlocked=True)))
    assert [refusal.sentence for refusal in report.refusals] == [NOT_PROVEN]
    (written,) = report.results
    why = why_not_verified(written, report.refusals)  # what `dps-s set` prints
    assert why is not None
    assert why.translated() == f"not sent: {NOT_PROVEN}"
    changed = rig.run(change_baud(9600, journal, permit=rig.permit(Act.CHANGE_BAUD)))
    assert NOT_PROVEN in changed.sentence
    checked = PreflightEvidence()
    rig.run(run_preflight(checked, is_enabling=True, journal=journal))
    assert {flag.state for flag in checked.flags.values()} == {FlagState.NOT_SENT}
    assert {flag.why.translated() for flag in checked.flags.values() if flag.why is not None} == {NOT_PROVEN}
    assert changes(rig) == []
    assert journal.intents == []


def test_lock_leaves_also_to_what_may_be_another_module() -> None:
    rig = Rig(OPTIONS, expected=Expected(FOUND._replace(boot_count=90)))
    watched(rig)
    rig.step_for(5)
    run = rig.started(lock(FakeJournal()), is_urgent=True)
    rig.step_until(lambda: run.is_done, limit_s=10)
    assert set(changes(rig)) == {ACTIVATION.set(False)}


def test_what_a_person_says_counts_only_for_what_they_saw() -> None:
    rig = Rig(OPTIONS, expected=Expected(FOUND._replace(boot_count=90)))
    watched(rig)
    rig.step_for(5)
    seen = rig.session.identity.identity
    assert seen.is_for_a_person
    assert seen.is_boot_count_lower
    rig.session.identity.confirm(seen._replace(now=IdentityEvidence(12)))
    assert trust(rig) is Trust.REFUTED
    rig.session.identity.confirm(seen)
    assert trust(rig) is Trust.PROVEN
    rig.step_until(lambda: changes(rig) == [SERIAL_OUTPUT.set(True)], limit_s=10)


@pytest.mark.parametrize(
    ("now", "is_kept"),
    [
        (IdentityEvidence(12, FOUND.settings), True),
        (IdentityEvidence(12, {"light_threshold_v": 1.8}), True),
        (IdentityEvidence(12, {**FOUND.settings, "attitude_threshold_deg": 75}), False),
        (IdentityEvidence(13, FOUND.settings), False),
    ],
    ids=["all the rest", "a part", "another setting", "restarted again"],
)
@pytest.mark.promise("a")
def test_what_a_person_says_stands_when_more_was_read_that_agrees(now: IdentityEvidence, is_kept: bool) -> None:
    """A click on what the window showed a moment ago is not lost, and does not cover what nobody has seen."""
    seen = Identity(Trust.REFUTED, FOUND, IdentityEvidence(12))
    assert seen._replace(now=now).is_as_seen(seen) is is_kept
    assert not Identity(Trust.UNPROVEN, FOUND, now).is_as_seen(seen)
    assert not seen._replace(before=IdentityEvidence(90), now=now).is_as_seen(seen)
    rig = Rig(OPTIONS, expected=Expected(FOUND._replace(boot_count=90)))
    watched(rig)
    rig.step_for(5)
    whole = rig.session.identity.identity
    assert whole.now == FOUND
    rig.session.identity.confirm(whole._replace(now=IdentityEvidence(37)))
    assert trust(rig) is Trust.PROVEN


def test_of_two_names_in_a_row_the_second_one_counts() -> None:
    """Also where what is to be compared with the first one is still being read."""
    rig, seen = Rig(OPTIONS), NO_EXPECTATION
    for before in (IdentityEvidence(36), IdentityEvidence(35)):
        rig.session.confirm_identity(seen, is_named=True, before=before)
        assert rig.session.identity.identity.before == before


@pytest.mark.promise("a")
def test_another_module_behind_the_open_port_is_noticed() -> None:
    """The adapter stays plugged in, the module behind it is exchanged."""
    rig = Rig(OPTIONS)
    watched(rig)
    rig.step_until(lambda: changes(rig) == [SERIAL_OUTPUT.set(True)], limit_s=10)
    assert evidence_of(rig.session.device.view(rig.clock.now_s).values, is_fresh=True) == FOUND
    rig.bench.module.memory.boot_count = 11
    rig.bench.restart()
    rig.step_until(lambda: trust(rig) is Trust.REFUTED, limit_s=30)
    sent = len(changes(rig))
    rig.step_for(25)
    assert len(changes(rig)) == sent
    assert rig.session.identity.identity.before == FOUND


@pytest.mark.promise("a")
def test_another_module_is_noticed_by_a_boot_count_that_only_lets_late_answers_pass() -> None:
    rig = Rig({**OPTIONS, "stream_at_boot": True})
    rig.run(read_everything())
    rig.session.take_events()
    rig.bench.module.memory.boot_count = 11
    restart_silently(rig.bench, rig.clock())
    done = rig.run(perform(Act.ACTIVATE, FakeJournal(), permit=rig.permit(Act.ACTIVATE)))
    events = rig.session.take_events()
    assert 12 in [e.message.value for e in events if isinstance(e, Received) and isinstance(e.message, Reading)]
    assert trust(rig) is Trust.REFUTED
    assert NOT_PROVEN in done.sentence
    assert changes(rig) == []


@pytest.mark.parametrize("role", Role)
@pytest.mark.promise("a")
def test_only_a_boot_count_that_answers_what_was_just_asked_tells_of_another_module(role: Role) -> None:
    """A late or a second one may be older than it looks, and from the module before."""
    rig = Rig(OPTIONS)
    rig.run(read_everything())
    check, device, at = IdentityCheck(), rig.session.device, rig.clock()
    frame = next(e.frame for e in rig.session.take_events() if isinstance(e, Received) and e.frame.raw[2] == 0x23)
    check.on_event(Received(frame, Reading(BY_NAME["boot_count"], 12), role, at), device, at)
    assert check.identity.is_settled is (role is not Role.ANSWER)
    device.apply(Received(frame, Reading(BY_NAME["boot_count"], 38), role, at))
    seen = evidence_of(device.view(at).values, is_fresh=False)
    assert seen.boot_count == (38 if role is Role.ANSWER else 37)


def _fall_silent(rig: Rig) -> None:
    rig.silence(3)


def _restart_uncounted(rig: Rig) -> None:
    rig.bench.module.memory.boot_count -= 1
    rig.bench.restart()


@pytest.mark.parametrize(("is_named", "is_attended"), [(False, False), (False, True), (True, False)])
@pytest.mark.parametrize("broken", [lambda rig: rig.bench.restart(), _restart_uncounted, _fall_silent])
@pytest.mark.promise("a")
def test_a_person_is_asked_again_once_the_conversation_broke(
    is_named: bool, is_attended: bool, broken: Callable[[Rig], None]
) -> None:
    """About a module without a name after an absence: modules of a batch follow each other on one adapter."""
    rig = Rig(OPTIONS)
    rig.session.identity = IdentityCheck(is_attended=is_attended)
    _fall_silent(rig)
    rig.step_for(5)
    assert trust(rig) is Trust.UNNAMED, "nothing was known yet that could be taken for the next one's"
    watched(rig)
    rig.step_for(5)
    if is_named:
        rig.session.identity.confirm(is_named=True)
    rig.step_for(25)
    assert trust(rig) is (Trust.PROVEN if is_named else Trust.UNNAMED)
    broken(rig)
    rig.step_for(20)
    is_asked = is_named or (is_attended and broken is _fall_silent)
    assert trust(rig) is (Trust.UNPROVEN if is_asked else Trust.UNNAMED)
    if is_asked:
        before = len(changes(rig))
        assert isinstance(rig.run(ask(ACTIVATION.set(True))), Unanswered)
        assert len(changes(rig)) == before
        rig.session.identity.confirm(rig.session.identity.identity)
        assert trust(rig) is Trust.PROVEN


def test_what_differs_is_named() -> None:
    identity = Identity(Trust.REFUTED, FOUND, with_setting("attitude_threshold_deg", 85)._replace(boot_count=12))
    assert identity.is_boot_count_lower
    assert [(one.command.key, one.before, one.after) for one in identity.changed] == [
        ("attitude_threshold_deg", 60, 85)
    ]


@pytest.mark.parametrize(
    ("before", "now", "is_lower"), [(7, 6, True), (7, 7, False), (7, 8, False), (7, None, False), (None, 6, False)]
)
def test_a_boot_count_is_lower_only_than_one_that_was_read(before: int | None, now: int | None, is_lower: bool) -> None:
    known = None if before is None else IdentityEvidence(before)
    assert Identity(before=known, now=IdentityEvidence(now)).is_boot_count_lower is is_lower
