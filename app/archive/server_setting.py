"""Stores the archive server's address in a file beside the store, without its password."""

from pathlib import Path
from typing import Final

from app.archive.fact_set import CANNOT_WRITE, file_troubles
from app.archive.server_url import MAX_URL_LENGTH, server_url
from app.system.files import write_whole
from app.text.user_error import UserError

SERVER_FILE: Final = "archive-server.txt"


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
