"""An archive on a PostgreSQL server: what was altered on it, who may do what, passwords, connections that break."""

import logging
import re
import ssl
import sys
from collections.abc import Iterator
from contextlib import ExitStack, closing
from pathlib import Path
from typing import Any

import pytest

from app.archive.archive import all_facts, status_of, sync
from app.archive.places import SQL_FILE, PostgresPlace, server_url
from app.store.fact_store import Store
from app.store.rows import SaidNew
from app.text.messages import UserError
from tests.support.processes import ran_code, running
from tests.support.records.archive_server import (
    PASSWORD,
    ROOT_CERTIFICATE,
    WITH_PASSWORD,
    ArchiveServer,
    archive_server,
    write_certificate,
)
from tests.support.records.stored import add, open_store

PAGE = Path(__file__).parents[3] / "docs" / "archive.md"


@pytest.fixture(scope="module")
def server() -> Iterator[ArchiveServer]:
    with archive_server() as one:
        yield one


@pytest.fixture
def stores(tmp_path: Path, server: ArchiveServer) -> Iterator[list[Store]]:
    server.run("DROP TABLE IF EXISTS dps_s_facts")
    with ExitStack() as stack:
        yield [stack.enter_context(closing(open_store(tmp_path / name))) for name in "AB"]


def _say(store: Store, *modules: str) -> None:
    for module in modules:
        add(store, SaidNew(is_new=True), module).result()


def test_the_program_makes_the_table_that_the_page_says() -> None:
    said = PAGE.read_text(encoding="utf-8")
    for statement in SQL_FILE.read_text(encoding="utf-8").replace(" IF NOT EXISTS", "").split(";\n"):
        assert statement in said


def test_a_database_of_another_encoding_is_refused_in_one_sentence(stores: list[Store], server: ArchiveServer) -> None:
    server.run("CREATE DATABASE latin ENCODING 'LATIN1' TEMPLATE template0")
    with pytest.raises(UserError, match="UTF8"):
        sync(stores[0], server.url("latin"))


@pytest.mark.promise("g")
def test_a_role_that_may_only_add_and_read_is_enough(stores: list[Store], server: ArchiveServer) -> None:
    """In a database that is set up as docs/archive.md says."""
    import psycopg

    block = re.search(r"```sql\n(.+?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    assert block is not None
    first, *rest = [line for line in block[1].split(";\n") if line.strip()]
    server.run(first)
    rest = [line.replace("a long password", PASSWORD) for line in rest if "\\connect" not in line]
    server.run(*rest, database="dps_s")
    url = server.url("dps_s", "dps_s_station")
    one, other = stores
    _say(one, "M-07")
    assert sync(one, url).sent == 2
    again = sync(one, url)
    assert (again.sent, again.received, again.left_out_count) == (0, 0, 0)
    assert sync(other, url).received == 2
    with psycopg.connect(url, autocommit=True) as connection:
        for statement in (b"DELETE FROM dps_s_facts", b"UPDATE dps_s_facts SET kind = 'x'", b"DROP TABLE dps_s_facts"):
            with pytest.raises(psycopg.errors.InsufficientPrivilege):
                connection.execute(statement)
    server.run("CREATE DATABASE empty_one")
    with pytest.raises(UserError, match="GRANT SELECT, INSERT ON dps_s_facts TO dps_s_station"):
        sync(one, server.url("empty_one", "dps_s_station"))


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
                sync(store, server.url())
    kept = {str(id_) for (id_,) in server.run("SELECT id FROM dps_s_facts")}
    assert told - kept == set()
    for name in "ABCD":
        with closing(open_store(tmp_path / name)) as store:
            with all_facts(store) as facts:
                rows = facts.connection.execute("SELECT id FROM facts").fetchall()
            assert {id_ for (id_,) in rows} == kept


_STATION = """
import sys, threading
from pathlib import Path
from app.archive.archive import sync
from app.store.rows import SaidNew
from app.text.messages import UserError
from tests.support.records.stored import add, open_store

store = open_store(Path(sys.argv[1]))

def write():
    while True:
        row = add(store, SaidNew(is_new=True), "M-07").result()
        print(row.id, flush=True)

threading.Thread(target=write, daemon=True).start()
while True:
    try:
        sync(store, sys.argv[2])
    except UserError as error:
        print(error, file=sys.stderr)
"""


@pytest.mark.promise("g")
def test_a_connection_that_is_cut_is_one_sentence_and_nothing_is_missed(
    stores: list[Store], server: ArchiveServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("app.archive.archive.PAGE_ROWS", 2)
    one, other = stores
    _say(one, *(f"M-{number}" for number in range(5)))
    for store, page in ((one, "add"), (other, "rows")):
        whole = getattr(PostgresPlace, page)

        def cut(*args: Any, whole: Any = whole) -> Any:
            done = whole(*args)
            server.run("SELECT pg_terminate_backend(pid) FROM pg_stat_activity WHERE pid <> pg_backend_pid()")
            return done

        with monkeypatch.context() as patch:
            patch.setattr(PostgresPlace, page, cut)
            with pytest.raises(UserError, match="cannot be used"):
                sync(store, server.url())
        sync(store, server.url())
    assert status_of(other).facts == 7


# Its address, passwords and certificates


@pytest.mark.parametrize(
    ("typed", "kept"),
    [
        (" postgres://li@db.example:5433/dps_s", "postgresql://li@db.example:5433/dps_s"),
        ("postgresql://db/x?sslrootcert=/My%20Files/a+b", "postgresql://db/x?sslrootcert=/My%20Files/a+b"),
        ("postgresql://[::1]/x", "postgresql://[::1]/x"),
        ("postgresql:///?service=hangar", "postgresql:///?service=hangar"),
    ],
)
def test_an_address_is_kept_as_it_is_typed(typed: str, kept: str) -> None:
    assert server_url(typed) == server_url(kept) == kept


@pytest.mark.parametrize(
    "typed",
    [
        "host=db password=secret",
        "postgresql://li:secret@db/x",
        "postgresql://:secret@[::1]/x",
        "postgresql://li:a@secret@db/x",
        "postgresql://li:se/cret@db/x",
        "postgresql://" + "secret" * 1000,
        "postgresql://li@db/x?sslPassWord=secret",
        "postgresql://li@db/x?%70assword=secret",
        "postgresql://li@db/x?scram_client_key=secret",
    ],
)
@pytest.mark.promise("g")
def test_what_may_be_a_password_is_refused_without_showing_it(typed: str) -> None:
    with pytest.raises(UserError) as caught:
        server_url(typed)
    assert "secret" not in str(caught.value)
    assert "cret@" not in str(caught.value)


def test_psycopg_is_loaded_only_for_a_server_and_its_absence_is_a_sentence() -> None:
    program = (
        "import sys, app.__main__, app.archive.places\n"
        "assert app.__main__.main(['archive', 'status']) == 0\n"
        "assert not {'psycopg', 'psycopg_binary'} & sys.modules.keys()\n"
        "sys.modules['psycopg'] = None\n"
        "sys.exit(app.__main__.main(['archive', 'sync', 'postgresql://db/x']))\n"
    )
    done = ran_code(program)
    assert done.returncode == 3
    assert 'pip install "dps-s-configurator[archive]"' in done.stderr


def keep_password(folder: Path, server: ArchiveServer, monkeypatch: pytest.MonkeyPatch, password: str) -> None:
    """Where libpq looks for it."""
    passwords = folder / "pgpass"
    passwords.write_text(f"127.0.0.1:{server.port}:archive:{WITH_PASSWORD}:{password}\n", encoding="utf-8")
    passwords.chmod(0o600)
    monkeypatch.setenv("PGPASSFILE", str(passwords))


@pytest.mark.promise("g")
def test_the_password_comes_from_the_systems_places_and_shows_nowhere(
    stores: list[Store], server: ArchiveServer, tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
    caplog: pytest.LogCaptureFixture,
) -> None:  # fmt: skip
    caplog.set_level(logging.DEBUG)
    one, url = stores[0], server.tcp_url()
    with pytest.raises(UserError, match="no password supplied") as caught:
        sync(one, url)
    assert url in str(caught.value)
    keep_password(tmp_path, server, monkeypatch, "wrong-one")
    with pytest.raises(UserError, match="authentication failed") as caught:
        sync(one, url)
    assert "wrong-one" not in str(caught.value)
    keep_password(tmp_path, server, monkeypatch, PASSWORD)
    sync(one, url)
    assert PASSWORD not in caplog.text
    assert all(PASSWORD.encode() not in path.read_bytes() for path in one.folder.rglob("*") if path.is_file())


@pytest.mark.promise("g")
def test_the_systems_roots_are_found(server: ArchiveServer, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """OpenSSL as psycopg brings it looks for them in a folder that no system has."""
    address = f"{server.tcp_url()}?sslrootcert=system"
    keep_password(tmp_path, server, monkeypatch, PASSWORD)
    for name in "SSL_CERT_FILE", "SSL_CERT_DIR":
        monkeypatch.setenv(name, "")  # so that what the program sets is taken back
        monkeypatch.delenv(name)
    roots = ssl.get_default_verify_paths()._replace(cafile=str(server.folder / ROOT_CERTIFICATE))
    monkeypatch.setattr("ssl.get_default_verify_paths", lambda: roots)
    PostgresPlace(address).close()
    write_certificate(tmp_path / "other.crt", tmp_path / "other.key")
    monkeypatch.setenv("SSL_CERT_FILE", str(tmp_path / "other.crt"))  # a person's own choice counts
    with pytest.raises(UserError, match="certificate verify failed"):
        PostgresPlace(address)
