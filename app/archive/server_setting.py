"""Which server this station shares its records with, in a file beside the store; never with a password."""

from contextlib import suppress
from pathlib import Path
from typing import Final

from app.archive.fact_set import ArchiveTrouble
from app.archive.server_url import LONGEST_URL, server_url
from app.system.files import write_whole
from app.text.messages import said
from app.text.sentences import reason_of
from protocol.translatable import marked

SERVER_FILE: Final = "archive-server.txt"


def kept_server(folder: Path) -> str | None:
    """None where none is set, or where the file holds no address."""
    try:
        with (folder / SERVER_FILE).open(encoding="utf-8") as file:
            return server_url(file.read(LONGEST_URL)).shown
    except (OSError, ValueError, ArchiveTrouble):
        return None


def keep_server(folder: Path, text: str) -> str | None:
    """As it is kept: without its password; "" takes it away. Raises `ArchiveTrouble`."""
    path = folder / SERVER_FILE
    try:
        if not text.strip():
            with suppress(FileNotFoundError):
                path.unlink()
            return None
        shown = server_url(text).shown
        folder.mkdir(parents=True, exist_ok=True)
        write_whole(path, f"{shown}\n".encode())
    except OSError as error:
        why = reason_of(error)
        raise ArchiveTrouble(said(marked("{file} cannot be written: {why}."), file=path, why=why)) from error
    return shown
