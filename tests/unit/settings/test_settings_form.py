"""The settings form: values as typed, edits, and states that claim no more than the module reported."""

from types import MappingProxyType
from typing import Any

import pytest

from app.engine.conversation import ConversationView, How, Known
from app.procedures.write import SetReply, WriteFault, Written
from app.settings.form import FormRow, RowState, SettingsForm
from app.settings.profiles import SETTINGS_BY_KEY
from app.settings.values import DEFAULTS, MAX_NUMBER_LENGTH, field_of, parse_value
from app.text.messages import UserError
from protocol.catalogue import BAUD_RATE, SETTINGS
from protocol.events import Ended, EndReason
from protocol.fields import Value

NOW = 1000.0
TILT, TIME, LIGHT, FLAG = "attitude_threshold_deg", "freefall_time_s", "light_threshold_v", "attitude_trigger"
BY_KEY = {command.key: command for command in SETTINGS}
STANDS: dict[str, Value] = {TILT: 60, TIME: 1.6, LIGHT: 1.8, "freefall_acceleration_g": 0.5}


def known(how: How = How.READ, *, ended: bool = False, changes: dict[str, Value] | None = None) -> ConversationView:
    values = {key: Known(value, how, NOW - 12) for key, value in (STANDS | (changes or {})).items()}
    end = Ended(EndReason.RESTARTED, NOW) if ended else None
    return ConversationView(number=1, ended=end, values=MappingProxyType(values))


def row(form: SettingsForm, key: str, view: ConversationView | None = None) -> FormRow:
    return next(one for one in form.rows(view or known(), NOW) if one.command.key == key)


def written(key: str, wanted: Value, **more: Any) -> Written:
    return Written(BY_KEY[key], wanted, **({"heard": SetReply.ACKNOWLEDGED, "fault": None} | more))


def write(form: SettingsForm, *results: Written, after: ConversationView | None = None) -> None:
    form.begin_write(form.changes(known(), NOW))
    form.on_written(results, after or known(), NOW)


def test_unknown_values_are_never_replaced_by_defaults() -> None:
    rows = SettingsForm().rows(ConversationView(), NOW)
    assert {one.state for one in rows} == {RowState.UNKNOWN}
    assert all(one.edited is None and one.module_value is None and not one.is_pending for one in rows)


def test_an_edit_is_pending_until_the_module_has_it() -> None:
    form = SettingsForm()
    form.fill({TILT: 70})
    assert (row(form, TILT).state, row(form, TILT).is_pending) == (RowState.EDITED, True)
    assert [(change.command.key, change.value) for change in form.changes(known(), NOW)] == [(TILT, 70)]
    form.fill({TILT: 60})
    assert not form.changes(known(), NOW)
    # Of a conversation that is over nothing is known, although the number is the same.
    assert [change.value for change in form.changes(known(ended=True), NOW)] == [60]


def test_defaults_are_edits_and_revert_removes_one_or_all() -> None:
    form = SettingsForm()
    form.fill(DEFAULTS)
    wanted = {one.command.key: one.edited for one in form.rows(ConversationView(), NOW) if one.edited is not None}
    assert wanted == {key: value for key, value in DEFAULTS.items() if key != BAUD_RATE.key}
    assert LIGHT not in wanted  # the table names no default for it
    form.fill({LIGHT: 1.9})
    form.revert(TILT)
    assert (row(form, TILT).edited, row(form, LIGHT).edited) == (None, 1.9)
    form.revert()
    assert not form.has_drafts


def test_nothing_can_be_edited_while_writing() -> None:
    form = SettingsForm()
    form.fill({TILT: 70})
    form.begin_write(form.changes(known(), NOW))
    form.fill({TILT: 80})
    form.revert()
    assert (row(form, TILT).state, row(form, TILT).edited) == (RowState.WRITING, 70)
    assert not form.changes(known(), NOW)


def test_verified_is_what_was_read_back_and_stands_until_it_is_set_again() -> None:
    form = SettingsForm()
    form.fill({TILT: 70})
    after = known(changes={TILT: 70})
    write(form, written(TILT, 70, read_back=70), after=after)
    assert row(form, TILT, after).state is RowState.VERIFIED
    assert not form.has_drafts
    assert row(form, TILT, known(How.ACKNOWLEDGED, changes={TILT: 75})).state is RowState.ACKNOWLEDGED
    assert row(form, TILT, known(changes={TILT: 75})).state is RowState.READ


def test_a_setting_that_cannot_be_read_back_is_never_verified() -> None:
    form = SettingsForm()
    form.fill({FLAG: False})
    write(form, written(FLAG, False))
    assert row(form, FLAG, known(How.ACKNOWLEDGED, changes={FLAG: False})).state is RowState.ACKNOWLEDGED


def test_a_row_stays_failed_until_the_module_has_the_value() -> None:
    form = SettingsForm()
    form.fill({TILT: 130})
    write(form, written(TILT, 130, read_back=90, fault=WriteFault.NO_READ_BACK))
    held = known(changes={TILT: 90})
    for _ in range(2):
        red = row(form, TILT, held)
        assert (red.state, red.is_pending, red.edited) == (RowState.FAILED, True, 130)
        assert red.reason.endswith("It holds 90°.")
    assert row(form, TILT, known(changes={TILT: 130})).state is RowState.READ
    assert not form.has_drafts


def test_an_acknowledgement_proves_nothing_where_the_setting_can_be_read() -> None:
    form = SettingsForm()
    form.fill({TILT: 70})
    write(form, written(TILT, 70, fault=WriteFault.NO_READ_BACK))
    received = known(How.ACKNOWLEDGED, changes={TILT: 70})
    assert (row(form, TILT, received).state, row(form, TILT, received).is_pending) == (RowState.FAILED, True)
    assert row(form, TILT, known(changes={TILT: 70})).state is RowState.READ


@pytest.mark.parametrize(
    ("fault", "heard", "state"),
    [
        (WriteFault.REFUSED, SetReply.OTHER, RowState.FAILED),
        (WriteFault.NOT_ALLOWED, SetReply.NOT_SENT, RowState.EDITED),
        (WriteFault.NOT_SENT, SetReply.NOT_SENT, RowState.EDITED),
    ],
)
def test_what_was_not_written_stays_edited_until_it_is_reverted(
    fault: WriteFault, heard: SetReply, state: RowState
) -> None:
    form = SettingsForm()
    form.fill({TILT: 130})
    write(form, written(TILT, 130, fault=fault, heard=heard))
    assert row(form, TILT).state is state
    form.revert(TILT)
    assert row(form, TILT).state is RowState.READ


@pytest.mark.parametrize(
    ("key", "text", "value"),
    [
        (TILT, "60", 60),
        (TILT, "6e1", 60),
        (TIME, "1.60", 1.6),
        (BAUD_RATE.key, "9600", 9600),
        *((FLAG, text, None) for text in ("", "1", "truth", "enabled")),
        *((TILT, text, None) for text in ("", "sixty", "nan", "inf", "60.5", "-1", "1e400", "60.00000000000000001")),
        (TILT, "9" * (MAX_NUMBER_LENGTH + 1), None),
    ],
)
def test_what_was_typed_is_sent_as_typed_or_refused_and_never_rounded(key: str, text: str, value: float | None) -> None:
    field = field_of(SETTINGS_BY_KEY[key])
    if value is None:
        with pytest.raises(UserError):
            parse_value(field, text)
    else:
        assert parse_value(field, text) == value
