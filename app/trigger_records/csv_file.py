"""Exports all trigger records of a module as CSV, safe for spreadsheets."""

from collections.abc import Iterable
from pathlib import Path

from app.system.files import write_whole
from app.text.csv_cells import BYTE_ORDER_MARK, csv_text, utc_cell
from app.text.messages import clean
from app.trigger_records.fields import FIELDS, fields_of
from app.trigger_records.history import JUDGEMENT_WORDS, record_of, sentence
from app.trigger_records.kept import SeenRecord

HEAD = ("module", "place", "first_seen_at", "confirmed", *FIELDS, "told", "judgement", "note")
_NONE: frozenset[int] = frozenset()


def write_archive(
    path: Path,
    module: str,
    records: Iterable[SeenRecord],
    *,
    seen_once: frozenset[int] = _NONE,
) -> None:
    """UTF-8 with a byte-order mark, written atomically; the sentence is in the language in use. Raises `OSError`.
    `seen_once`: ids of the records that came in one reading only."""
    rows = []
    for seen in records:
        record = record_of(seen.raw)
        values: dict[str, object] = {
            **fields_of(record),
            "module": clean(module),
            "place": seen.place + 1,
            "first_seen_at": utc_cell(seen.first_seen_at),
            "confirmed": seen.id not in seen_once,
            "told": sentence(record).translated(),
            "judgement": None if seen.judgement is None else JUDGEMENT_WORDS[seen.judgement],
            "note": clean(seen.note, longest=2000),
        }
        rows.append([values[name] for name in HEAD])
    write_whole(path, BYTE_ORDER_MARK + csv_text(HEAD, rows).encode())
