"""Model of the Triggers page: columns, and what the page says of the list."""

from enum import IntEnum
from typing import Final

from PySide6.QtGui import QIcon

from app.limits.limits import record_outside
from app.text.i18n import tr
from app.text.messages import UserMessage, capitalised, labelled
from app.trigger_records.history import JUDGEMENT_WORDS, sentence, source_message, uptime_message
from protocol.translatable import marked
from ui.forms.tables import TableColumn
from ui.session.trigger_reading import TriggerReading, TriggerRow
from ui.style.icons import Icon, icon
from ui.style.theme import Meaning


class Column(IntEnum):
    WHEN = 0
    WHY = 1
    SETTINGS = 2
    LINK = 3
    CHARGE = 4
    LIGHT = 5
    CELL = 6
    JUDGED = 7


def record_text(row: TriggerRow) -> str:
    """The record as a sentence, with its note."""
    text = sentence(row.record).translated()
    if row.is_seen_once:
        text = labelled(capitalised(tr("seen once")), text)
    return f"{text} — {row.seen.note}" if row.seen.note else text


def when_text(boot: int, uptime: UserMessage) -> str:
    return tr("{uptime} · boot {boot}", boot=boot, uptime=uptime.translated())


def sources_text(sources: tuple[str, ...]) -> str:
    return " + ".join(source_message(name).translated() for name in sources) or tr("no cause stated")


def _settings(row: TriggerRow) -> str:
    record = row.record
    fall = f"{record.freefall_acceleration_g:.1f} g {record.freefall_time_s:.2f} s"
    return f"{record.attitude_threshold_deg}° {fall}"


def _judged(row: TriggerRow) -> str:
    if row.is_seen_once:
        return tr("seen once")
    return "—" if row.seen.judgement is None else tr(JUDGEMENT_WORDS[row.seen.judgement])


def _doubt_icon(row: TriggerRow) -> QIcon | None:
    return icon(Icon.UNKNOWN, Meaning.ATTENTION) if row.is_seen_once else None


def _cell_meaning(row: TriggerRow) -> Meaning | None:
    is_suspect = row.record.implausible or record_outside(row.record) is not None
    return Meaning.ATTENTION if is_suspect else None


COLUMNS: Final = (
    TableColumn[TriggerRow](
        marked("After power-on"),
        lambda row: when_text(row.record.boot_count, uptime_message(row.record)),
        lambda row: float(row.seen.place),
        picture=_doubt_icon,
    ),
    TableColumn[TriggerRow](
        marked("Why"),
        lambda row: sources_text(row.record.sources),
        widest=lambda: max(f"{tr('attitude')} + {tr('free fall')}", f"{tr('serial')} + PWM", key=len),
        stretches=True,
    ),
    TableColumn[TriggerRow](
        marked("Settings"),
        _settings,
        lambda row: float(row.record.attitude_threshold_deg),
        widest=lambda: "180° 2.5 g 2.55 s",
        is_spare=True,
    ),
    TableColumn[TriggerRow](
        marked("Link"),
        lambda row: tr("connected") if row.record.serial_connected else tr("no"),
        widest=lambda: tr("connected"),
        is_spare=True,
    ),
    TableColumn[TriggerRow](
        marked("Charger"),
        lambda row: tr("charging") if row.record.charging else tr("no"),
        widest=lambda: tr("charging"),
        is_spare=True,
    ),
    TableColumn[TriggerRow](
        marked("Light"),
        lambda row: f"{row.record.light_v:.1f} V",
        lambda row: row.record.light_v,
        widest=lambda: "25.5 V",
        is_spare=True,
    ),
    TableColumn[TriggerRow](
        marked("Cell"),
        lambda row: f"{row.record.cell_voltage_v:.2f} V",  # the sentence says what is wrong with it
        lambda row: row.record.cell_voltage_v,
        picture=lambda row: icon(Icon.WARNING, Meaning.ATTENTION) if _cell_meaning(row) else None,
        ink=_cell_meaning,
        widest=lambda: "0.00 V",
        is_spare=True,
    ),
    TableColumn[TriggerRow](
        marked("Reviewed"), _judged, widest=lambda: max(tr("seen once"), *map(tr, JUDGEMENT_WORDS.values()), key=len)
    ),
)


def csv_name(module: str) -> str:
    safe = "".join(character if character.isalnum() or character in "-_" else "_" for character in module[:40])
    return f"dps-s triggers {safe or 'module'}.csv"


def is_known_empty(work: TriggerReading) -> bool:
    """Whether the module confirmed that it has no records."""
    return work.reading is not None and work.reading.history.is_confirmed and not work.rows


def count_text(work: TriggerReading) -> str:
    """Without a number while the list is empty: its place says why."""
    count = len(work.rows)
    return labelled(tr("Trigger records"), count) if count else tr("Trigger records")


def empty_title(work: TriggerReading) -> str:
    if work.is_busy:
        return tr("Reading the trigger records")
    if is_known_empty(work):
        return labelled(tr("Trigger records"), 0)
    return capitalised(tr("not read yet") if work.reading is None else tr("unknown"))


def empty_text(work: TriggerReading, *, is_open: bool) -> str:
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
