"""What is known in one conversation: from which frames, for how long, and nothing after its end."""

import pytest

from app.engine.conversation import FRESH_FOR_S, Conversation, ConversationView, How, Known
from app.safety.journal import REQUESTS, Act
from protocol.catalogue import ACTIVATION, BY_NAME, LOCK, STATUS, Command, Request
from protocol.events import Answered, Ended, EndReason, Received, Role, Unanswered
from protocol.messages import Acknowledgement, Direction, Frame, decode, encode_long, encode_reply
from protocol.stale_replies import FlagAnswers
from protocol.timing import SLOW_S

NOW = 1000.0
THRESHOLD, TIME = BY_NAME["attitude_threshold"], BY_NAME["freefall_time"]
TRIGGER = BY_NAME["attitude_trigger"]
"""It cannot be read (E8)."""


def heard(raw: bytes, role: Role, at: float = NOW, asked: Request | None = None) -> Received:
    return Received(Frame(Direction.MODULE_TO_HOST, raw), decode(raw, asked), role, at)


def status(tilt: int = 7, *, active: bool = False, triggered: bool = False) -> bytes:
    return encode_long(STATUS.code, bytes((tilt, 10, int(triggered), int(active))))


def read(command: Command, raw: int, at: float = NOW) -> Received:
    return heard(encode_reply(command.code, raw), Role.ANSWER, at, command.query())


def acknowledged(request: Request, raw: int | None = None, at: float = NOW) -> Answered:
    echo = request.data if raw is None else raw
    return Answered(request, (Acknowledgement(request, echo),), 1, 0.003, at)


def begun() -> Conversation:
    return Conversation(3, 37, NOW, 115200, FlagAnswers(0.0))


@pytest.fixture
def talk() -> Conversation:
    """A module that answered: a setting that can be read, one that cannot, and a status."""
    made = begun()
    made.apply(read(THRESHOLD, 60))
    made.apply(acknowledged(TRIGGER.set(True)))
    made.apply(heard(status(), Role.ANSWER))
    return made


def streamed(talk: Conversation, *times_s: float) -> ConversationView:
    for time_s in times_s:
        talk.apply(heard(status(), Role.STREAMED, NOW + time_s))
    return talk.view(NOW + max(times_s))


# What is known


@pytest.mark.promise("j")
def test_an_acknowledged_activation_is_known_at_once_and_a_lock_only_when_it_is_reported(talk: Conversation) -> None:
    talk.apply(acknowledged(ACTIVATION.set(True)))
    assert talk.view(NOW).values["active"] == Known(True, How.ACKNOWLEDGED, NOW)
    talk.apply(acknowledged(LOCK))  # proves nothing: a module that does not lock says the same
    talk.apply(Unanswered(LOCK, 1, 1.0, NOW))
    assert talk.view(NOW).values["active"].value is True
    talk.apply(heard(status(), Role.ANSWER))
    assert talk.view(NOW).values["active"].value is False


@pytest.mark.parametrize("is_answered", [True, False])
@pytest.mark.parametrize(("act", "key"), [(Act.DEPLOY, "triggered"), (Act.ZERO, "tilt_deg")])
def test_after_an_act_what_it_changes_is_unknown_until_it_is_reported(
    talk: Conversation, act: Act, key: str, is_answered: bool
) -> None:
    request = REQUESTS[act]
    talk.apply(acknowledged(request) if is_answered else Unanswered(request, 1, 1.0, NOW))
    assert key not in talk.view(NOW).values
    talk.apply(heard(status(3), Role.ANSWER))
    assert key in talk.view(NOW).values


def test_a_question_that_is_not_answered_changes_nothing(talk: Conversation) -> None:
    talk.apply(Unanswered(THRESHOLD.query(), 6, 0.4, NOW))
    assert talk.view(NOW).values["attitude_threshold_deg"].value == 60


@pytest.mark.parametrize("role", [Role.LATE, Role.ECHO])
@pytest.mark.promise("a")
def test_a_status_that_answers_nothing_of_now_is_no_value(talk: Conversation, role: Role) -> None:
    assert talk.apply(heard(status(80, active=True), role, NOW + 0.1)) is None
    assert talk.view(NOW + 0.1).fresh("tilt_deg", NOW + 0.1) == 7


def test_reports_are_those_of_the_last_seconds(talk: Conversation) -> None:
    talk.apply(heard(status(20), Role.STREAMED, NOW + 1.0))
    assert [report.tilt_deg for report in talk.view(NOW + 1.0).reports] == [7, 20]
    assert talk.view(NOW + 3.0).reports == talk.view(NOW + 3.0).reports[-1:] != ()
    assert talk.view(NOW + 10.0).reports == ()


# For how long


@pytest.mark.parametrize("key", FRESH_FOR_S)
@pytest.mark.promise("a")
def test_a_live_value_ages(talk: Conversation, key: str) -> None:
    for name in ("cell_voltage", "charging", "light"):
        talk.apply(read(BY_NAME[name], 0))
    view = talk.view(NOW)
    limit_s = FRESH_FOR_S[key]
    assert view.fresh(key, NOW + limit_s) is not None
    known = view.known(key, NOW + limit_s + 0.01)
    assert known is not None
    assert known.is_stale
    assert view.fresh(key, NOW + limit_s + 0.01) is None


@pytest.mark.promise("a")
def test_on_a_slow_line_a_value_is_as_old_as_the_line_is_late(talk: Conversation) -> None:
    view = talk.view(NOW, lag_s=0.7)
    assert view.is_slow
    assert view.fresh("active", NOW + 0.2) is False
    known = view.known("active", NOW + 0.4)
    assert known is not None
    assert (known.is_stale, known.at) == (True, NOW - 0.7)
    quick = talk.view(NOW, lag_s=SLOW_S)
    assert not quick.is_slow
    assert quick.fresh("active", NOW + 0.9) is False


def test_a_streamed_status_may_be_as_old_as_the_next_one_is_late(talk: Conversation) -> None:
    view = streamed(talk, 0.0, 1.0, 2.0)
    assert view.fresh("active", NOW + 3.4) is False, "one report a second"
    assert view.fresh("active", NOW + 3.6) is None


# After its end


@pytest.mark.promise("f")
@pytest.mark.parametrize("reason", EndReason)
def test_with_its_end_nothing_is_fresh_any_more(talk: Conversation, reason: EndReason) -> None:
    streamed(talk, 0.0, 0.1)
    talk.apply(Ended(reason, NOW + 0.1))
    view = talk.view(NOW + 0.1)
    assert not view.is_going
    assert not view.is_streaming
    for key in view.values:
        known = view.known(key, NOW + 0.1)
        assert known is not None
        assert known.is_stale
        assert view.fresh(key, NOW + 0.1) is None
    assert view.settings(NOW + 0.1) == {}
    assert view.boot_count == 37, "what it was is still to be seen"
    assert view.reported == (False, False)
