"""Takes over stores and archives of former layouts: every row becomes a fact, with the id that it has in archives.

The store had a table for each kind (layouts 8 and 9), the archive's file all facts again (1 and 2). The file as it was
is kept beside the new one (`app.store.database`). To be removed when nobody has such a file any more.
"""

import hashlib
import json
import sqlite3
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from datetime import UTC, datetime
from typing import Any, Final, NamedTuple

from app.store.facts import (
    ADD_FACT,
    FORMER_ENTRY,
    SET_STATE,
    ChainFault,
    FactKind,
    digest_of,
    fact_hash,
    object_in,
    payload_of,
    utc_time,
)
from app.store.schema import StoreLayout, make_tables

_Row = Mapping[str, Any]
_BEGUN: Final = FORMER_ENTRY.index("settled_at")
"""Number of values that an entry of the audit log had from the start; the rest are its outcome."""


class _New(NamedTuple):
    kind: FactKind
    at: str
    content: Mapping[str, Any]
    link: str | None = None
    module: str | None = None
    """Where it is not in the content."""


def convert_store(connection: sqlite3.Connection) -> None:
    """Within a transaction."""
    connection.text_factory = lambda text: text.decode("utf-8", "replace")
    old = _Former(connection)
    new = [fact for table, facts_of in _SOURCES for row in old.rows(table) for fact in facts_of(old, row)]
    new += [fact for link in old.links() if (fact := _audit_link(old, link)) is not None]
    faults = old.log_faults()
    make_tables(connection)
    hashes = dict.fromkeys(filter(None, (_add(connection, fact) for fact in new)))
    add_migrated(connection, [*hashes], faults)
    for key, value in old.states():
        connection.execute(SET_STATE, (key, payload_of(value)))
    _drop(connection, old.tables)
    connection.text_factory = str


def convert_archive(connection: sqlite3.Connection) -> None:
    """Its own facts stay, too: they may have been taken from a store that was restored from a copy since. The progress
    of exchanges is found out again by the next one."""
    columns = "id, kind, station, made_at, payload, signature, digest, module, link"
    connection.execute("ALTER TABLE facts RENAME TO former")
    make_tables(connection)
    rows = connection.execute(f"SELECT {columns} FROM former ORDER BY number").fetchall()  # noqa: S608
    connection.executemany(
        f"INSERT INTO facts ({columns}, hash) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?)",  # noqa: S608
        ((*row, fact_hash(row[1], row[3], row[4])) for row in rows),
    )
    _drop(connection, ("former", "sources", "exchanges"))


def add_migrated(connection: sqlite3.Connection, hashes: list[str], faults: list[tuple[int, str]]) -> None:
    """The first fact of the chain holds a digest of all before it, and what was wrong with the former audit log."""
    at = datetime.now(UTC).isoformat(timespec="milliseconds")
    content = {"facts": len(hashes), "digest": digest_of(hashes), "faults": faults,
               "previous": hashes[-1] if hashes else ""}  # fmt: skip
    _add(connection, _New(FactKind.MIGRATED, at, content))


def _add(connection: sqlite3.Connection, new: _New) -> str | None:
    """Its hash; None where the same fact is there already. What was read without an error is JSON."""
    payload = payload_of(new.content)
    hash_ = fact_hash(new.kind.value, new.at, payload)
    if connection.execute("SELECT 1 FROM facts WHERE hash = ?", (hash_,)).fetchone():
        return None
    module = new.module or new.content.get("module")
    name = module if isinstance(module, str) else None
    connection.execute(ADD_FACT, (new.kind.value, new.at, payload, name, new.link, hash_))
    return hash_


def _drop(connection: sqlite3.Connection, tables: "tuple[str, ...]") -> None:
    for table in tables:
        connection.execute(f"DROP TABLE IF EXISTS {table}")


class _Former:
    tables: Final = (
        "measured_values", "preflight_checks", "trigger_records", "visits", "settings_snapshots", "guided_tests",
        "module_states", "streams_left_on", "module_settlements", "pending_baud", "audit_chain", "audit", "modules",
    )  # fmt: skip
    """Those that refer to others first."""

    def __init__(self, connection: sqlite3.Connection) -> None:
        self._connection = connection
        self._names = {row["id"]: row["name"] for row in self.rows("modules")}
        self._entries = {row["id"]: tuple(row[name] for name in FORMER_ENTRY) for row in self.rows("audit")}

    def rows(self, table: str) -> list[dict[str, Any]]:
        cursor = self._connection.execute(f"SELECT * FROM {table} ORDER BY rowid")  # noqa: S608
        names = [column[0] for column in cursor.description]
        return [dict(zip(names, row, strict=True)) for row in cursor]

    def name(self, row: _Row) -> str | None:
        """Of the module of this row."""
        return self._names.get(row["module_id"])

    def entry(self, link: _Row) -> tuple[list[Any] | None, str | None]:
        """The entry of the audit log as it was when this link was added, and the link's hash. An entry that was altered
        is as it is now, without a hash, and so is shared with nobody; one that was removed is None."""
        row = self._entries.get(link["entry"])
        if row is None:
            return None, None
        begun = (*row[:_BEGUN], *(None for _ in FORMER_ENTRY[_BEGUN:]))
        for state in (row, begun):
            if link_hash(link["previous"], state) == link["hash"]:
                return list(state), link["hash"]
        return list(row), None

    def links(self) -> list[dict[str, Any]]:
        """The chain of the audit log; an entry that was added from outside has no link."""
        links = self.rows("audit_chain")
        added = self._entries.keys() - {link["entry"] for link in links}
        return links + [{"id": number, "entry": number, "previous": "", "hash": ""} for number in sorted(added)]

    def log_faults(self) -> list[tuple[int, str]]:
        """What is wrong with the audit log, by entry."""
        last, linked, faults = "", dict[int, bool](), set[tuple[int, ChainFault]]()
        for link in self.rows("audit_chain"):
            number, (entry, hash_) = link["entry"], self.entry(link)
            if link["previous"] != last:
                faults.add((number, ChainFault.BROKEN))
            if entry is None or hash_ is None:
                faults.add((number, ChainFault.MISSING if entry is None else ChainFault.ALTERED))
            last, linked[number] = link["hash"], entry is None or tuple(entry) == self._entries[number]
        # The last link of an entry is of what it is now.
        faults |= {(number, ChainFault.ALTERED) for number, is_last_state in linked.items() if not is_last_state}
        faults |= {(number, ChainFault.FOREIGN) for number in self._entries.keys() - linked.keys()}
        return sorted((number, fault.name) for number, fault in faults)

    def states(self) -> Iterator[tuple[str, dict[str, object]]]:
        for row in sorted(self.rows("modules"), key=lambda row: (row["last_seen_at"], row["id"])):
            yield f"module:{row['name']}", {"adapter": row["adapter"]}
        for row in self.rows("module_states"):
            settings = _json(row["settings"])
            yield f"evidence:{self.name(row)}", {"boot_count": row["boot_count"], "settings": settings}
        for row in self.rows("streams_left_on"):
            yield f"stream:{row['adapter']}", {"boot_count": row["boot_count"], "at": row["at"]}


def link_hash(previous: str, entry: "list[Any] | tuple[Any, ...]") -> str:
    """Of a link of the former audit log."""
    text = json.dumps([previous, *entry], ensure_ascii=False, separators=(",", ":"))
    return hashlib.sha256(text.encode("utf-8", "surrogatepass")).hexdigest()


def _module(_old: _Former, row: _Row) -> Iterator[_New]:
    content = {"module": row["name"], "adapter": row["adapter"]}
    yield _New(FactKind.MODULE, _time(row["first_seen_at"]), content)
    if row.get("said_new_at") is not None:
        yield _New(FactKind.SAID_NEW, _time(row["said_new_at"]), {"module": row["name"], "is_new": True})


def _trigger_record(old: _Former, row: _Row) -> Iterator[_New]:
    content = {"module": old.name(row), "place": row["place"], "raw": _hex(row["raw"])}
    yield _New(FactKind.TRIGGER_RECORD, _time(row["first_seen_at"]), content)
    if row["judged_at"] is not None:
        judged = {**content, "judgement": row["judgement"], "note": row["note"]}
        yield _New(FactKind.JUDGEMENT, _time(row["judged_at"]), judged)


def _visit(old: _Former, row: _Row) -> Iterator[_New]:
    content = {
        **_taken(row, "port", "boot_count", "known"), "number": row["id"], "module": old.name(row),
        "slots": _json(row["slots"]), "is_confirmed": bool(row["is_confirmed"]),
    }  # fmt: skip
    yield _New(FactKind.VISIT, _time(row["at"]), content)


def _snapshot(old: _Former, row: _Row) -> Iterator[_New]:
    content = {**_taken(row, "port", "reason", "boot_count"), "number": row["id"], "module": old.name(row),
               "settings": _json(row["settings"])}  # fmt: skip
    yield _New(FactKind.SNAPSHOT, _time(row["taken_at"]), content)


def _check(old: _Former, row: _Row) -> Iterator[_New]:
    content = {"number": row["id"], "module": old.name(row), "record": _json(row["record"])}
    yield _New(FactKind.CHECK, _time(row["at"]), content, row["hash"])
    if row["verdict"] in ("GO", "READY") and not row["is_void"]:
        yield from _reviewed(old, row)


def _reviewed(old: _Former, check: _Row) -> Iterator[_New]:
    """The records that a person had reviewed for a check that passed: only the check's record said so."""
    content = _json(check["record"])
    known = content.get("trigger_records") if isinstance(content, dict) else None
    for row in old.rows("trigger_records"):
        is_of_module = row["module_id"] == check["module_id"] and row["judged_at"] is None
        if is_of_module and isinstance(known, list) and _hex(row["raw"]) in known:
            judgement = {"module": old.name(row), "place": row["place"], "raw": _hex(row["raw"])}
            judgement |= {"judgement": "reviewed", "note": ""}
            yield _New(FactKind.JUDGEMENT, _time(check["at"]), judgement)


def _guided_test(old: _Former, row: _Row) -> Iterator[_New]:
    content = {
        **_taken(row, "adapter", "who", "verdict", "program"), "number": row["id"], "module": old.name(row),
        "test": row["kind"], "is_simulated": bool(row["is_simulated"]), "measured": _json(row["measured"]),
    }  # fmt: skip
    yield _New(FactKind.GUIDED_TEST, _time(row["at"]), content)


def _audit_link(old: _Former, link: _Row) -> _New | None:
    entry, hash_ = old.entry(link)
    if entry is None:
        return None
    content = {"number": link["id"], "module": old.name({"module_id": entry[1]}), "previous": link["previous"],
               "hash": hash_, "entry": entry}  # fmt: skip
    of = dict(zip(FORMER_ENTRY, entry, strict=True))
    name = object_in(of["detail"]).get("module")
    at = _time(of["settled_at"] or of["at"])
    return _New(FactKind.AUDIT, at, content, of["act"], name if isinstance(name, str) else None)


def _settlement(_old: _Former, row: _Row) -> Iterator[_New]:
    content = _json(row["content"])
    yield _New(FactKind.SETTLEMENT, _time(row["at"]), content if isinstance(content, dict) else {"text": content})


def _baud(_old: _Former, row: _Row) -> Iterator[_New]:
    content = {"number": row["id"], **_taken(row, "port", "adapter", "old_rate", "new_rate")}
    intent = _New(FactKind.BAUD, _time(row["at"]), content)
    yield intent
    if row["settled_at"] is not None:
        of = fact_hash(intent.kind.value, intent.at, payload_of(intent.content))
        yield _New(FactKind.OUTCOME, _time(row["settled_at"]), {"outcome": row["outcome"], "of": of}, of)


_SOURCES: Final[tuple[tuple[str, Callable[[_Former, _Row], Iterator[_New]]], ...]] = (
    ("modules", _module), ("trigger_records", _trigger_record), ("visits", _visit),
    ("settings_snapshots", _snapshot), ("preflight_checks", _check), ("guided_tests", _guided_test),
    ("module_settlements", _settlement), ("pending_baud", _baud),
)  # fmt: skip


def _taken(row: _Row, *names: str) -> dict[str, Any]:
    return {name: row[name] for name in names}


def _time(text: str) -> str:
    """In UTC with milliseconds, so that times sort as text; one that is none stays as it is."""
    with suppress(ValueError, OverflowError):
        return utc_time(text)
    return text


def _hex(text: str) -> str:
    with suppress(ValueError):
        return bytes.fromhex(text).hex()
    return text


def _json(text: str) -> object:
    """Text that is no JSON stays text."""
    try:
        value: object = json.loads(text)
        payload_of({"": value})  # neither are infinite numbers
    except (ValueError, RecursionError):
        return text
    return value


STORE: Final = StoreLayout(10, convert_store)
ARCHIVE: Final = StoreLayout(3, convert_archive)
