"""The list of a batch as CSV and PDF, and the labels of its modules."""

import json
from collections.abc import Sequence
from datetime import datetime
from pathlib import Path
from typing import Final

from app.fleet.batch import OPEN, READY, BatchRow, ModuleBatch
from app.modules.labels import A4, Label, Paper, Printer, write_labels
from app.records.report_files import carries, check_target
from app.system.files import write_whole
from app.text.csv_cells import csv_text, utc_cell
from app.text.i18n import tr
from app.text.messages import clean
from app.text.template import page
from protocol.translatable import marked

HEAD: Final = ("name", "result", "time_utc", "settings_code", "boot_count", "why")
TITLES: Final = (marked("Module"), marked("Result"), marked("Time (UTC)"), marked("Settings code"),
                 marked("Boot count"), marked("Why"))  # fmt: skip
FORMAT: Final = "dps-s batch"
"""Marks the files of a batch, which a batch may replace."""
_ROWS_ON_PAGE: Final = 40


def cells(row: BatchRow) -> tuple[str, ...]:
    """For people, below `TITLES`."""
    boots = "" if row.boot_count is None else str(row.boot_count)
    why = "" if row.why is None else row.why.translated()
    return row.name, tr(row.result), utc_cell(row.at), row.code, boots, why


def summary(batch: ModuleBatch, rows: Sequence[BatchRow]) -> str:
    """Translated."""
    count = sum(row.result == READY for row in rows)
    return tr("Batch {names}, profile {profile}: {count} of {all} done", names=batch.title,
              profile=clean(batch.profile.name), count=count, all=len(batch.names))  # fmt: skip


def is_done(rows: Sequence[BatchRow]) -> bool:
    """Every name is given."""
    return not any(row.result == OPEN for row in rows)


def check_batch_target(path: Path) -> None:
    """Raise `UserError` if the list or the labels cannot be written there."""
    head = ",".join(HEAD).encode()
    check_target(path, lambda data: carries(FORMAT, data) or data.startswith(head), beside=".csv")


def write_list(path: Path, batch: ModuleBatch, rows: Sequence[BatchRow], printer: Printer) -> None:
    """As CSV and as PDF. Raises `UserError`, `OSError` or `RuntimeError`."""
    check_batch_target(path)
    table = csv_text(HEAD, (
        (row.name, row.result.lower(), utc_cell(row.at), row.code, row.boot_count,
         "" if row.why is None else row.why.in_english()) for row in rows
    ))  # fmt: skip
    write_whole(path.with_suffix(".csv"), table.encode())
    write_whole(path, printer(_pages(batch, rows), A4, _mark()))


def write_batch_labels(path: Path, rows: Sequence[BatchRow], paper: Paper, printer: Printer) -> None:
    """Of the names that are given, if any. Raises `UserError`, `OSError` or `RuntimeError`."""
    check_batch_target(path)
    done = [row for row in rows if row.result == READY]
    labels = [Label(row.name, datetime.fromisoformat(row.at).astimezone(), row.code) for row in done]
    if labels:
        write_labels(path, labels, paper, printer, carried=_mark())


def _mark() -> bytes:
    return json.dumps({"format": FORMAT}).encode()


def _pages(batch: ModuleBatch, rows: Sequence[BatchRow]) -> list[str]:
    """The list as HTML, by page."""
    lines = [cells(row) for row in rows]
    return [
        page(
            "batch.html",
            title=summary(batch, rows),
            head=[tr(title) for title in TITLES],
            rows=lines[start : start + _ROWS_ON_PAGE],
        )
        for start in range(0, len(lines), _ROWS_ON_PAGE)
    ]
