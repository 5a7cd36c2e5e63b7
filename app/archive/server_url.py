"""The address of an archive server; only the form without its password is shown, logged, or stored beside the store.

postgresql://USER@HOST:PORT/DATABASE?sslrootcert=system
"""

import re
from pathlib import Path
from typing import Final, NamedTuple
from urllib.parse import quote, unquote, urlencode

from app.system.files import CANNOT_WRITE, file_troubles, write_whole
from app.text.messages import clean
from app.text.user_error import UserError
from protocol.translatable import marked

SCHEMES: Final = ("postgresql", "postgres")
MAX_URL_LENGTH: Final = 2000
SERVER_FILE: Final = "archive-server.txt"
_SECRETS: Final = ("password", "sslpassword", "oauth_client_secret", "scram_client_key", "scram_server_key")
_URL: Final = re.compile(r"(?P<scheme>\w+)://(?:(?P<user>[^@/?#]*)@)?(?P<place>[^@?#]*)(?:\?(?P<query>[^@#]*))?")


class ServerUrl(NamedTuple):
    """`shown`: the address without password. `password`: as given, for this connection only."""

    shown: str
    user: str
    place: str
    """Host, port and database."""
    password: str
    options: tuple[tuple[str, str], ...]
    """Options that contain no secret."""
    secrets: tuple[tuple[str, str], ...]

    def scrubbed(self, text: str) -> str:
        """A library's message without the passwords."""
        for secret in (self.password, *(value for _, value in self.secrets)):
            if secret:
                text = text.replace(secret, "…").replace(quote(secret, safe=""), "…")
        return clean(" ".join(text.split()), longest=300)


def server_url(text: str) -> ServerUrl:
    """Raises `UserError`, whose message contains nothing of `text`, because it may contain a password."""
    match = _URL.fullmatch(text.strip()) if len(text) <= MAX_URL_LENGTH else None
    if match is None or match["scheme"].lower() not in SCHEMES:
        example = "postgresql://USER@HOST/DATABASE"
        text = marked("Write {example}; in a password %2F %40 %3F %23 for / @ ? #.")
        raise UserError(text, example=example)
    user, _, password = (match["user"] or "").partition(":")
    parts = (part.partition("=") for part in (match["query"] or "").split("&") if part)
    given = [(unquote(name), unquote(value)) for name, _, value in parts]  # libpq does not decode + as a space
    secrets = tuple((name, value) for name, value in given if name.lower() in _SECRETS)
    options = tuple((name, value) for name, value in given if name.lower() not in _SECRETS)
    shown = f"postgresql://{user + '@' if user else ''}{match['place']}"
    shown += f"?{urlencode(options, quote_via=quote)}" if options else ""
    return ServerUrl(shown, unquote(user), match["place"], unquote(password), options, secrets)


def stored_server(folder: Path) -> str | None:
    """None if none is set or the file has no valid address."""
    try:
        with (folder / SERVER_FILE).open(encoding="utf-8") as file:
            return server_url(file.read(MAX_URL_LENGTH)).shown
    except (OSError, ValueError, UserError):
        return None


def store_server(folder: Path, text: str) -> str | None:
    """Return the address as stored, without its password; "" removes it. Raises `UserError`."""
    path = folder / SERVER_FILE
    with file_troubles(CANNOT_WRITE, path):
        if not text.strip():
            path.unlink(missing_ok=True)
            return None
        shown = server_url(text).shown
        folder.mkdir(parents=True, exist_ok=True)
        write_whole(path, f"{shown}\n".encode())
        return shown
