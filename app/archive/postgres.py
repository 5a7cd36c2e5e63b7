"""Facts on a PostgreSQL server: one table, to which rows are only ever added.

psycopg is loaded here, when a server is used, and nowhere else. The password comes from libpq's own places
(PGPASSFILE, a service file), from the keyring, or from the address.
"""

import logging
import os
import re
import ssl
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from importlib import import_module
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any, Final

from app.archive.places import BUCKET, Buckets
from app.archive.server_url import ServerUrl, server_url
from app.store.kinds import MAX_CONTENT_BYTES
from app.store.rows import COLUMNS, Row
from app.text.messages import UserMessage, message
from app.text.user_error import ErrorCode, UserError
from protocol.translatable import marked

if TYPE_CHECKING:
    import psycopg

_log = logging.getLogger(__name__)

INSTALL: Final = 'pip install "dps-s-configurator[archive]"'
KEYRING_SERVICE: Final = "dps-s archive"
STATEMENT_LIMIT_S: Final = 120
CREATE_TABLE: Final = f"""
    CREATE TABLE IF NOT EXISTS dps_s_facts (
        id      text COLLATE "C" PRIMARY KEY CHECK (id ~ '^[0-9a-f]{{40}}$'),
        kind    text NOT NULL CHECK (length(kind) <= 40),
        module  text CHECK (length(module) <= 400),
        station text NOT NULL CHECK (length(station) = 64),
        made_at text NOT NULL CHECK (length(made_at) <= 40),
        content text NOT NULL CHECK (octet_length(content) <= {MAX_CONTENT_BYTES})
    )
"""
FOR_ADMINISTRATOR: Final = f"""{CREATE_TABLE.strip()};
REVOKE ALL ON dps_s_facts FROM PUBLIC;
GRANT SELECT, INSERT ON dps_s_facts TO dps_s_station;"""
_GIVEN: Final = {
    "connect_timeout": "10",
    "client_encoding": "UTF8",
    "keepalives_idle": "10",
    "keepalives_interval": "5",
    "keepalives_count": "3",
    "tcp_user_timeout": "20000",
}
"""A lost server is noticed within 30 s."""
ROOT_FILES: Final = (
    Path("/etc/ssl/certs/ca-certificates.crt"),  # Debian, Ubuntu, Arch
    Path("/etc/pki/tls/certs/ca-bundle.crt"),  # Fedora
    Path("/etc/ssl/ca-bundle.pem"),  # openSUSE
    Path("/etc/ssl/cert.pem"),  # macOS
)
_BINARY_ARRAY: Final = "%" + "b::text[]"  # a placeholder of psycopg's, and no date
_NO_TABLE: Final = "42P01"
_NO_RIGHT: Final = "42501"
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


class ServerTrouble(UserError):
    """The server cannot be reached or used."""

    code = ErrorCode.NO_LINK


class PostgresPlace:
    """Made by `open_server`. Used by one thread. Every method raises `UserError`."""

    def __init__(self, url: ServerUrl, connection: "psycopg.Connection[Any]") -> None:
        self.name = url.shown
        self._url = url
        self._connection = connection

    def close(self) -> None:
        """Never raises."""
        with suppress(Exception):
            self._connection.close()

    def buckets(self) -> Buckets:
        query = (
            f"SELECT left(id, {BUCKET}), count(*), md5(string_agg(id, '' ORDER BY id)) "  # noqa: S608
            "FROM dps_s_facts GROUP BY 1"
        )
        with _troubles(self._url):
            return {bucket: (count, digest) for bucket, count, digest in self._connection.execute(query)}

    def lengths(self, bucket: str) -> dict[str, int]:
        # octet_length, unlike length, does not unpack what is stored compressed.
        query = "SELECT id, octet_length(content) FROM dps_s_facts WHERE id >= %s AND id < %s"
        with _troubles(self._url):
            return dict(self._connection.execute(query, (bucket, f"{bucket}g")).fetchall())

    def rows(self, ids: list[str]) -> list[tuple[Any, ...]]:
        query = f"SELECT {COLUMNS} FROM dps_s_facts WHERE id = ANY(%s)"  # noqa: S608
        with _troubles(self._url):
            return self._connection.execute(query, (ids,)).fetchall()

    def add(self, rows: list[Row]) -> int:
        """One statement for a page, with sorted ids, so that two stations never wait for each other in a circle. The
        columns go as binary arrays: as text they take psycopg seven times as long."""
        if not rows:
            return 0
        columns = [list(column) for column in zip(*sorted(rows, key=lambda row: row.id), strict=True)]
        statement = (
            f"INSERT INTO dps_s_facts ({COLUMNS}) "  # noqa: S608
            f"SELECT * FROM unnest({', '.join([_BINARY_ARRAY] * len(columns))}) "
            "ON CONFLICT DO NOTHING"
        )
        with _troubles(self._url):
            return self._connection.execute(statement, columns).rowcount


def open_server(text: str) -> PostgresPlace:
    """Makes the table where it is missing and the role may. Raises `UserError`."""
    url = server_url(text)
    connection = _connect(url)
    try:
        if connection.info.parameter_status("server_encoding") != "UTF8":
            raise ServerTrouble(marked("The database of the archive has to be made with the encoding UTF8."))
        with _troubles(url):
            connection.execute(f"SET statement_timeout = '{STATEMENT_LIMIT_S}s'")
            _find_table(connection)
    except BaseException:
        connection.close()
        raise
    return PostgresPlace(url, connection)


def _connect(url: ServerUrl) -> "psycopg.Connection[Any]":
    try:
        import psycopg
    except ImportError as error:
        text = marked("psycopg is not installed: {command}")
        raise ServerTrouble(text, command=INSTALL) from error
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
    import psycopg

    try:
        connection.execute("SELECT id FROM dps_s_facts LIMIT 1")
    except psycopg.Error as error:
        if error.sqlstate != _NO_TABLE:
            raise
    else:
        return
    try:
        connection.execute(CREATE_TABLE)
    except psycopg.Error as error:
        if error.sqlstate != _NO_RIGHT:
            raise
        text = marked("This role may not make the table of the archive. As the server's administrator, once:\n{sql}")
        raise ServerTrouble(text, sql=FOR_ADMINISTRATOR) from error


@contextmanager
def _troubles(url: ServerUrl) -> Iterator[None]:
    import psycopg

    try:
        yield
    except (psycopg.Error, UnicodeError) as error:
        raise _trouble(url, error) from None


def _trouble(url: ServerUrl, error: Exception) -> ServerTrouble:
    reasons = dict.fromkeys(filter(None, _BETWEEN.split(url.scrubbed(str(error)))))
    why = UserMessage("; ".join(reasons) or type(error).__name__)
    for sign, text in _PLAIN.items():
        if any(sign in reason for reason in reasons):
            why = message(text)
    return ServerTrouble(
        message(marked("The archive server {server} cannot be used: {why}"), server=url.shown, why=why)
    )
