"""Formats values as CSV cells that are safe in spreadsheets."""

import csv
import io
from collections.abc import Iterable, Sequence
from datetime import UTC, datetime

BYTE_ORDER_MARK = b"\xef\xbb\xbf"
"""Tells spreadsheets that the file is UTF-8."""
_FORMULA_STARTS = ("=", "+", "-", "@", "|", "%", "＝", "＋", "－", "＠", "'")
"""Characters that start a formula, also in their full-width forms."""


def csv_text(head: Sequence[str], rows: Iterable[Iterable[object]]) -> str:
    """CSV by RFC 4180, without a byte-order mark."""
    text = io.StringIO(newline="")
    writer = csv.writer(text)
    writer.writerow(head)
    writer.writerows(map(cell, row) for row in rows)
    return text.getvalue()


def cell(value: object) -> str:
    """A value as a cell; text that would be a formula is defused."""
    match value:
        case None:
            return ""
        case bool():
            return "true" if value else "false"
        case list():
            return defused(" ".join(map(str, value)))
        case str():
            return defused(value)
        case _:
            return str(value)


def utc_cell(text: str) -> str:
    """An ISO 8601 time as "2026-01-31 23:59:59" in UTC, which spreadsheets take as a time; other text unchanged."""
    try:
        return f"{datetime.fromisoformat(text).astimezone(UTC):%Y-%m-%d %H:%M:%S}"
    except ValueError:
        return text


def defused(text: str) -> str:
    """`text` with an apostrophe in front where a spreadsheet would treat it as a formula."""
    return f"'{text}" if text.lstrip().startswith(_FORMULA_STARTS) else text
