"""Exports all trigger records of a module as CSV, safe for spreadsheets."""

from collections.abc import Iterable
from pathlib import Path

from app.records.check_store import SeenRecord
from app.system.files import write_whole
from app.text.csv_cells import BYTE_ORDER_MARK, csv_text
from app.text.messages import clean
from app.trigger_records.fields import FIELDS, fields_of
from app.trigger_records.history import record_of, sentence

HEAD = ("module", "place", "first_seen_at", "new", "confirmed", *FIELDS, "told", "judgement", "note")


NONE: frozenset[int] = frozenset()


def archive_csv(
    module: str, records: Iterable[SeenRecord], *, new: frozenset[int] | None = None, seen_once: frozenset[int] = NONE
) -> bytes:
    """`new`: ids of those that are new since the last visit; `seen_once`: of those that came in one reading only.
    UTF-8 with the mark by which spreadsheets know it.

    The sentence is in the language in use; names carry the units.
    """
    rows = []
    for one in records:
        record = record_of(one.raw)
        values: dict[str, object] = {
            **fields_of(record),
            "module": clean(module),
            "place": one.place + 1,
            "first_seen_at": one.first_seen_at,
            "new": None if new is None else one.id in new,
            "confirmed": one.id not in seen_once,
            "told": sentence(record).in_words(),
            "judgement": one.judgement.value if one.judgement is not None else None,
            "note": clean(one.note, longest=2000),
        }
        rows.append([values[name] for name in HEAD])
    return BYTE_ORDER_MARK + csv_text(HEAD, rows).encode()


def write_archive(
    path: Path,
    module: str,
    records: Iterable[SeenRecord],
    *,
    new: frozenset[int] | None = None,
    seen_once: frozenset[int] = NONE,
) -> None:
    """The file whole or not at all. Raises `OSError`."""
    write_whole(path, archive_csv(module, records, new=new, seen_once=seen_once))
