"""Modules left ACTIVE: which report, and which person's word, ends what; and whether one may have fired unseen."""

from types import MappingProxyType
from typing import Any

import pytest

from app.engine.conversation import ConversationView, How, Known
from app.safety.last_known import Activation, keep_away, seen_activation, was_heard_active
from app.safety.left_active import (
    FiringDoubt,
    LeftActive,
    all_left,
    drop_intent,
    keep_left,
    note_go,
    note_locked,
    note_named,
)
from protocol.events import Ended, EndReason

PORT = "/dev/ttyUSB0"


class State:
    """The store's state in memory; what is kept is encoded as the store does it."""

    def __init__(self) -> None:
        self.kept: dict[str, Any] = {}

    def states(self, prefix: str, /) -> dict[str, Any]:
        return {key.removeprefix(prefix): value for key, value in self.kept.items() if key.startswith(prefix)}

    def set_state(self, key: str, value: object, /) -> None:
        from msgspec import to_builtins

        self.kept.pop(key, None)
        if value is not None:
            self.kept[key] = to_builtins(value)

    def names(self) -> list[str]:
        return [left.module or left.run for left in all_left(self)]


def left(run: str, name: str = "", at: str = "2026-01-02T12:00:00+00:00", **more: Any) -> LeftActive:
    return LeftActive(run=run, module=name, port=PORT, at=at, **more)


@pytest.mark.promise("f")
def test_one_that_was_altered_hides_no_other() -> None:
    state = State()
    state.set_state("left:x", {"module": 1})
    keep_left(state, left("a"))
    assert len(state.names()) == 1


@pytest.mark.promise("l")
def test_it_ends_when_the_module_reports_locked_in_the_same_conversation() -> None:
    state = State()
    keep_left(state, left("a"))
    keep_left(state, left("b"))
    note_locked(state, "b")
    assert state.names() == ["a"], "another module at the same port never ends it"
    note_locked(state, "a")
    assert state.kept == {}


@pytest.mark.promise("l")
def test_a_named_one_ends_when_a_module_reports_locked_that_was_named_so_afterwards() -> None:
    state = State()
    note_named(state, "before", "M-07")
    keep_left(state, left("a", "M-07"))
    note_locked(state, "before")
    assert state.names() == ["M-07"], "that one was named before"
    note_named(state, "b", "M-08")
    note_locked(state, "b")
    assert state.names() == ["M-07"], "another name"
    note_named(state, "c", "M-07")
    assert state.names() == ["M-07"], "a name alone says nothing"
    note_locked(state, "c")
    assert state.kept == {}


@pytest.mark.promise("l")
def test_one_without_a_name_ends_by_no_report_of_another_conversation() -> None:
    state = State()
    keep_left(state, left("a"))
    note_named(state, "b", "M-07")
    note_locked(state, "b")
    assert state.names() == ["a"]


def test_it_gets_the_name_that_is_said_later_in_its_conversation() -> None:
    state = State()
    keep_left(state, left("a"))
    note_named(state, "a", "M-07")
    assert state.names() == ["M-07"]
    keep_left(state, left("a"))  # by who does not know the name
    assert state.names() == ["M-07"]


def test_of_a_name_only_the_last_is_told() -> None:
    state = State()
    keep_left(state, left("a", "M-07", at="2026-01-02T12:00:00+00:00"))
    keep_left(state, left("b", at="2026-01-02T13:00:00+00:00"))
    keep_left(state, left("c", "M-07", at="2026-01-02T14:00:00+00:00"))
    assert [one.run for one in all_left(state)] == ["c", "b"]


def test_an_act_of_which_nothing_came_leaves_nothing_behind_and_takes_nothing_away() -> None:
    state = State()
    keep_left(state, left("a", intent="first"))
    drop_intent(state, "a", "second")
    assert state.names() == ["a"]
    keep_left(state, left("a", intent="second"))
    drop_intent(state, "a", "second")
    assert state.names() == ["a"], "what was left behind before stays"
    drop_intent(state, "a", "first")
    assert state.kept == {}


@pytest.mark.promise("l")
def test_after_go_it_is_a_plain_line_and_else_a_warning() -> None:
    state = State()
    keep_left(state, left("a", "M-07"))
    (warned,) = all_left(state)
    assert warned.is_warning
    assert warned.sentence.startswith("M-07 was left ACTIVE on 2026-01-02 ")
    assert keep_away() in warned.sentence
    note_go(state, "a")
    keep_left(state, left("a", "M-07"))  # at the end of its conversation
    (plain,) = all_left(state)
    assert not plain.is_warning
    assert keep_away() not in plain.sentence
    keep_left(state, left("a", "M-07", is_lock_unconfirmed=True))
    (unconfirmed,) = all_left(state)
    assert unconfirmed.is_warning
    assert unconfirmed.sentence.startswith("M-07: LOCK not confirmed on 2026-01-02 ")
    keep_left(state, left("a", "M-07"))
    assert all_left(state) == (unconfirmed,), "a later report of ACTIVE carries out no LOCK"


# What is shown


def view(active: bool | None, reason: EndReason | None = None, *, number: int = 1, boots: int = 37) -> ConversationView:
    values = {"boot_count": Known(boots, How.READ, 1.0), "tilt_deg": Known(5, How.READ, 1.0)}
    if active is not None:
        values["active"] = Known(active, How.READ, 1.0)
    ended = None if reason is None else Ended(reason, 2.0)
    return ConversationView(number, values=MappingProxyType(values), ended=ended)


def test_the_activation_as_it_is_shown() -> None:
    assert seen_activation(view(True), 1.5) == (Activation.ACTIVE, 1.0)
    assert seen_activation(view(False), 1.5) == (Activation.LOCKED, 1.0)
    assert seen_activation(view(None), 1.5) == (Activation.UNKNOWN, None)
    assert seen_activation(view(True), 9.0) == (Activation.WAS_ACTIVE, 1.0)
    assert seen_activation(view(False), 9.0) == (Activation.WAS_LOCKED, 1.0)
    assert seen_activation(view(True, EndReason.SILENT), 2.0).state is Activation.WAS_ACTIVE
    assert [seen_activation(view(one), 9.0).may_fire for one in (True, False, None)] == [True, False, False]
    assert [was_heard_active(view(one, EndReason.SILENT)) for one in (True, False, None)] == [True, False, False]


# Fired before the restart?


def is_in_doubt(ended: ConversationView, begun: ConversationView) -> bool:
    doubt = FiringDoubt()
    doubt.note_ended(ended)
    doubt.note_begun(begun)
    return doubt.is_open


@pytest.mark.parametrize(
    ("active", "reason", "boots", "is_open"),
    [
        (True, EndReason.RESTARTED, 38, True),
        (None, EndReason.RESTARTED, 38, True),
        (False, EndReason.RESTARTED, 38, False),
        (True, EndReason.SILENT, 38, True),
        (True, EndReason.CONTRADICTED, 38, True),
        (True, EndReason.SILENT, 37, False),
        (True, EndReason.SILENT, 90, False),
        (False, EndReason.SILENT, 38, False),
    ],
)
@pytest.mark.promise("f")
def test_a_module_that_restarted_while_active_may_have_fired(
    active: bool | None, reason: EndReason, boots: int, is_open: bool
) -> None:
    assert is_in_doubt(view(active, reason), view(False, number=2, boots=boots)) is is_open


@pytest.mark.promise("f")
def test_a_report_of_locked_after_the_restart_takes_no_doubt_away() -> None:
    doubt = FiringDoubt()
    doubt.note_ended(view(False, EndReason.RESTARTED), was_active=True)
    assert doubt.is_open


@pytest.mark.promise("f")
def test_the_doubt_stays_until_the_records_were_read_and_the_notice_was_closed() -> None:
    doubt = FiringDoubt()
    assert not doubt.is_open
    for is_closed_first in (False, True):
        doubt.note_ended(view(True, EndReason.RESTARTED))
        doubt.needs_records, doubt.is_to_be_told = is_closed_first, not is_closed_first
        assert doubt.is_open
        doubt.needs_records = doubt.is_to_be_told = False
        assert not doubt.is_open
