"""What a person wants of a setting: values as typed, edits, and states that claim no more than the module reported."""

import pytest

from app.engine.conversation import How, Known
from app.procedures.write import WriteFault, Written
from app.settings.form import RowState, SettingDraft
from app.settings.values import MAX_NUMBER_LENGTH, SETTINGS_BY_KEY, field_of, parse_value
from app.text.messages import UserError
from protocol.catalogue import BAUD_RATE, BY_NAME
from protocol.fields import Value

TILT, TIME, FLAG = "attitude_threshold_deg", "freefall_time_s", "attitude_trigger"
HELD = Known(60, How.READ, 988.0)


def held(value: Value, how: How = How.READ) -> Known:
    return HELD._replace(value=value, how=how)


def tilt(wanted: Value | str | None = None) -> SettingDraft:
    draft = SettingDraft(BY_NAME["attitude_threshold"])
    draft.take(HELD)
    draft.want(wanted)
    return draft


def written(wanted: Value, after: Known, fault: WriteFault | None = None, *, is_sent: bool = True) -> SettingDraft:
    draft = tilt(wanted)
    draft.is_writing = True
    assert (draft.state, draft.pending) == (RowState.WRITING, None)
    draft.end_write(Written(draft.command, wanted, is_sent=is_sent, read_back=after.value, fault=fault), after)
    return draft


def test_unknown_values_are_never_replaced_by_defaults() -> None:
    draft = SettingDraft(BY_NAME["attitude_threshold"])
    assert (draft.state, draft.wanted, draft.pending) == (RowState.UNKNOWN, None, None)


def test_an_edit_is_pending_until_the_module_has_it() -> None:
    draft = tilt(70)
    assert (draft.state, draft.pending) == (RowState.EDITED, 70)
    draft.want(60)
    assert (draft.state, draft.pending) == (RowState.READ, None)
    # Of a conversation that is over nothing is known, although the number is the same.
    draft.take(HELD._replace(is_stale=True))
    assert draft.pending == 60
    draft.want("650")
    assert (draft.state, draft.pending, draft.unsent) == (RowState.IMPOSSIBLE, None, "650")


def test_verified_is_what_was_read_back_and_stands_until_it_is_set_again() -> None:
    draft = written(70, held(70))
    assert (draft.state, draft.wanted) == (RowState.VERIFIED, None)
    draft.take(held(75, How.ACKNOWLEDGED))
    assert draft.state is RowState.ACKNOWLEDGED
    draft.take(held(70))
    assert draft.state is RowState.READ


def test_a_setting_that_cannot_be_read_back_is_never_verified() -> None:
    draft = SettingDraft(BY_NAME["attitude_trigger"], wanted=False, is_writing=True)
    draft.end_write(
        Written(draft.command, False, is_sent=True, is_acknowledged=True, fault=None), held(False, How.ACKNOWLEDGED)
    )
    assert (draft.state, draft.wanted) == (RowState.ACKNOWLEDGED, None)


def test_a_row_stays_failed_until_the_module_reports_the_value() -> None:
    draft = written(130, held(90), WriteFault.NO_READ_BACK)
    # An acknowledgement proves nothing where the setting can be read.
    for known in (held(90), held(130, How.ACKNOWLEDGED)):
        draft.take(known)
        assert (draft.state, draft.pending) == (RowState.FAILED, 130)
        assert draft.reason.endswith("It holds 90°.")
    draft.take(held(130))
    assert (draft.state, draft.wanted) == (RowState.READ, None)


@pytest.mark.parametrize(
    ("fault", "is_sent", "state"),
    [
        (WriteFault.REFUSED, True, RowState.FAILED),
        (WriteFault.NOT_ALLOWED, False, RowState.EDITED),
        (WriteFault.NOT_SENT, False, RowState.EDITED),
    ],
)
def test_what_was_not_written_stays_edited_until_it_is_discarded(
    fault: WriteFault, is_sent: bool, state: RowState
) -> None:
    draft = written(130, HELD, fault, is_sent=is_sent)
    assert draft.state is state
    draft.want(None)
    assert draft.state is RowState.READ


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
