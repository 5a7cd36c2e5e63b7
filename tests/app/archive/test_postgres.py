"""An archive on a PostgreSQL server: what was altered on it, who may do what, passwords, connections that break."""

import json
import logging
import ssl
from collections.abc import Iterator
from contextlib import ExitStack, closing
from pathlib import Path

import pytest

from app.archive.exchange import Exchanged, exchange
from app.archive.facts import FACT_COLUMNS
from app.archive.postgres import TABLE, open_server, system_roots
from app.archive.server_url import server_url
from app.text.user_error import UserError
from tests.app.cli.reference.test_schemas import faults
from tests.support.cli_line import run_here
from tests.support.records.archive_server import (
    PASSWORD,
    ROOT_CERTIFICATE,
    WITH_PASSWORD,
    WITHOUT_TLS,
    ArchiveServer,
    write_certificate,
)
from tests.support.records.archive_stations import ArchiveStation, archive_station


@pytest.fixture
def stations(tmp_path: Path, server: ArchiveServer) -> Iterator[list[ArchiveStation]]:
    server.run(f"DROP TABLE IF EXISTS {TABLE}")
    with ExitStack() as stack:
        yield [stack.enter_context(archive_station(tmp_path / name)) for name in "AB"]


def _sync(one: ArchiveStation, url: str) -> Exchanged:
    one.archive.collect()
    with closing(open_server(url)) as there:
        return exchange(one.archive, there, page=5)


def test_what_was_altered_on_the_server_is_named_and_not_taken_over(
    stations: list[ArchiveStation], server: ArchiveServer
) -> None:
    one, other = stations
    for number in range(3):
        one.check("M-07", cell_v=3.937 + number)
    one.act()
    assert _sync(one, server.url()).sent == 6
    assert _sync(one, server.url()) == Exchanged()
    server.run(
        f"UPDATE {TABLE} SET payload = replace(payload, '3.937', '4.137')",
        f"INSERT INTO {TABLE} SELECT repeat('f', 64), kind, station, made_at, payload, signature FROM {TABLE} "
        "WHERE kind = 'module'",
        f"INSERT INTO {TABLE} VALUES ('', '', '', '', '', ''), ('zz" + "9" * 100_000 + "', 'ü', '\x1b[2J', '', '', '')",
    )
    for station, received in ((other, 5), (other, 0), (one, 0)):
        done = _sync(station, server.url())
        assert (done.received, done.sent, done.refused_count) == (received, 0, 4)
    assert {one.kind for one in done.refused} == {"preflight_check", "module", "", "ü"}
    assert "was altered" in " ".join(one.sentence().translated() for one in done.refused)
    assert max(len(one.sentence().translated()) for one in done.refused) < 250
    server.run(f"DELETE FROM {TABLE} WHERE length(id) <> 64 OR id LIKE 'fff%' OR kind = 'preflight_check'")
    assert _sync(one, server.url()).sent == 3
    assert _sync(other, server.url()).received == 1
    assert other.content() == one.content()


@pytest.mark.parametrize("encoding", ["SQL_ASCII", "LATIN1"])
def test_a_server_of_any_encoding_gives_what_it_was_sent(
    stations: list[ArchiveStation], server: ArchiveServer, encoding: str
) -> None:
    """Debian makes a server without an encoding where the system has no locale."""
    one, other = stations
    database = encoding.lower()
    server.run(f"CREATE DATABASE {database} ENCODING '{encoding}' TEMPLATE template0")
    one.check("M-中")
    assert _sync(one, server.url(database)).sent == 2
    assert _sync(other, server.url(database)).received == 2
    assert other.content() == one.content()
    assert _sync(other, server.url(database)) == Exchanged()


@pytest.mark.parametrize("column", ["id", "kind", "payload"])
def test_a_row_that_is_no_text_is_named_and_passed_over(
    stations: list[ArchiveStation], server: ArchiveServer, column: str
) -> None:
    one, other = stations
    server.run(f"CREATE DATABASE bytes_{column} ENCODING 'SQL_ASCII' TEMPLATE template0")
    url = server.url(f"bytes_{column}")
    for number in range(3):
        one.check("M-07", cell_v=3.9 + number)
    assert _sync(one, url).sent == 4
    values = ", ".join("E'00\\xff'" if name == column else f"'00{name}'" for name in FACT_COLUMNS)
    server.run(f"INSERT INTO {TABLE} VALUES ({values})", database=f"bytes_{column}")
    for sent in (2, 0):
        if sent:
            other.act()
        done = _sync(other, url)
        assert (done.received, done.sent, done.refused_count) == (4 if sent else 0, sent, 1)
    assert [row.sentence().translated().rsplit(": ")[-1] for row in done.refused] == ["cannot be read."]


def test_a_role_that_may_only_add_and_read_is_enough(
    stations: list[ArchiveStation], server: ArchiveServer, url_of_stations: str
) -> None:
    one, other = stations
    one.meet("M-07")
    assert _sync(one, url_of_stations).sent == 1
    assert _sync(other, url_of_stations).received == 1
    import psycopg

    with psycopg.connect(url_of_stations, autocommit=True) as connection:
        for statement in ("DELETE FROM {}", "UPDATE {} SET kind = 'x'", "TRUNCATE {}", "DROP TABLE {}"):
            with pytest.raises(psycopg.errors.InsufficientPrivilege):
                connection.execute(statement.format(TABLE).encode())
    server.run("CREATE DATABASE empty_one")
    with pytest.raises(UserError, match="permission denied"):
        _sync(one, server.url("empty_one", "dps_s_station"))


def test_the_password_comes_from_the_systems_places_and_shows_nowhere(
    stations: list[ArchiveStation], server: ArchiveServer, tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
    caplog: pytest.LogCaptureFixture,
) -> None:  # fmt: skip
    caplog.set_level(logging.DEBUG)
    one = stations[0]
    plain = server.tcp_url(WITH_PASSWORD)
    with pytest.raises(UserError, match="no password was found") as caught:
        _sync(one, plain)
    assert plain in str(caught.value)
    with pytest.raises(UserError, match="authentication failed") as caught:
        _sync(one, server.tcp_url(WITH_PASSWORD, "wrong-one"))
    assert "wrong-one" not in str(caught.value)
    with closing(open_server(server.tcp_url(WITH_PASSWORD, PASSWORD))) as there:
        assert there.url.shown == plain
    monkeypatch.setattr("app.archive.postgres.import_module", lambda _name: _Keyring)
    with closing(open_server(plain)):
        assert _Keyring.asked == ("dps-s archive", f"guarded@127.0.0.1:{server.port}/archive")
    monkeypatch.undo()
    passwords = tmp_path / "pgpass"
    passwords.write_text(f"127.0.0.1:{server.port}:archive:guarded:{PASSWORD}\n", encoding="utf-8")
    passwords.chmod(0o600)
    monkeypatch.setenv("PGPASSFILE", str(passwords))
    _sync(one, plain)
    monkeypatch.delenv("PGPASSFILE")
    service = tmp_path / "services"
    service.write_text(
        f"[hangar]\nhost=127.0.0.1\nport={server.port}\nuser=guarded\ndbname=archive\npassword={PASSWORD}\n",
        encoding="utf-8",
    )
    monkeypatch.setenv("PGSERVICEFILE", str(service))
    _sync(one, "postgresql:///?service=hangar")
    assert PASSWORD not in caplog.text
    assert all(PASSWORD.encode() not in path.read_bytes() for path in one.folder.rglob("*") if path.is_file())


class _Keyring:
    asked: tuple[str, str] = ("", "")

    @classmethod
    def get_password(cls, service: str, user: str) -> str:
        cls.asked = (service, user)
        return PASSWORD


@pytest.fixture(autouse=True)
def _systems_own_roots(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("SSL_CERT_FILE", "SSL_CERT_DIR"):
        monkeypatch.delenv(name, raising=False)


@pytest.fixture
def guarded(server: ArchiveServer) -> str:
    """An address with a password, without TLS's options."""
    return server.tcp_url(WITH_PASSWORD, PASSWORD)


def _is_encrypted(url: str) -> bool:
    with closing(open_server(url)) as there:
        return bool(there._read("SELECT ssl FROM pg_stat_ssl WHERE pid = pg_backend_pid()")[0][0])


def test_a_server_is_trusted_by_the_root_that_the_address_names(
    server: ArchiveServer, guarded: str, tmp_path: Path
) -> None:
    right = f"?sslmode=verify-full&sslrootcert={server.folder / ROOT_CERTIFICATE}"
    assert _is_encrypted(guarded + right)
    with pytest.raises(UserError, match=r"does not match host name .localhost.$"):
        open_server(guarded.replace("127.0.0.1", "localhost") + right)
    write_certificate(tmp_path / "other.crt", tmp_path / "other.key")
    with pytest.raises(UserError, match=r"cannot be used: this computer does not trust its certificate$"):
        open_server(f"{guarded}?sslmode=verify-full&sslrootcert={tmp_path / 'other.crt'}")
    with pytest.raises(UserError, match=r"root certificate file .* does not exist$"):
        open_server(f"{guarded}?sslmode=verify-ca&sslrootcert={tmp_path / 'none'}")


def test_the_systems_roots_are_found(
    server: ArchiveServer, guarded: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """OpenSSL as psycopg brings it looks for them in a folder that no system has."""
    monkeypatch.setattr("app.archive.postgres.ROOT_FILES", (tmp_path / "none", server.folder / ROOT_CERTIFICATE))
    for options in ("sslrootcert=system", "sslmode=verify-full&sslrootcert=system"):
        assert _is_encrypted(f"{guarded}?{options}")
    with pytest.raises(UserError, match='weak sslmode "require"'):
        open_server(f"{guarded}?sslmode=require&sslrootcert=system")
    write_certificate(tmp_path / "other.crt", tmp_path / "other.key")
    monkeypatch.setattr("app.archive.postgres.ROOT_FILES", (tmp_path / "other.crt",))
    with pytest.raises(UserError, match="does not trust"):
        open_server(f"{guarded}?sslrootcert=system")


def test_roots_that_lie_in_no_file_are_written_into_one(
    server: ArchiveServer, guarded: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    trusted = ssl.create_default_context(cafile=str(server.folder / ROOT_CERTIFICATE))
    monkeypatch.setattr("app.archive.postgres.ROOT_FILES", ())
    monkeypatch.setattr("app.archive.postgres.ssl.create_default_context", lambda: trusted)
    assert _is_encrypted(f"{guarded}?sslrootcert=system")
    with system_roots() as file:
        assert file is not None
        assert file.read_text(encoding="ascii") == (server.folder / ROOT_CERTIFICATE).read_text(encoding="ascii")
    assert not file.exists()


def test_tls_is_as_the_address_says(server: ArchiveServer, guarded: str) -> None:
    assert _is_encrypted(f"{guarded}?sslmode=require")
    assert not _is_encrypted(f"{guarded}?sslmode=disable")
    without = server.tcp_url(WITHOUT_TLS, PASSWORD)
    assert not _is_encrypted(without)
    for options in ("sslmode=require", f"sslmode=verify-full&sslrootcert={server.folder / ROOT_CERTIFICATE}"):
        with pytest.raises(UserError, match="rejects connection"):
            open_server(f"{without}?{options}")


def test_the_command_exchanges_and_says_what_was_altered(
    stations: list[ArchiveStation], server: ArchiveServer, capsys: pytest.CaptureFixture[str]
) -> None:
    one = stations[0]
    one.check("M-07")
    _sync(one, server.url())
    found = []
    for words, code in (([server.url(), "--remember"], 0), ([], 0), ([], 4)):
        found.append(json.loads(run_here(capsys, ["archive", "sync", *words, "--json"], code).out))
        if len(found) == 2:
            server.run(f"UPDATE {TABLE} SET made_at = '2020-01-01T00:00:00+00:00' WHERE kind = 'preflight_check'")
    assert [fault for report in found for fault in faults("archive_exchange", report)] == []
    assert [(report["received"], report["refused_count"]) for report in found] == [(2, 0), (0, 0), (0, 1)]
    assert [(one["kind"], one["why"]) for one in found[2]["refused"]] == [("preflight_check", "it was altered")]
    status = json.loads(run_here(capsys, ["archive", "status", "--json"]).out)
    assert (status["server"], status["not_shared"]) == (server_url(server.url()).shown, 0)
