"""Trigger records as JSON, as CSV and as a table for people. No port in sight."""

import csv
import io
import os
import stat
import tempfile
from contextlib import suppress
from pathlib import Path

from app.commands.console import table
from app.explain import record_values
from app.i18n import tr
from app.procedures.history import History
from protocol.messages import TriggerRecord
from protocol.text import marked

FIELDS = (
    "boot_count",
    "uptime_s",
    "sources",
    "attitude_threshold_deg",
    "freefall_acceleration_g",
    "freefall_time_s",
    "serial_connected",
    "charging",
    "light_v",
    "cell_voltage_v",
    "implausible",
    "raw",
)
"""The names of the contract: the head of the CSV too, since they carry the units."""

_FORMULA_STARTS = ("=", "+", "-", "@", "\t", "\r")
"""What makes a spreadsheet calculate instead of show."""

_SOURCES = {
    "serial": marked("serial"),
    "attitude": marked("attitude"),
    "pwm": "PWM",
    "freefall": marked("free fall"),
}


def json_of(history: History) -> dict[str, object]:
    """The object of `dps-s history --json`."""
    return {
        "records": [_values(record) for record in history.records],
        "empty_slots": history.empty_slots,
    }


def _values(record: TriggerRecord) -> dict[str, object]:
    return {
        **record_values(record),
        "implausible": list(record.implausible),
        "raw": record.raw.hex(" ").upper(),
    }


def csv_of(history: History) -> str:
    """CSV by RFC 4180, without a byte-order mark."""
    text = io.StringIO(newline="")
    writer = csv.writer(text)
    writer.writerow(FIELDS)
    for record in history.records:
        values = _values(record)
        writer.writerow([_cell(values[name]) for name in FIELDS])
    return text.getvalue()


def _cell(value: object) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, list):
        return defused(" ".join(value))
    return defused(value) if isinstance(value, str) else str(value)


def defused(text: str) -> str:
    """`text` with an apostrophe before it where a spreadsheet would take it for a formula."""
    return f"'{text}" if text.startswith(_FORMULA_STARTS) else text


def write_csv(path: str, history: History) -> None:
    """Write the file whole or not at all, in UTF-8 with the mark by which spreadsheets know it. Raises `OSError`."""
    data = b"\xef\xbb\xbf" + csv_of(history).encode()
    target = Path(os.path.realpath(path))
    if target.exists() and not target.is_file():
        target.write_bytes(data)  # a pipe or a device cannot be replaced
        return
    mode = stat.S_IMODE(target.stat().st_mode) if target.exists() else 0o666 & ~_umask()
    number, name = tempfile.mkstemp(prefix=f".{target.name}.", dir=target.parent)
    try:
        with os.fdopen(number, "wb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        Path(name).chmod(mode)
        Path(name).replace(target)
    except BaseException:
        with suppress(OSError):
            Path(name).unlink()
        raise


def _umask() -> int:
    """The only way to read it is to set it; nobody else makes files meanwhile."""
    mask = os.umask(0o077)
    os.umask(mask)
    return mask


def page_of(history: History) -> list[str]:
    """A table with the records in the order in which the module sent them, and what is to be said about them."""
    if not history.records:
        lines = [tr("The module keeps no trigger records.")] if history.is_confirmed else [tr("No records came.")]
        return lines + _remarks(history)
    head = (
        tr("Boot"),
        tr("After power-on"),
        tr("Source"),
        tr("Attitude"),
        tr("Free fall"),
        tr("Serial"),
        tr("Charging"),
        tr("Light"),
        tr("Cell"),
    )
    return table(head, [_row(record) for record in history.records]) + _remarks(history)


def _row(record: TriggerRecord) -> tuple[str, ...]:
    cell = f"{record.cell_voltage_v:.2f} V"
    return (
        str(record.boot_count),
        duration(record.uptime_s),
        sources_in_words(record.sources),
        f"{record.attitude_threshold_deg}°",
        f"{record.freefall_acceleration_g:.1f} g, {record.freefall_time_s:.2f} s",
        tr("connected") if record.serial_connected else tr("not connected"),
        tr("yes") if record.charging else tr("no"),
        f"{record.light_v:.1f} V",
        f"{cell} (!)" if "cell_voltage_v" in record.implausible else cell,
    )


def duration(seconds: int) -> str:
    """ "1:48", "18:12:15": minutes and seconds, with hours where there are any."""
    hours, rest = divmod(seconds, 3600)
    minutes, rest = divmod(rest, 60)
    return f"{hours}:{minutes:02}:{rest:02}" if hours else f"{minutes}:{rest:02}"


def sources_in_words(sources: tuple[str, ...]) -> str:
    words = []
    for name in sources:
        text = _SOURCES.get(name, name)
        words.append(tr(text))
    return ", ".join(words) or tr("unknown")


def _remarks(history: History) -> list[str]:
    remarks = []
    if any(record.implausible for record in history.records):
        remarks.append(tr("(!) no lithium cell has this voltage without external power; it is shown as it came."))
    if history.empty_slots:
        remarks.append(tr("{count} slots are empty.", count=history.empty_slots))
    return ["", *remarks] if remarks else []
