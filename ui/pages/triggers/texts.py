"""Texts of the Triggers page."""

from app.text.i18n import tr
from app.text.sentences import capitalised
from ui.pages.triggers.controller import TriggersController


def is_known_empty(work: TriggersController) -> bool:
    """Whether the module confirmed that it has no records."""
    return work.reading is not None and work.reading.history.is_confirmed and not work.rows


def count_text(work: TriggersController) -> str:
    """Without a number while the list is empty: its place says why."""
    count = len(work.rows)
    return tr("Trigger records: {count}", count=count) if count else tr("Trigger records")


def news_text(work: TriggersController) -> str:
    """How many are new since the last visit."""
    rows = work.rows
    if work.reading is None or (rows and not rows[0].is_stored):
        return ""
    return tr("no earlier visit") if work.is_first_visit else tr("{count} new", count=work.new_count)


def empty_title(work: TriggersController) -> str:
    if work.is_busy:
        return tr("Reading the trigger records")
    if is_known_empty(work):
        return tr("Trigger records: {count}", count=0)
    return capitalised(tr("not read yet") if work.reading is None else tr("unknown"))


def empty_text(work: TriggersController, *, is_open: bool) -> str:
    if work.is_busy:
        return ""
    if is_known_empty(work):
        return tr("It has never fired, or its memory was cleared.")
    if work.reading is not None and not work.reading.history.is_answered:
        return tr("No answer: the records are unknown.")
    if work.reading is not None:
        return tr("The readings differ: records may be missing. Read again.")
    if is_open:
        return tr("Read as soon as the module answers.")
    return tr("Connect or choose a module.")
