"""Writes a report: FILE.pdf, which carries the record, with FILE.json, the record alone, beside it, each atomically."""

import re
import unicodedata
from collections.abc import Callable
from pathlib import Path

from app.records.record import Record, as_text, recorded_verdict
from app.records.record_files import record_in
from app.records.report_html import body
from app.system.files import write_whole
from app.text.user_error import UserError
from protocol.translatable import marked

Printer = Callable[[str, bytes], bytes]
"""Prints HTML (`report_html.body`) on A4, attaches the record and returns the PDF. Passed in by the
composition root because Qt prints. May raise `OSError` or `RuntimeError`."""

_NOT_IN_NAMES = re.compile(r"[^\w\-]+")
_RESERVED = re.compile(r"(?i)(con|prn|aux|nul|com\d|lpt\d)")
MAX_NAME_LENGTH = 60


def check_target(path: Path, is_ours: Callable[[Path], bool] | None = None) -> None:
    """Raises `UserError` where the report cannot be written there. `is_ours`: whether a file may be replaced."""
    may_replace = is_ours or _is_ours
    if path.suffix.lower() != ".pdf":
        raise UserError(marked("{file}: the name of the report must end in .pdf."), file=path.name)
    if not path.parent.is_dir():
        raise UserError(marked("There is no folder {folder}."), folder=path.parent)
    for target in (path, path.with_suffix(".json")):
        if target.exists() and not may_replace(target):
            text = marked("{file} exists and is not a pre-flight report: choose another name.")
            raise UserError(text, file=target)


def _is_ours(path: Path) -> bool:
    try:
        record_in(path.read_bytes())
    except (UserError, OSError):
        return False
    return True


def write_report(path: Path, record: Record, printer: Printer | None) -> tuple[Path, ...]:
    """Writes the record before it prints, so that a failing printer loses nothing; returns the files written.

    Raises `OSError` or `RuntimeError`; files written before that remain.
    """
    json_path, plain = path.with_suffix(".json"), as_text(record).encode()
    write_whole(json_path, plain)
    if printer is None:
        return (json_path,)
    write_whole(path, printer(body(record), plain))
    return json_path, path


def suggested_name(record: Record) -> str:
    """A valid file name without suffix for any module name: "M-07 2026-11-21 1403 GO"."""
    parts = (str(record.get("module") or ""), str(record.get("at"))[:16].replace("T", " ").replace(":", ""))
    words = [_NOT_IN_NAMES.sub("_", unicodedata.normalize("NFKC", part[:MAX_NAME_LENGTH])).strip("_") for part in parts]
    words.append(recorded_verdict(record).value)
    name = " ".join(word for word in words if word)[:MAX_NAME_LENGTH]
    return f"DPS-S {name}" if _RESERVED.match(name) else name
