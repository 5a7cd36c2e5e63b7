"""How late the module's frames arrive: the limits of what counts."""

from math import inf

import pytest

from protocol.catalogue import BY_NAME, HEARTBEAT, SERIAL_OUTPUT, STATUS
from protocol.lag import MAX_S, STREAM_SHOWS_S, Lag

LIGHT = BY_NAME["light"].query()
CHARGING = BY_NAME["charging"].query()
STATE = STATUS.query()


@pytest.mark.parametrize(("passed_s", "is_answerable"), [(MAX_S, True), (MAX_S + 0.125, False)])
def test_a_question_is_answerable_for_ten_seconds(passed_s: float, is_answerable: bool) -> None:
    lag = Lag(0.0)
    lag.ask(LIGHT, 1.0)
    lag.ask(CHARGING, 1.0 + passed_s)
    assert MAX_S == 10.0
    assert lag.asked_at(LIGHT) == (1.0 if is_answerable else -inf)


@pytest.mark.parametrize(("overdue_s", "lag_s"), [(0.25, 0.5), (MAX_S, MAX_S), (MAX_S + 0.125, 0.5)])
def test_an_overdue_answer_counts_for_ten_seconds(overdue_s: float, lag_s: float) -> None:
    lag = Lag(0.0)
    assert lag.seconds(0.0) is None
    lag.ask(LIGHT, 1.0)
    lag.answer(LIGHT, 1.5)
    assert lag.seconds(2.0) == 0.5
    lag.ask(CHARGING, 2.0)
    assert lag.seconds(5.0) == 0.5, "the module may not know this question"
    lag.ask(LIGHT, 3.0)
    assert lag.seconds(3.0 + overdue_s) == lag_s


@pytest.mark.parametrize(("passed_s", "may_be"), [(STREAM_SHOWS_S, True), (STREAM_SHOWS_S + 0.125, False)])
def test_a_status_may_be_streamed_for_three_seconds_after_an_unasked_frame(passed_s: float, may_be: bool) -> None:
    lag = Lag(1.0)
    assert STREAM_SHOWS_S == 3.0
    assert lag.may_be_streamed(STATE, 1.0 + passed_s) is may_be
    assert not lag.may_be_streamed(LIGHT, 1.0 + passed_s)
    lag.on_unsolicited(11.0)
    assert lag.may_be_streamed(STATE, 11.0 + passed_s) is may_be
    lag.ask(LIGHT, 20.0)
    assert not lag.may_be_streamed(STATE, 20.0)
    lag.ask(SERIAL_OUTPUT.set(True), 21.0)
    assert lag.may_be_streamed(STATE, 21.0 + passed_s) is may_be


def test_what_arrives_after_an_answer_was_sent_after_its_question() -> None:
    lag = Lag(0.0)
    assert lag.sent_after == -inf
    lag.ask(LIGHT, 5.0)
    lag.ask(STATE, 6.0)
    lag.ask(CHARGING, 7.0)
    assert lag.answer_sent_after(STATE, 8.0) == 6.0
    lag.answer(LIGHT, 8.0)
    assert (lag.sent_after, lag.asked_at(LIGHT), lag.asked_at(CHARGING)) == (5.0, -inf, 7.0)
    lag.answer(STATE, 8.0)
    assert (lag.sent_after, lag.seconds(8.0)) == (5.0, 3.0)
    lag.answer(LIGHT, 9.0)
    assert (lag.sent_after, lag.seconds(9.0)) == (5.0, 3.0), "nothing was asked"
    lag.answer(CHARGING, 9.0)
    assert lag.sent_after == 7.0


def test_a_heartbeat_measures_and_proves_nothing() -> None:
    lag = Lag(0.0)
    lag.ask(HEARTBEAT.query(), 5.0)
    lag.answer(HEARTBEAT.query(), 5.25)
    assert (lag.sent_after, lag.seconds(6.0)) == (-inf, 0.25)


def test_a_status_that_may_be_streamed_is_as_new_as_what_was_answered_before() -> None:
    lag = Lag(5.0)
    lag.ask(STATE, 6.0)
    assert lag.answer_sent_after(STATE, 6.5) == -inf
    lag.ask(LIGHT, 6.5)
    lag.answer(LIGHT, 6.75)
    assert lag.answer_sent_after(STATE, 7.0) == 6.5
    lag.ask(STATE, 10.0)
    assert lag.answer_sent_after(STATE, 10.25) == 10.0
