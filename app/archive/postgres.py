"""Facts on a PostgreSQL server: one table, to which rows are only ever added.

The SQL is what CockroachDB, YugabyteDB and Citus take, too. psycopg is loaded here, when a server is used, and nowhere
else. The password comes from libpq's own places (PGPASSFILE, a service file), from the keyring, or from the address.
"""

import logging
import os
import re
import ssl
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from importlib import import_module
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any, Final

from app.archive.content import MAX_LENGTH
from app.archive.facts import BUCKET, FACT_COLUMNS, ID_LENGTH, Digests, Fact, FactRow, StoredRow
from app.archive.server_url import ServerUrl, server_url
from app.text.messages import UserMessage, message
from app.text.user_error import UserError
from protocol.translatable import marked

if TYPE_CHECKING:
    import psycopg

_log = logging.getLogger(__name__)

INSTALL: Final = 'pip install "dps-s-configurator[archive]"'
KEYRING_SERVICE: Final = "dps-s archive"
STATEMENT_LIMIT_S: Final = 120
TABLE: Final = "dps_s_facts"
CREATE_TABLE: Final = (
    f"CREATE TABLE IF NOT EXISTS {TABLE} (id TEXT PRIMARY KEY, kind TEXT NOT NULL, station TEXT NOT NULL, "
    "made_at TEXT NOT NULL, payload TEXT NOT NULL, signature TEXT NOT NULL)"
)
_GIVEN: Final = {
    "connect_timeout": "10",
    "client_encoding": "UTF8",
    "keepalives_idle": "10",
    "keepalives_interval": "5",
    "keepalives_count": "3",
    "tcp_user_timeout": "20000",
}
"""A lost server is noticed within 30 s."""
_NO_ENCODING: Final = "SQL_ASCII"
"""Of such a database psycopg gives bytes."""
_COLUMNS: Final = ", ".join(FACT_COLUMNS)
_DIGEST: Final = "md5(" + " || '|' || ".join(FACT_COLUMNS) + ")"
"""`row_digest` in SQL."""
_CUT: Final = ID_LENGTH + 1
_CUT_ID: Final = f"substr(id, 1, {_CUT})"
_MAX_VALUE_LENGTH: Final = 200
_FETCHED: Final = {"id": _CUT_ID, "payload": f"substr(payload, 1, {MAX_LENGTH})"}
ROOT_FILES: Final = (
    Path("/etc/ssl/certs/ca-certificates.crt"),  # Debian, Ubuntu, Arch
    Path("/etc/pki/tls/certs/ca-bundle.crt"),  # Fedora
    Path("/etc/ssl/ca-bundle.pem"),  # openSUSE
    Path("/etc/ssl/cert.pem"),  # macOS
)
_NO_TABLE: Final = "42P01"
_BETWEEN: Final = re.compile(
    r'^connection (?:failed|is bad): | ?connection to server at "[^"]*"(?: \([^)]*\))?, port \d+ failed: '
    r"| Either provide the file.*$"
)
"""Separates libpq's reasons for several attempts; its advice to disable TLS follows them."""
_PLAIN: Final = {
    "certificate verify failed": marked("this computer does not trust its certificate"),
    "no password supplied": marked("no password was found for it"),
}
"""Parts of libpq's messages that are of no use to the user."""
_VERIFIED: Final = "verify-full"
_NO_PASSWORD: Final = ("no password supplied", "password authentication failed", "28P01", "28000")


class PostgresFacts:
    """The facts on a server; made by `open_server`. Used by one thread."""

    def __init__(self, url: ServerUrl, connection: "psycopg.Connection[Any]") -> None:
        self.url = url
        self._connection = connection

    def close(self) -> None:
        """Never raises."""
        with suppress(Exception):
            self._connection.close()

    def digests(self) -> Digests:
        rows = self._read(
            f"SELECT substr(id, 1, {BUCKET}), count(*), md5(string_agg({_DIGEST}, '' ORDER BY id)) "  # noqa: S608
            f"FROM {TABLE} GROUP BY substr(id, 1, {BUCKET})"
        )
        return {str(bucket): (int(count), str(digest)) for bucket, count, digest in rows}

    def rows(self, buckets: Sequence[str]) -> Mapping[str, StoredRow]:
        """Ids are cut at one more character than an id has."""
        places = ", ".join(["%s"] * len(buckets))
        query = (
            f"SELECT {_CUT_ID}, {_DIGEST}, length(payload) FROM {TABLE} "  # noqa: S608
            f"WHERE substr(id, 1, {BUCKET}) IN ({places})"
        )
        return {str(id_): StoredRow(str(digest), int(length)) for id_, digest, length in self._read(query, buckets)}

    def read(self, ids: Sequence[str]) -> Sequence[FactRow]:
        """Values longer than those of any fact are cut, so that their id does not match."""
        places = ", ".join(["%s"] * len(ids))
        shown = ", ".join(_FETCHED.get(name, f"substr({name}, 1, {_MAX_VALUE_LENGTH})") for name in FACT_COLUMNS)
        # An id that is too long has no place in the index.
        where = "id" if all(len(id_) < _CUT for id_ in ids) else _CUT_ID
        return self._read(f"SELECT {shown} FROM {TABLE} WHERE {where} IN ({places})", ids)  # noqa: S608

    def add(self, facts: Sequence[Fact]) -> int:
        if not facts:
            return 0
        places = ", ".join(["(%s, %s, %s, %s, %s, %s)"] * len(facts))
        values = [value for fact in facts for value in fact.row]
        statement = f"INSERT INTO {TABLE} ({_COLUMNS}) VALUES {places} ON CONFLICT DO NOTHING"  # noqa: S608
        with _troubles(self.url):
            return max(0, self._connection.execute(statement, values).rowcount)

    def _read(self, query: str, values: Sequence[object] = ()) -> list[tuple[Any, ...]]:
        with _troubles(self.url):
            rows = self._connection.execute(query, values).fetchall()
        return [tuple(value.decode("utf-8", "replace") if isinstance(value, bytes) else value for value in row)
                for row in rows]  # fmt: skip


def open_server(text: str) -> PostgresFacts:
    """Raises `UserError`."""
    url = server_url(text)
    connection = _connect(url)
    try:
        with _troubles(url):
            connection.execute(f"SET statement_timeout = '{STATEMENT_LIMIT_S}s'")
            if connection.info.parameter_status("server_encoding") == _NO_ENCODING:
                # Else the server refuses every query that meets a row which is no text, and one row stops all stations.
                connection.execute(f"SET client_encoding = '{_NO_ENCODING}'")
            _find_table(connection)
    except BaseException:
        connection.close()
        raise
    return PostgresFacts(url, connection)


def _connect(url: ServerUrl) -> "psycopg.Connection[Any]":
    try:
        import psycopg
    except ImportError as error:
        text = marked("psycopg is not installed: {command}")
        raise UserError(text, command=INSTALL) from error
    given: dict[str, Any] = {**_GIVEN, **dict(url.secrets)}
    for name, _value in url.options:
        given.pop(name, None)  # the address says otherwise
    if url.password:
        given["password"] = url.password
    with _roots(url) as roots:
        given |= roots
        try:
            return psycopg.connect(url.shown, autocommit=True, **given)
        except psycopg.Error as error:
            password = None if "password" in given else _password_of_keyring(url, error)
            if password is None:
                raise _trouble(url, error) from None
            url = url._replace(password=password)
            with _troubles(url):
                return psycopg.connect(url.shown, autocommit=True, **given | {"password": password})


@contextmanager
def _roots(url: ServerUrl) -> Iterator[dict[str, str]]:
    """Replaces `sslrootcert=system` by the file of this system. Implies `verify-full`, as libpq requires."""
    options = dict(url.options)
    is_system = options.get("sslrootcert") == "system" and options.get("sslmode", _VERIFIED) == _VERIFIED
    if not is_system or {"SSL_CERT_FILE", "SSL_CERT_DIR"} & os.environ.keys():
        yield {}
        return
    with system_roots() as file:
        yield {} if file is None else {"sslrootcert": str(file), "sslmode": _VERIFIED}


@contextmanager
def system_roots() -> Iterator[Path | None]:
    """The system's trusted root certificates as a file, because psycopg's bundled OpenSSL does not find them; None if
    there are none. On Windows a temporary file is written and deleted at the end."""
    roots = next((file for file in ROOT_FILES if file.is_file()), None)
    trusted = [] if roots is not None else ssl.create_default_context().get_ca_certs(binary_form=True)
    if not trusted:
        yield roots
        return
    with TemporaryDirectory(prefix="dps-s-") as folder:
        written = Path(folder, "roots.pem")
        written.write_text("".join(map(ssl.DER_cert_to_PEM_cert, trusted)), encoding="ascii")
        yield written


def _password_of_keyring(url: ServerUrl, error: Exception) -> str | None:
    """Used if the server requires a password and libpq has none; None without a keyring or an entry in it."""
    if not any(sign in str(error) for sign in _NO_PASSWORD):
        return None
    try:
        password = import_module("keyring").get_password(KEYRING_SERVICE, f"{url.user}@{url.place}")
    except Exception as trouble:  # noqa: BLE001  a keyring may be locked, absent or broken in ways of its own
        _log.info("The keyring gives no password: %s", type(trouble).__name__)
        return None
    return password if isinstance(password, str) and password else None


def _find_table(connection: "psycopg.Connection[Any]") -> None:
    """Creates the table if it is missing and the role is permitted to."""
    import psycopg

    try:
        connection.execute(f"SELECT id FROM {TABLE} LIMIT 1")  # noqa: S608
    except psycopg.Error as error:
        if error.sqlstate != _NO_TABLE:
            raise
        connection.execute(CREATE_TABLE)


@contextmanager
def _troubles(url: ServerUrl) -> Iterator[None]:
    import psycopg

    try:
        yield
    except (psycopg.Error, UnicodeError) as error:
        raise _trouble(url, error) from None


def _trouble(url: ServerUrl, error: Exception) -> UserError:
    reasons = dict.fromkeys(filter(None, _BETWEEN.split(url.scrubbed(str(error)))))
    why = UserMessage("; ".join(reasons) or type(error).__name__)
    for sign, text in _PLAIN.items():
        if any(sign in reason for reason in reasons):
            why = message(text)
    return UserError(message(marked("The archive server {server} cannot be used: {why}"), server=url.shown, why=why))
