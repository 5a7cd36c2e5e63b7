"""Cells of CSV files that are safe in spreadsheets."""

import csv
import io
from collections.abc import Iterable, Sequence

BYTE_ORDER_MARK = b"\xef\xbb\xbf"  # tells spreadsheets that the file is UTF-8
# What begins a formula, also in full width.
_FORMULA_STARTS = ("=", "+", "-", "@", "|", "%", "＝", "＋", "－", "＠", "'")


def csv_text(head: Sequence[str], rows: Iterable[Iterable[object]]) -> str:
    """CSV by RFC 4180, without a byte-order mark."""
    text = io.StringIO(newline="")
    writer = csv.writer(text)
    writer.writerow(head)
    writer.writerows(map(cell, row) for row in rows)
    return text.getvalue()


def cell(value: object) -> str:
    """Text has an apostrophe in front where a spreadsheet would take it for a formula."""
    if isinstance(value, list):
        value = " ".join(map(str, value))
    if isinstance(value, str):
        return f"'{value}" if value.lstrip().startswith(_FORMULA_STARTS) else value
    if isinstance(value, bool):
        return "true" if value else "false"
    return "" if value is None else str(value)
