"""Formats trigger records as JSON, CSV and text."""

from pathlib import Path

from app.limits.out_of_limits import record_outside
from app.procedures.history import History
from app.system.files import write_whole
from app.terminal.console import columns
from app.text.csv_cells import csv_text
from app.text.durations import stopwatch
from app.text.i18n import tr
from app.text.sentences import in_brackets, join_names
from app.trigger_records.fields import FIELDS, fields_of, source_word
from protocol.messages import TriggerRecord


def json_of(history: History) -> dict[str, object]:
    """The object of `dps-s history --json`."""
    return {
        "records": [fields_of(record) | {"confirmed": is_certain} for record, is_certain in _marked(history)],
        "empty_slots": history.empty_slots,
        "answered": history.is_answered,
        "complete": history.is_confirmed,
    }


def _marked(history: History) -> list[tuple[TriggerRecord, bool]]:
    """Every record, and whether it is certain: seen in at least two readings."""
    return [(record, True) for record in history.records] + [(record, False) for record in history.seen_once]


def csv_of(history: History) -> str:
    head = (*FIELDS, "confirmed")
    values = (fields_of(record) | {"confirmed": is_certain} for record, is_certain in _marked(history))
    return csv_text(head, ([one[name] for name in head] for one in values))


def write_csv(path: str, history: History) -> None:
    """Write the file as a whole. Raises `OSError`."""
    write_whole(Path(path), csv_of(history).encode())


def page_of(history: History) -> list[str]:
    """A table of the records in the order in which the module sent them, and remarks."""
    if not history.all:
        lines = [tr("The module keeps no trigger records.")] if history.is_confirmed else [tr("No records came.")]
        return lines + _remarks(history)
    head = (
        tr("Boot count"),
        tr("After power-on"),
        tr("Source"),
        tr("Attitude"),
        tr("Free fall"),
        tr("Serial"),
        tr("Charging"),
        tr("Light"),
        tr("Cell voltage"),
    )
    rows = [_row(record, is_certain=is_certain) for record, is_certain in _marked(history)]
    return columns([head, *rows]) + _remarks(history)


def _row(record: TriggerRecord, *, is_certain: bool) -> tuple[str, ...]:
    cell, outside = f"{record.cell_voltage_v:.2f} V", record_outside(record)
    if outside is not None:
        cell = f"{cell}{in_brackets(tr(outside.fault.value))}"
    return (
        str(record.boot_count) if is_certain else f"{record.boot_count}{in_brackets('?')}",
        stopwatch(record.uptime_s),
        sources_text(record.sources),
        f"{record.attitude_threshold_deg}°",
        f"{record.freefall_acceleration_g:.1f} g, {record.freefall_time_s:.2f} s",
        tr("yes") if record.serial_connected else tr("no"),
        tr("yes") if record.charging else tr("no"),
        f"{record.light_v:.1f} V",
        tr("{text} (implausible)", text=cell) if "cell_voltage_v" in record.implausible else cell,
    )


def sources_text(sources: tuple[str, ...]) -> str:
    return join_names(source_word(name) for name in sources) or tr("unknown")


def _remarks(history: History) -> list[str]:
    remarks = []
    if history.seen_once:
        remarks.append(f"(?) {tr('Seen in one reading only. Read again.')}")
    low = next((found for one in history.all if (found := record_outside(one)) is not None), None)
    if low is not None:
        remarks.append(f"{in_brackets(tr(low.fault.value)).strip()} < {low.limit}")
    if history.empty_slots:
        remarks.append(tr("Empty slots: {count}.", count=history.empty_slots))
    return ["", *remarks] if remarks else []
