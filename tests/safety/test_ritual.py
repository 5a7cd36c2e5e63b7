"""The deploy ritual: its table literally, its clock, its consequences; nothing fires without two held seconds."""

from itertools import chain

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from app.safety.consequences import consequences
from app.safety.journal import Act
from app.safety.permit import Origin, Permit
from app.safety.ritual import ARMED_FOR_S, DISARMING, HOLD_S, MAX_GAP_S, TRANSITIONS, Input, Ritual, Stage
from protocol.catalogue import BY_NAME, SETTINGS
from protocol.fields import Value

TALK = 7
T0 = 500.0


def hold(ritual: Ritual, start: float, seconds: float, *, every_s: float = 0.05) -> list[Permit]:
    """Ticks from `start` on; the permits that came."""
    permits = []
    for step in range(1, round(seconds / every_s) + 1):
        permit = ritual.tick(start + step * every_s)
        if permit is not None:
            permits.append(permit)
    return permits


def armed() -> Ritual:
    ritual = Ritual()
    ritual.choose(TALK)
    ritual.arm(T0)
    return ritual


def test_the_whole_way_gives_one_permit() -> None:
    ritual = armed()
    assert ritual.armed_left_s(T0 + 1) == 9.0
    assert hold(ritual, T0, 1.0) == []
    ritual.press(T0 + 1)
    permits = hold(ritual, T0 + 1, 5.0)
    assert [(permit.act, permit.origin, permit.conversation) for permit in permits] == [
        (Act.DEPLOY, Origin.RITUAL, TALK)
    ]
    assert permits[0].granted_at == pytest.approx(T0 + 3, abs=0.051)
    assert (ritual.stage, ritual.ended_by) == (Stage.FIRED, None)
    ritual.press(T0 + 6)
    ritual.release()
    ritual.arm(T0 + 6)
    assert hold(ritual, T0 + 6, 5.0) == []
    ritual.disarm(Input.FINISHED)
    assert ritual.stage is Stage.IDLE
    ritual.disarm(Input.INTERRUPTED)
    assert ritual.ended_by is Input.FINISHED, "nothing was left to end"


@pytest.mark.promise("d")
def test_letting_go_ends_the_ritual() -> None:
    ritual = armed()
    ritual.press(T0)
    assert hold(ritual, T0, 1.9) == []
    assert ritual.held_s(T0 + 1.9) == pytest.approx(1.9)
    ritual.release()
    assert (ritual.stage, ritual.ended_by) == (Stage.IDLE, Input.RELEASE)
    ritual.press(T0 + 2.0)
    assert hold(ritual, T0 + 2.0, 3.0) == []
    assert ritual.ended_by is Input.RELEASE, "it had ended before the press"


@pytest.mark.promise("b")
def test_what_does_not_disarm_is_our_own_mistake() -> None:
    with pytest.raises(ValueError, match="PRESS"):
        armed().disarm(Input.PRESS)


LETTERS = {"I": Stage.IDLE, "C": Stage.CHOSEN, "A": Stage.ARMED, "H": Stage.HOLDING, "F": Stage.FIRED}
TABLE = """
                  I C A H F
CHOOSE            C C A H C
ARM               I A A H F
PRESS             I C H I F
RELEASE           I C A I F
HELD              I C A F F
HOLD_BROKEN       I C A I F
RAN_OUT           I C I I F
FINISHED          I C A H I
CANCEL            I I I I F
FOCUS_LOST        I I I I F
WINDOW_LEFT       I I I I F
OUT_OF_SIGHT      I I I I F
INTERRUPTED       I I I I F
CONDITION_OPENED  I C I I F
FAILED            I I I I F
"""


@pytest.mark.promise("b")
def test_the_transitions_literally() -> None:
    head, *rows = [line.split() for line in TABLE.strip().splitlines()]
    assert {row[0] for row in rows} == {what.name for what in Input}
    for name, *after in rows:
        for letter, expected in zip(head, after, strict=True):
            stage = LETTERS[letter]
            assert TRANSITIONS.get((stage, Input[name]), stage) is LETTERS[expected], (stage, name)


TICKS = st.integers(0, 24).map(lambda count: (0.1,) * count)
TRIES = st.tuples(
    st.sampled_from([("choose", "arm", "press"), ("choose", "arm", "press"), ("choose", "arm"), ()]),
    TICKS,
    st.one_of(
        st.tuples(st.sampled_from(["choose", "arm", "press", "release", *DISARMING])),
        st.tuples(st.sampled_from([0.2, 0.4, 9.0])),
    ),
    TICKS,
)
"""Each begins in some way, and meets something on the way to a hold of two seconds or behind it."""
STEPS = st.lists(TRIES.map(chain.from_iterable), max_size=12).map(lambda tries: [*chain.from_iterable(tries)])
HELD = ["choose", "arm", "press", *[0.1] * 21]


@example(HELD)
@example([*HELD[:13], "release", *HELD[3:]])
@example(["choose", "arm", 9.0, *HELD[2:]])
@given(STEPS)
@pytest.mark.promise("e")
def test_no_sequence_fires_without_two_seconds_held(steps: list[str | Input | float]) -> None:
    """A second account of the same gestures: since when it is armed and held, with nothing in between."""
    ritual, now = Ritual(), T0
    armed_at: float | None = None
    pressed_at: float | None = None
    gestures = permits = 0
    for step in steps:
        if isinstance(step, float):
            now += step
            permit = ritual.tick(now)
            if step > MAX_GAP_S:
                pressed_at = None
            if permit is not None:
                permits += 1
                assert armed_at is not None
                assert now - armed_at < ARMED_FOR_S
                assert pressed_at is not None
                assert now - pressed_at >= HOLD_S
                armed_at = pressed_at = None
            continue
        stage = ritual.stage
        if isinstance(step, Input):
            ritual.disarm(step)
            if step is not Input.CONDITION_OPENED or stage is not Stage.CHOSEN:
                armed_at = pressed_at = None
            continue
        match step:
            case "choose":
                ritual.choose(TALK)
            case "arm":
                ritual.arm(now)
                armed_at = now if stage is Stage.CHOSEN else armed_at
            case "press":
                ritual.press(now)
                gestures += 1
                pressed_at = now if stage is Stage.ARMED else None
                armed_at = None if stage is Stage.HOLDING else armed_at
            case _:
                ritual.release()
                armed_at = None if stage is Stage.HOLDING else armed_at
                pressed_at = None
    assert permits <= gestures
    assert permits or steps != HELD


@pytest.mark.parametrize(("gap_s", "stage"), [(0.25, Stage.HOLDING), (0.3125, Stage.IDLE), (-0.125, Stage.IDLE)])
def test_a_hold_is_known_while_ticks_come_a_quarter_of_a_second_apart(gap_s: float, stage: Stage) -> None:
    assert MAX_GAP_S == 0.25
    ritual = armed()
    ritual.press(T0 + 1)
    assert ritual.tick(T0 + 1) is None
    ritual.tick(T0 + 1 + gap_s)
    assert (ritual.stage, ritual.ended_by) == (stage, Input.HOLD_BROKEN if stage is Stage.IDLE else None)


@pytest.mark.parametrize(
    ("name", "value", "sentences"),
    [
        ("freefall_time", 1.6, ["1.60 s of free fall is 12.6 m before it fires, at 56 km/h."]),
        ("freefall_time", 0.1, ["0.10 s of free fall is 0.0 m before it fires, at 4 km/h.", "A jolt may fire it."]),
        ("attitude_threshold", 60, ["Fires at 60°, rearms at 50°."]),
        ("attitude_threshold", 54, ["Fires at 54°, rearms at 44°.", "Vendor advises: 55° or more."]),
        ("attitude_threshold", 10, ["Fires at 10° and never rearms.", "Vendor advises: 55° or more."]),
        ("freefall_acceleration", 0.4, ["Free fall: below 0.4 g; at rest 1 g."]),
    ],
)
def test_sentences(name: str, value: Value, sentences: list[str]) -> None:
    assert [consequence.message.translated() for consequence in consequences(BY_NAME[name], value)] == sentences


@pytest.mark.parametrize(
    ("name", "harmless", "risky"),
    [
        ("attitude_trigger", True, False),
        ("freefall_trigger", True, False),
        ("freefall_time", 0.5, 0.49),  # what the pre-flight check allows, and less, which a jolt outlasts
    ],
)
@pytest.mark.promise("g")
def test_what_takes_protection_away_or_a_jolt_may_fire_needs_a_second_click(
    name: str, harmless: Value, risky: Value
) -> None:
    assert not any(one.is_risk for one in consequences(BY_NAME[name], harmless))
    assert consequences(BY_NAME[name], risky)[-1].is_risk


def test_every_value_of_a_byte_has_a_consequence() -> None:
    for command in SETTINGS:
        assert command.write is not None
        for raw in sorted(command.write.allowed):
            value = command.write.decode(raw)
            said = consequences(command, value)
            assert all(one.message.translated() for one in said)
            assert said
