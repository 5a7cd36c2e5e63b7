"""An archive on a PostgreSQL server: what was altered on it, who may do what, passwords, connections that break."""

import json
import logging
import sys
from collections.abc import Iterator
from contextlib import ExitStack, closing
from pathlib import Path
from typing import Any

import pytest

from app.archive.archive import Archive
from app.archive.places import SQL_FILE, PostgresPlace, server_url
from app.archive.sync import Synced, sync
from app.store.fact_store import Store
from app.store.rows import SaidNew
from app.text.messages import UserError
from tests.cli.test_schemas import faults
from tests.files.archive.conftest import PAGE
from tests.support.cli_line import run_here
from tests.support.processes import running
from tests.support.records.archive_server import (
    PASSWORD,
    ROOT_CERTIFICATE,
    WITH_PASSWORD,
    ArchiveServer,
    write_certificate,
)
from tests.support.records.stored import open_store


@pytest.fixture
def stores(tmp_path: Path, server: ArchiveServer) -> Iterator[list[Store]]:
    server.run("DROP TABLE IF EXISTS dps_s_facts")
    with ExitStack() as stack:
        yield [stack.enter_context(closing(open_store(tmp_path / name))) for name in "AB"]


def _say(store: Store, module: str) -> None:
    store.add(SaidNew(is_new=True), module).result()


def _sync(store: Store, url: str) -> Synced:
    return sync(Archive(store), url)


@pytest.mark.promise("g")
def test_what_was_altered_on_the_server_is_named_and_not_taken_over(stores: list[Store], server: ArchiveServer) -> None:
    one, other = stores
    for number in range(3):
        _say(one, f"M-{number}")
    assert _sync(one, server.url()).sent == 4
    assert _sync(one, server.url()) == Synced()
    server.run(
        "UPDATE dps_s_facts SET content = replace(content, 'true', 'false') WHERE module = 'M-1'",
        "INSERT INTO dps_s_facts SELECT repeat('f', 40), kind, module, station, made_at, content FROM dps_s_facts "
        "WHERE module = 'M-2'",
    )
    first = _sync(other, server.url())
    assert (first.received, first.sent, first.left_out_count) == (3, 1, 2)
    assert {one.why for one in first.left_out} == {"altered"}
    again = _sync(other, server.url())
    assert (again.received, again.left_out, again.left_out_count) == (0, [], 2)  # named once a day
    server.run("DELETE FROM dps_s_facts WHERE module = 'M-1'")
    assert _sync(one, server.url()).sent == 1
    other.close()


def test_the_program_makes_the_table_that_the_page_says() -> None:
    said = PAGE.read_text(encoding="utf-8")
    for statement in SQL_FILE.read_text(encoding="utf-8").replace(" IF NOT EXISTS", "").split(";\n"):
        assert statement in said


def test_the_server_itself_refuses_rows_that_are_too_large_or_have_no_id(
    stores: list[Store], server: ArchiveServer
) -> None:
    import psycopg

    _sync(stores[0], server.url())
    for values in (
        f"'x', 'act', null, '{'a' * 64}', '2026', '{{}}'",
        f"'{'f' * 40}', 'act', null, 'short', '2026', '{{}}'",
        f"'{'f' * 40}', 'act', null, '{'a' * 64}', '2026', repeat('x', 1000001)",
    ):
        with pytest.raises(psycopg.errors.CheckViolation):
            server.run(f"INSERT INTO dps_s_facts VALUES ({values})")


def test_a_database_of_another_encoding_is_refused_in_one_sentence(stores: list[Store], server: ArchiveServer) -> None:
    server.run("CREATE DATABASE latin ENCODING 'LATIN1' TEMPLATE template0")
    with pytest.raises(UserError, match="UTF8"):
        _sync(stores[0], server.url("latin"))


@pytest.mark.promise("g")
def test_a_role_that_may_only_add_and_read_is_enough(
    stores: list[Store], server: ArchiveServer, url_of_stations: str
) -> None:
    one, other = stores
    _say(one, "M-07")
    assert _sync(one, url_of_stations).sent == 2
    assert _sync(other, url_of_stations).received == 2
    import psycopg

    with psycopg.connect(url_of_stations, autocommit=True) as connection:
        for statement in ("DELETE FROM {}", "UPDATE {} SET kind = 'x'", "TRUNCATE {}", "DROP TABLE {}"):
            with pytest.raises(psycopg.errors.InsufficientPrivilege):
                connection.execute(statement.format("dps_s_facts").encode())
    server.run("CREATE DATABASE empty_one")
    with pytest.raises(UserError, match="GRANT SELECT, INSERT ON dps_s_facts TO dps_s_station"):
        _sync(one, server.url("empty_one", "dps_s_station"))


@pytest.mark.promise("g")
def test_four_stations_that_write_and_exchange_at_once_and_are_killed_miss_nothing(
    tmp_path: Path, server: ArchiveServer
) -> None:
    server.run("DROP TABLE IF EXISTS dps_s_facts")
    told = set[str]()
    for _ in range(3):
        with ExitStack() as stack:
            programs = [
                stack.enter_context(running(sys.executable, "-c", _STATION, tmp_path / name, server.url()))
                for name in "ABCD"
            ]
            for program in programs:
                told.update(program.out.readline().strip() for _ in range(20))
            for program in programs:
                program.process.kill()
            for program in programs:
                told.update(line.strip() for line in program.out.readlines() if line.endswith("\n"))
    for _ in range(2):
        for name in "ABCD":
            with closing(open_store(tmp_path / name)) as store:
                _sync(store, server.url())
    kept = {str(id_) for (id_,) in server.run("SELECT id FROM dps_s_facts")}
    assert told - kept == set()
    for name in "ABCD":
        with closing(open_store(tmp_path / name)) as store:
            rows = Archive(store).read(lambda facts: facts.connection.execute("SELECT id FROM facts").fetchall())
            assert {id_ for (id_,) in rows} == kept


_STATION = """
import sys, threading
from pathlib import Path
from typing import Any
from app.archive.archive import Archive
from app.archive.sync import sync
from app.store.rows import SaidNew
from app.text.messages import UserError
from tests.support.records.stored import open_store

store = open_store(Path(sys.argv[1]))

def write():
    while True:
        row = store.add(SaidNew(is_new=True), "M-07").result()
        print(row.id, flush=True)

threading.Thread(target=write, daemon=True).start()
while True:
    try:
        sync(Archive(store), sys.argv[2])
    except UserError as error:
        print(error, file=sys.stderr)
"""


@pytest.mark.promise("g")
def test_a_connection_that_is_cut_is_one_sentence_and_nothing_is_missed(
    stores: list[Store], server: ArchiveServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("app.archive.sync.PAGE_ROWS", 2)
    one, other = stores
    for number in range(5):
        _say(one, f"M-{number}")

    def cut(_done: Synced) -> None:
        server.run("SELECT pg_terminate_backend(pid) FROM pg_stat_activity WHERE pid <> pg_backend_pid()")

    for store in stores:
        with pytest.raises(UserError, match="cannot be used"):
            sync(Archive(store), server.url(), cut)
        _sync(store, server.url())
    assert Archive(other).status().facts == 7


@pytest.mark.promise("g")
def test_the_password_comes_from_the_systems_places_and_shows_nowhere(
    stores: list[Store], server: ArchiveServer, tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
    caplog: pytest.LogCaptureFixture,
) -> None:  # fmt: skip
    caplog.set_level(logging.DEBUG)
    one = stores[0]
    plain = server.tcp_url(WITH_PASSWORD)
    with pytest.raises(UserError, match="no password supplied") as caught:
        _sync(one, plain)
    assert plain in str(caught.value)
    with pytest.raises(UserError, match="authentication failed") as caught:
        _sync(one, server.tcp_url(WITH_PASSWORD, "wrong-one"))
    assert "wrong-one" not in str(caught.value)
    with closing(PostgresPlace(server.tcp_url(WITH_PASSWORD, PASSWORD))) as there:
        assert there.name == plain
    passwords = tmp_path / "pgpass"
    passwords.write_text(f"127.0.0.1:{server.port}:archive:guarded:{PASSWORD}\n", encoding="utf-8")
    passwords.chmod(0o600)
    monkeypatch.setenv("PGPASSFILE", str(passwords))
    _sync(one, plain)
    assert PASSWORD not in caplog.text
    assert all(PASSWORD.encode() not in path.read_bytes() for path in one.folder.rglob("*") if path.is_file())


@pytest.fixture(autouse=True)
def _systems_own_roots(monkeypatch: pytest.MonkeyPatch) -> None:
    """As the program sets the variable, and each test begins without it."""
    monkeypatch.setenv("SSL_CERT_FILE", "")
    monkeypatch.delenv("SSL_CERT_FILE")
    monkeypatch.delenv("SSL_CERT_DIR", raising=False)


@pytest.fixture
def guarded(server: ArchiveServer) -> str:
    """An address with a password, without TLS's options."""
    return server.tcp_url(WITH_PASSWORD, PASSWORD)


@pytest.mark.promise("g")
def test_the_systems_roots_are_found(
    server: ArchiveServer, guarded: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """OpenSSL as psycopg brings it looks for them in a folder that no system has."""
    monkeypatch.setattr("app.archive.places.ROOT_FILES", (tmp_path / "none", server.folder / ROOT_CERTIFICATE))
    PostgresPlace(f"{guarded}?sslrootcert=system").close()
    write_certificate(tmp_path / "other.crt", tmp_path / "other.key")
    monkeypatch.setenv("SSL_CERT_FILE", str(tmp_path / "other.crt"))  # a person's own choice counts
    with pytest.raises(UserError, match="certificate verify failed"):
        PostgresPlace(f"{guarded}?sslrootcert=system")


def test_the_command_exchanges_and_says_what_was_altered(
    stores: list[Store], server: ArchiveServer, capsys: pytest.CaptureFixture[str]
) -> None:
    one = stores[0]
    _say(one, "M-07")
    _sync(one, server.url())
    found: list[dict[str, Any]] = []
    with closing(open_store()) as here:
        here.set_state("server", server_url(server.url()).shown).result()
    for words, code in (([server.url()], 0), ([], 0), ([], 4)):
        if len(found) == 2:
            server.run("UPDATE dps_s_facts SET made_at = '2020-01-01T00:00:00.000000+00:00' WHERE module = 'M-07'")
            server.run("UPDATE dps_s_facts SET id = '1' || substr(id, 2) WHERE module = 'M-07'")
        found.append(json.loads(run_here(capsys, ["archive", "sync", *words, "--json"], code).out))
    assert [fault for report in found for fault in faults("archive_sync", report)] == []
    assert [(report["received"], report["left_out_count"]) for report in found] == [(2, 0), (0, 0), (0, 1)]
    assert [one["why"] for one in found[2]["left_out"]] == ["altered"]
    status = json.loads(run_here(capsys, ["archive", "status", "--json"]).out)
    assert faults("archive_status", status) == []
    assert (status["server"], status["not_shared"]) == (server_url(server.url()).shown, 0)
