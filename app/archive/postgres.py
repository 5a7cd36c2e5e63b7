"""Facts on a PostgreSQL server: one table, to which rows are only ever added; and the server's address.

postgresql://USER@HOST:PORT/DATABASE?sslrootcert=system

Only this form without a password is shown, logged and stored. The password comes from libpq's own places (PGPASSFILE, a
service file), or from the address. psycopg is loaded when a server is used.
"""

import os
import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, NamedTuple
from urllib.parse import parse_qsl, unquote

from app.archive.file_place import BUCKET, Buckets
from app.store.rows import COLUMNS, Row
from app.text.messages import clean
from app.text.user_error import ErrorCode, UserError
from protocol.translatable import marked

if TYPE_CHECKING:
    import psycopg

INSTALL: Final = 'pip install "dps-s-configurator[archive]"'
MAX_URL_LENGTH: Final = 2000
_URL: Final = re.compile(
    r"(?i)postgres(?:ql)?://(?:(?P<user>[^@/?#:]*)(?::(?P<password>[^@/?#]*))?@)?(?P<place>[^@?#]*)(?P<query>\?[^@#]*)?"
)
_SECRET: Final = re.compile("password|secret|scram", re.IGNORECASE)
# A lost server is noticed within 30 s.
_PATIENCE: Final = {
    "connect_timeout": "10",
    "keepalives_idle": "10",
    "keepalives_interval": "5",
    "keepalives_count": "3",
    "tcp_user_timeout": "20000",
    "options": "-c statement_timeout=120s",
}
# What an administrator does once; the first statement makes the table.
SQL_FILE: Final = Path(__file__).with_name("server.sql")
# One statement for a page. The columns go as binary arrays: as text they take psycopg seven times as long.
_ADD: Final = f"""
    INSERT INTO dps_s_facts ({COLUMNS})
    SELECT * FROM unnest(%b::text[], %b::text[], %b::text[], %b::text[], %b::text[], %b::text[])
    ON CONFLICT DO NOTHING
"""  # noqa: S608
ROOT_FILES: Final = (
    Path("/etc/ssl/certs/ca-certificates.crt"),  # Debian, Ubuntu, Arch
    Path("/etc/pki/tls/certs/ca-bundle.crt"),  # Fedora
    Path("/etc/ssl/ca-bundle.pem"),  # openSUSE
    Path("/etc/ssl/cert.pem"),  # macOS
)


class ServerUrl(NamedTuple):
    """`shown`: the address without the password, which is for this connection only."""

    shown: str
    password: str
    options: dict[str, str]


def is_server(address: str) -> bool:
    return address.strip().lower().startswith(("postgresql://", "postgres://"))


def server_url(text: str) -> ServerUrl:
    """Raises `UserError`, whose message contains nothing of `text`, because it may contain a password. One that stands
    anywhere but between user and host is refused."""
    match = _URL.fullmatch(text.strip()) if len(text) <= MAX_URL_LENGTH else None
    query = "" if match is None else match["query"] or ""
    options = dict(parse_qsl(query.removeprefix("?").replace("+", "%2B")))  # libpq does not decode + as a space
    if match is None or any(_SECRET.search(name) for name in options):
        sentence = marked("Write {example}; in a password %2F %40 %3F %23 for / @ ? #.")
        raise UserError(sentence, example="postgresql://USER@HOST/DATABASE")
    user = f"{match['user']}@" if match["user"] else ""
    return ServerUrl(f"postgresql://{user}{match['place']}{query}", unquote(match["password"] or ""), options)


class ServerTrouble(UserError):
    """The server cannot be reached or used."""

    code = ErrorCode.NO_LINK


class PostgresPlace:
    """Used by one thread. Every method raises `UserError`."""

    def __init__(self, address: str) -> None:
        """Makes the table where it is missing and the role may."""
        self._url = server_url(address)
        self.name = self._url.shown
        try:
            import psycopg
        except ImportError as error:
            raise ServerTrouble(marked("psycopg is not installed: {command}"), command=INSTALL) from error
        # For sslrootcert=system: the OpenSSL that psycopg brings looks for the trusted certificates where none are.
        roots = [str(file) for file in ROOT_FILES if file.is_file()]
        if roots:
            os.environ.setdefault("SSL_CERT_FILE", roots[0])
        options: dict[str, Any] = _PATIENCE | self._url.options
        if self._url.password:
            options["password"] = self._url.password
        with self._troubles():
            self._connection = psycopg.connect(self.name, autocommit=True, client_encoding="UTF8", **options)
            try:
                _prepare(self._connection)
            except BaseException:
                self.close()
                raise

    def close(self) -> None:
        self._connection.close()

    def buckets(self) -> Buckets:
        digest = "md5(string_agg(id, '' ORDER BY id))"
        query = f"SELECT left(id, {BUCKET}), count(*), {digest} FROM dps_s_facts GROUP BY 1"  # noqa: S608
        with self._troubles():
            return {bucket: (count, found) for bucket, count, found in self._connection.execute(query)}

    def lengths(self, bucket: str) -> dict[str, int]:
        # octet_length, unlike length, does not unpack what is stored compressed.
        query = "SELECT id, octet_length(content) FROM dps_s_facts WHERE id >= %s AND id < %s"
        with self._troubles():
            return dict(self._connection.execute(query, (bucket, f"{bucket}g")).fetchall())

    def rows(self, ids: list[str]) -> list[tuple[Any, ...]]:
        query = f"SELECT {COLUMNS} FROM dps_s_facts WHERE id = ANY(%s)"  # noqa: S608
        with self._troubles():
            return self._connection.execute(query, (ids,)).fetchall()

    def add(self, rows: list[Row]) -> int:
        """In the order of the ids, so that two stations never wait for each other in a circle."""
        columns = [list(column) for column in zip(*rows, strict=True)]
        with self._troubles():
            return self._connection.execute(_ADD, columns).rowcount

    @contextmanager
    def _troubles(self) -> Iterator[None]:
        import psycopg

        try:
            yield
        except (psycopg.Error, UnicodeError) as error:
            # The reason is at the end of the first line. Behind it is advice, such as to do without TLS, or a row.
            why = str(error).partition("\n")[0].rpartition(" failed: ")[2]
            if self._url.password:
                why = why.replace(self._url.password, "…")
            text = marked("The archive server {server} cannot be used: {why}")
            raise ServerTrouble(text, server=self.name, why=clean(why, longest=300)) from None


def _prepare(connection: "psycopg.Connection[Any]") -> None:
    from psycopg.errors import InsufficientPrivilege

    if connection.info.parameter_status("server_encoding") != "UTF8":
        raise ServerTrouble(marked("The database of the archive has to be made with the encoding UTF8."))
    if connection.execute("SELECT to_regclass('dps_s_facts')").fetchone() != (None,):
        return
    sql = SQL_FILE.read_text(encoding="utf-8")
    try:
        connection.execute(sql.partition(";")[0])
    except InsufficientPrivilege as error:
        text = marked("This role may not make the table of the archive. As the server's administrator, once:\n{sql}")
        raise ServerTrouble(text, sql=sql) from error
