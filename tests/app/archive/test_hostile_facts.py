"""What anybody with the documented role may add to a server: rows that are signed well and cannot be read.

Each is left out, named once and counted; everybody else's exchange, questions and reports go on.
"""

import json
from collections.abc import Iterator
from contextlib import ExitStack, closing
from datetime import UTC, datetime
from pathlib import Path

import pytest

from app.archive.chains import chains_in
from app.archive.exchange import Exchanged, exchange, export_facts, import_facts
from app.archive.facts import DOMAIN, FACT_COLUMNS, Fact, FactRow, fact_id, make_fact
from app.archive.fleet_state import fleet_state
from app.archive.module_history import module_history
from app.archive.module_names import ConflictKind, NamedModule, Settlement, names_of, pair_of, settle
from app.archive.postgres import TABLE, PostgresFacts, open_server
from app.stations.station import encoded
from app.store.facts import FactKind, payload_of
from app.text.user_error import UserError
from tests.support.records.archive_server import ArchiveServer
from tests.support.records.archive_stations import NOON, ArchiveStation, archive_station
from tests.support.records.stations_made import station

AT = NOON.isoformat(timespec="milliseconds")
DEEP = "[" * 400 + "]" * 400
MANY_DIGITS = "9" * 4300
KEY = encoded(bytes(32))
RECORD: dict[str, object] = {"hash": "h", "previous": None, "module": "M-07", "adapter": "", "number": 1, "checks": []}


def _check(**changes: object) -> str:
    return json.dumps({"module": "M-07", "record": {**RECORD, **changes}})


def _settled(**changes: object) -> str:
    plain = {"modules": [[KEY, "M-07"], [KEY, "M-08"]], "is_same": True, "name": "M", "who": "Li", "revision": 1}
    return json.dumps({**plain, **changes})


def _act(detail: str) -> str:
    return json.dumps(
        {"entry": [1, 1, "p", "o", AT, "lock", "42", detail, None, None, None], "previous": "", "hash": "h"}
    )


UNREADABLE = {
    "a lone surrogate": ("module", r'{"module":"\ud800"}'),
    "a lone surrogate in another text": ("module", r'{"adapter":"\ud800","module":"M-07"}'),
    "a lone surrogate as a key": ("module", r'{"\udfff":1,"module":"M-07"}'),
    "a lone surrogate in an act": ("audit_link", _act(r'{"module":"\ud800"}')),
    "deep nesting": ("module", f'{{"module":"M-07","x":{DEEP}}}'),
    "deep nesting of an unknown kind": ("parachute_repack", f'{{"x":{DEEP}}}'),
    "deep nesting in an act": ("audit_link", _act(f'{{"module":{DEEP}}}')),
    "an act without its columns": ("audit_link", '{"entry":["x"],"hash":"h","previous":""}'),
    "a list as the hash of an act": ("audit_link", _act("{}").replace('"h"', "[]")),
    "a list as a name": ("module", '{"module":["M-07"]}'),
    "no name": ("module", '{"module":""}'),
    "a name that reads backwards": ("module", '{"module":"M\\u202e70"}'),
    "a name of a novel's length": ("module", json.dumps({"module": "M" * 100_000})),
    "a number of 4,300 digits": ("trigger_record", f'{{"module":"M-07","place":{MANY_DIGITS},"raw":"00"}}'),
    "an infinite number": ("parachute_repack", '{"x":1e999}'),
    "a trigger record that is none": ("trigger_record", '{"module":"M-07","raw":"zz"}'),
    "a judgement of a list": ("judgement", '{"module":"M-07","raw":[],"judgement":"real"}'),
    "a judgement that is a list": ("judgement", '{"module":"M-07","raw":"00","judgement":[]}'),
    "settings that are a list": ("settings_snapshot", '{"module":"M-07","settings":[]}'),
    "a test that is a list": ("guided_test", '{"module":"M-07","test":[],"verdict":"passed"}'),
    "a check without a record": ("preflight_check", '{"module":"M-07"}'),
    "a check of a list": ("preflight_check", _check(module=["M-07"])),
    "a check whose hash is a list": ("preflight_check", _check(hash=[])),
    "a check whose previous one is a list": ("preflight_check", _check(previous=[])),
    "a check whose checks are numbers": ("preflight_check", _check(checks=[1])),
    "a check that measured infinity": ("preflight_check", _check(checks=[{"measured": 7}]).replace("7}", "1e999}")),
    "a revision of 4,300 digits": ("settlement", _settled().replace(": 1}", f": {MANY_DIGITS}}}")),
    "a revision below one": ("settlement", _settled(revision=0)),
    "a decision of a list": ("settlement", _settled(who=[])),
    "a decision about a station that is none": ("settlement", _settled(modules=[["x", "M-07"], [KEY, "M-08"]])),
    "another spelling of a station": ("settlement", _settled(modules=[[f"{KEY}!", "M-07"], [KEY, "M-08"]])),
    "a decision about one module": ("settlement", _settled(modules=[[KEY, "M-07"], [KEY, "M-07"]])),
    "a list": ("module", "[]"),
    "more than a fact may be long": ("preflight_check", json.dumps({"x": "a" * 4_000_000})),
}  # fmt: skip


def signed_row(kind: str, payload: str, made_at: str = AT, signer: str = "hostile") -> tuple[str, ...]:
    """A row as anybody can make it, with a good id and a good signature."""
    who = station(signer)
    id_ = fact_id(kind, encoded(who.public), made_at, payload)
    return (id_, kind, encoded(who.public), made_at, payload, encoded(who.sign(f"{DOMAIN}\n{id_}\n".encode())))


@pytest.fixture
def url(server: ArchiveServer, url_of_stations: str) -> str:
    server.run(f"DELETE FROM {TABLE}", database="dps_s")
    return url_of_stations


@pytest.fixture
def stations(tmp_path: Path) -> Iterator[list[ArchiveStation]]:
    with ExitStack() as stack:
        yield [stack.enter_context(archive_station(tmp_path / name)) for name in "AB"]


def _add(url: str, *rows: tuple[str, ...]) -> None:
    import psycopg

    with psycopg.connect(url, autocommit=True) as connection:
        for row in rows:
            connection.execute(f"INSERT INTO {TABLE} VALUES (%s, %s, %s, %s, %s, %s)".encode(), row)


def _sync(one: ArchiveStation, url: str) -> Exchanged:
    one.archive.collect()
    with closing(open_server(url)) as there:
        return exchange(one.archive, there)


def _look_at_everything(one: ArchiveStation) -> None:
    names = names_of(one.archive)
    fleet_state(one.archive, names, datetime.now(UTC))
    chains_in(one.archive)
    for module in names.modules:
        json.dumps([event.text.translated() for event in module_history(one.archive, module).events]).encode()


def test_a_row_that_cannot_be_read_is_left_out_named_once_and_counted(stations: list[ArchiveStation], url: str) -> None:
    one, other = stations
    one.check("M-07")
    _sync(one, url)
    rows = {name: signed_row(*row) for name, row in UNREADABLE.items()}
    times = ("0001-01-01T00:00:00.000+00:00", "9999-12-31T23:59:59.999+00:00", "2026-01-02T12:00:00.000+23:59")
    rows |= {at: signed_row("module", '{"module":"M-07"}', at) for at in times}
    _add(url, *rows.values())
    for place in (one, other, one):
        before = place.ids()
        done = _sync(place, url)
        named = [refusal.id for refusal in done.refused]
        assert {name for name, row in rows.items() if row[0][:64] not in named} == set()
        assert done.refused_count == len(named) == len(rows)
        assert all(refusal.sentence().translated().isprintable() for refusal in done.refused)
        assert place.ids() == (before | one.ids())
        _look_at_everything(place)


def test_what_an_older_version_took_over_is_not_read_either(stations: list[ArchiveStation], url: str) -> None:
    one = stations[0]
    one.check("M-07")
    one.archive.collect()
    kept = len(one.ids())
    for row in (signed_row(*row) for name, row in UNREADABLE.items() if "surrogate" not in name):
        one.archive.others.write(
            "INSERT INTO facts (id, kind, station, made_at, payload, signature, digest, module, link, hash) "
            "VALUES (?, ?, ?, ?, ?, ?, 'x', 'M-07', 'h', 'x')", row)  # fmt: skip
    _look_at_everything(one)
    assert sum(len(one.archive.of_kind(kind)) for kind in FactKind) == kept


def test_rows_of_four_megabytes_are_not_even_fetched(
    stations: list[ArchiveStation], server: ArchiveServer, url: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    fetched = 0
    read = PostgresFacts.read

    def counted(self: PostgresFacts, ids: list[str]) -> list[FactRow]:
        nonlocal fetched
        rows = list(read(self, ids))
        fetched += sum(len(str(value)) for row in rows for value in row)
        return rows

    monkeypatch.setattr(PostgresFacts, "read", counted)
    server.run(
        f"INSERT INTO {TABLE} SELECT md5(n::text) || md5(n::text), 'module', '{KEY}', '{AT}', "
        "'{\"x\":\"' || repeat('a', 4000000) || '\"}', 'x' FROM generate_series(1, 5) AS n",
        f"INSERT INTO {TABLE} SELECT repeat('f', 100000), repeat('k', 4000000), '', '', '', ''",
        database="dps_s",
    )
    stations[1].meet("M-07")
    done = _sync(stations[1], url)
    assert (done.refused_count, done.sent) == (6, 1)
    assert fetched < 100_000


def test_a_page_of_long_facts_is_fetched_in_parts(
    stations: list[ArchiveStation], url: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """So that what is in memory at a time is bounded."""
    _add(url, *(signed_row("repack", json.dumps({"x": "a" * 900_000, "n": number})) for number in range(20)))
    largest = 0
    read = PostgresFacts.read

    def measured(self: PostgresFacts, ids: list[str]) -> list[FactRow]:
        nonlocal largest
        rows = list(read(self, ids))
        largest = max(largest, sum(len(str(row[4])) for row in rows))
        return rows

    monkeypatch.setattr(PostgresFacts, "read", measured)
    assert _sync(stations[1], url).received == 20
    assert largest < 9_000_000


def test_a_file_is_read_like_a_server(stations: list[ArchiveStation], tmp_path: Path) -> None:
    """Also a line of 5 MB is one line."""
    one, other = stations
    one.meet("M-07")
    stick = tmp_path / "stick"
    export_facts(one.archive, stick)
    rows = [dict(zip(FACT_COLUMNS, signed_row(*row), strict=True)) for row in UNREADABLE.values()]
    lines = [*map(json.dumps, rows), "x" * 5_000_000]
    head, honest = stick.read_text(encoding="utf-8").splitlines()
    stick.write_text("\n".join((head, *lines, honest)), encoding="utf-8")
    done = import_facts(other.archive, stick)
    assert (done.refused_count, len(done.refused), done.received) == (len(lines), len(lines), 1)
    assert other.ids() == one.ids()


# Who decides which module is which


def _decision(signer: ArchiveStation | str, *, is_same: bool, revision: int, who: str = "Eve", of: list[NamedModule]
) -> Fact:  # fmt: skip
    content = Settlement(pair=pair_of(*of), is_same=is_same, name="X" if is_same else "", who=who, revision=revision)
    who_signs = station(signer) if isinstance(signer, str) else signer.station
    return make_fact(FactKind.SETTLEMENT.value, AT, payload_of(content.content()), who_signs)


@pytest.fixture
def alike(stations: list[ArchiveStation]) -> list[NamedModule]:
    """Two modules by one name, both known at the first station."""
    one, other = stations
    for place in stations:
        place.meet("M-07")
        place.archive.collect()
    one.archive.add(other.archive.of_kind(FactKind.MODULE))
    return [NamedModule(encoded(place.station.public), "M-07") for place in stations]


def test_a_decision_of_an_unknown_station_counts_after_a_person_here_accepted_it(
    stations: list[ArchiveStation], alike: list[NamedModule]
) -> None:
    one = stations[0]
    archive = one.archive
    one.archive.add([_decision("hostile", is_same=True, revision=1, of=alike)])
    names = names_of(archive)
    assert len(names.modules) == 2
    (asked,) = names.conflicts
    assert asked.kind is ConflictKind.PROPOSAL
    assert "Eve" in asked.question().translated()
    settle(archive, *alike, is_same=True, name="X", who="Li")
    names = names_of(archive)
    assert ([module.name for module in names.modules], names.conflicts) == (["X"], ())
    (module,) = names.modules
    told = [event.text.translated() for event in module_history(one.archive, module).events]
    assert [text for text in told if "Li" in text]


def test_whoever_decides_says_who(stations: list[ArchiveStation], alike: list[NamedModule]) -> None:
    with pytest.raises(UserError, match="who decides"):
        settle(stations[0].archive, *alike, is_same=False, who="  ")
