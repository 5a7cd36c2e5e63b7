"""The link before a referee that shares nothing with it; and that the referee notices a link that errs."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from protocol import link as link_module
from protocol import request_gap as gap_module
from protocol.catalogue import ACTIVATION, Request
from protocol.events import Event
from protocol.link import Link
from protocol.messages import Message, Reading, answers, decode
from protocol.request_gap import Gap
from protocol.stale_replies import StaleReplies
from tests.scenarios.fuzz_link import Kind, converse, fuzz_link, kind_of
from tests.support.line.reference_link import LOCK, Cause, End, Referee, Told

SET = bytes.fromhex("42 61 22 02 A0 C4")
QUERY = bytes.fromhex("42 61 22 01 00 23")
REPLY = bytes.fromhex("41 75 22 01 A0 C3")
ENOUGH = 1500
"""Conversations within which each of the errors below is found, but for the rare ones."""


@given(st.integers(0, 2**48), st.sampled_from(Kind))
def test_no_conversation_ends_in_a_wrong_belief(seed: int, kind: Kind) -> None:
    assert converse(seed, kind).referee.faults == []


def test_a_thousand_conversations_of_all_kinds() -> None:
    figures = fuzz_link(1000, seed=20190430)
    assert figures.faults == 0
    assert figures.inputs == 1000
    assert min(figures.ends[end] for end in End) > 300


# A link that errs


def _changed_by_one(raw: bytes, asked: Request | None = None) -> Message:
    message = decode(raw, asked)
    return replace(message, raw=message.raw ^ 1) if isinstance(message, Reading) else message


def _forgets_at_any_restart(link: Any, events: list[Event], now: float, *, is_certain: bool) -> None:
    link._stale = StaleReplies(link.timing)
    _restart(link, events, now, is_certain=is_certain)


_restart = Link._restart
ERRORS: dict[str, tuple[object, str, Any]] = {
    "no fence": (StaleReplies, "could_answer", lambda *_: False),
    "a fence before everything": (StaleReplies, "could_answer", lambda *_: True),
    "copies are not known": (StaleReplies, "is_copy", lambda *_: False),
    "any answer passes everything": (StaleReplies, "on_answered", lambda earlier, *_: earlier._not_past.clear()),
    "any restart passes everything": (Link, "_restart", _forgets_at_any_restart),
    "what began before is believed": (
        Link,
        "_is_answer",
        lambda _link, flight, frame, _now: answers(frame.raw, flight.request),
    ),
    "answers are ignored": (Link, "_is_answer", lambda *_: False),
    "time never runs out": (Link, "_run_out", lambda *_: None),
    "sets are repeated": (Request, "is_repeatable", property(lambda _self: True)),
    "LOCK waits its turn": (link_module, "LOCK", ACTIVATION.set(True)),
    "LOCK waits for a quiet line": (gap_module, "LOCK", ACTIVATION.set(True)),
    "no quiet before a set": (Gap, "once_s", 0.0),
    "a quiet line before everything": (Gap, "question_s", 0.02),
    "values are changed": (link_module, "decode", _changed_by_one),
    "the code is not looked at": (link_module, "answers", lambda raw, asked: len(raw) == asked.command.layout.value),
}


RARE = {
    "any answer passes everything": 5302,
    "copies are not known": 20538,
    "any restart passes everything": 3472,
}
"""The seed of a conversation that finds it, where that took thousands."""


@pytest.mark.parametrize("error", ERRORS)
def test_the_referee_notices_a_link_that_errs(error: str, monkeypatch: pytest.MonkeyPatch) -> None:
    owner, name, wrong = ERRORS[error]
    monkeypatch.setattr(owner, name, wrong)
    if error in RARE:
        assert _is_caught(RARE[error], Kind.HONEST)
    else:
        assert any(_is_caught(seed, kind_of(seed)) for seed in range(ENOUGH))


def _is_caught(seed: int, kind: Kind) -> bool:
    try:
        return bool(converse(seed, kind).referee.faults)
    except (KeyError, AttributeError):  # the tables of states, or a message of the wrong kind
        return True


# The referee's own rules, one by one


def asked(request: bytes, *, waits_s: tuple[float, ...] = (1.0, 1.0)) -> Referee:
    referee = Referee(is_certain=True)
    referee.ask(request, 1.0, waits_s)
    referee.wrote(request, 1.0)
    referee.settled([], 1.0)
    return referee


def hear(referee: Referee, frame: bytes, cause: bytes | None = None) -> None:
    referee.came(frame, Cause(cause, 1), began_at=0, now_s=1.2)
    referee.heard(frame)


def right(referee: Referee) -> None:
    hear(referee, REPLY, QUERY)
    referee.settled([Told(QUERY, End.ANSWERED, ((0xA0,),), 1, 0.5)], 1.5)


def ignored(referee: Referee) -> None:
    hear(referee, REPLY, QUERY)
    referee.settled([], 1.5)


def other_value(referee: Referee) -> None:
    hear(referee, REPLY, QUERY)
    referee.settled([Told(QUERY, End.ANSWERED, ((0xA1,),), 1, 0.5)], 1.5)


def invented(referee: Referee) -> None:
    referee.settled([Told(QUERY, End.ANSWERED, ((0xA0,),), 1, 0.5)], 1.5)


def too_soon(referee: Referee) -> None:
    referee.wrote(QUERY, 1.5)


def too_late(referee: Referee) -> None:
    referee.looked(2.5, late_s=0.0)


def something_else(referee: Referee) -> None:
    referee.wrote(SET, 1.5)


def another_end(referee: Referee) -> None:
    referee.settled([Told(QUERY, End.UNKNOWN)], 4.0)


def told_twice(referee: Referee) -> None:
    right(referee)
    referee.settled([Told(QUERY, End.ANSWERED, ((0xA0,),), 1, 0.5)], 1.5)


@pytest.mark.parametrize(
    "wrong", [ignored, other_value, invented, too_soon, too_late, something_else, another_end, told_twice]
)
def test_a_rule_that_is_broken_is_a_fault(wrong: Callable[[Referee], None]) -> None:
    referee = asked(QUERY)
    wrong(referee)
    assert referee.faults


def test_what_is_right_is_no_fault() -> None:
    referee = asked(QUERY)
    right(referee)
    assert referee.faults == []
    assert referee.ends[End.ANSWERED] == 1


def test_a_set_is_not_written_twice_and_lock_not_late() -> None:
    referee = asked(SET)
    referee.wrote(SET, 5.0)
    assert referee.faults
    referee = Referee(is_certain=True)
    referee.ask(LOCK, 1.0, (1.0,))
    referee.settled([], 1.0)
    assert referee.faults


def test_a_frame_that_began_before_the_request_must_not_be_believed() -> None:
    referee = Referee(is_certain=True)
    referee.heard(REPLY[:3])
    referee.ask(QUERY, 1.0, (1.0,))
    referee.wrote(QUERY, 1.0)
    referee.came(REPLY, Cause(), began_at=0, now_s=1.2)
    referee.heard(REPLY[3:])
    referee.settled([Told(QUERY, End.ANSWERED, ((0xA0,),), 1, 0.25)], 1.25)
    assert referee.faults
