"""The one question of the window before a write that takes protection away, wherever it begins."""

from collections.abc import Callable, Sequence
from functools import partial

from app.procedures.write_all import SettingChange, risk_message
from app.text.i18n import tr
from ui.style.theme import Meaning
from ui.widgets.notice_bar import Choice, Notice

Write = Callable[..., None]
"""Called with the changes that were shown and `accepted`."""


def is_risk_open(changes: Sequence[SettingChange], accepted: frozenset[SettingChange]) -> bool:
    """Whether the question has to be asked before these changes are written."""
    return any(change.risks and change not in accepted for change in changes)


def risk_notice(
    changes: Sequence[SettingChange], write: Write, cancel: Callable[[], None], *other: Choice
) -> Notice | None:
    """The question in the language in use; None if the changes take nothing away."""
    risk = risk_message(changes)
    if risk is None:
        return None
    return Notice(Meaning.ATTENTION, risk.translated(), (*risk_choices(changes, write, cancel), *other))


def risk_choices(
    changes: Sequence[SettingChange], write: Write, cancel: Callable[[], None], *, is_shown: bool = True
) -> tuple[Choice, ...]:
    anyway = partial(write, accepted=frozenset(changes))
    return (
        Choice("not_now", tr("Cancel"), cancel),
        Choice("write_anyway", tr("Write anyway"), anyway, is_step=True, is_shown=is_shown),
    )
