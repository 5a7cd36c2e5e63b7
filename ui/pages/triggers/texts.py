"""Texts of the Triggers page."""

from app.text.i18n import tr
from ui.pages.triggers.controller import TriggersController
from ui.services.module_name import whose


def is_known_empty(work: TriggersController) -> bool:
    """The module itself said, and said again, that it keeps no record."""
    return work.reading is not None and work.reading.history.is_confirmed and not work.rows


def count_text(work: TriggersController) -> str:
    """No number before a reading, or the archive, has given one."""
    count = len(work.rows)
    if count == 0 and not is_known_empty(work):
        return tr("Trigger records")
    return tr("1 trigger record") if count == 1 else tr("{count} trigger records", count=count)


def news_text(work: TriggersController, name: str) -> str:
    module, rows = whose(name), work.rows
    if work.reading is None or (rows and not rows[0].is_kept):
        return module
    if work.is_first_visit:
        return tr("{module} · first visit", module=module)
    return tr("{module} · {new} new since the last visit", module=module, new=work.new_count)


def empty_title(work: TriggersController) -> str:
    if work.is_busy:
        return tr("Reading the trigger records")
    if is_known_empty(work):
        return tr("No trigger records")
    return tr("Not read yet") if work.reading is None else tr("Not known")


def empty_text(work: TriggersController, *, is_open: bool) -> str:
    if work.is_busy:
        return tr("Asking until two readings agree…")
    if is_known_empty(work):
        return tr("The module keeps no trigger records: it has never fired, or its memory was cleared.")
    if work.reading is not None and not work.reading.history.is_answered:
        return tr("The module did not answer the query: its records are not known.")
    if work.reading is not None:
        return tr("No two readings agreed. Read again, or check the line.")
    if is_open:
        return tr("They are read as soon as the module answers.")
    return tr("Connect a module, or choose one that was read before.")
