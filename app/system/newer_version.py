"""Is a newer version there? Looked up only at an address that a person gave: without one nothing is ever sent.

The address answers with the version in its first line, or as "version" or "tag_name" of a JSON object.
"""

import json
import re
import time
from typing import Final
from urllib.parse import urlsplit

from app.text.user_error import UserError
from protocol.translatable import marked

EXPECTED: Final = "https://, file://"
LIMIT_S: Final = 5.0
MAX_BYTES: Final = 64 * 1024
_LOCAL: Final = ("localhost", "127.0.0.1", "::1")
_VERSION: Final = re.compile(r"v?(\d{1,6}(?:\.\d{1,6}){0,3})([-.]?[a-z][a-z0-9.+-]{0,20})?", re.ASCII)


def is_usable(address: str) -> bool:
    """https, a file, or http on this computer."""
    try:
        parts = urlsplit(address)
        host = parts.hostname
    except ValueError:
        return False
    match parts.scheme:
        case "https":
            return bool(host)
        case "http":
            return host in _LOCAL
        case _:
            return parts.scheme == "file" and not parts.netloc and bool(parts.path)


def find_newer(address: str, own: str) -> str | None:
    """The version at `address` if it is newer than `own`. Returns within a few times `LIMIT_S`.

    Raises `UserError`, `OSError` or `ValueError` where none is found there.
    """
    newest = _version_in(_fetch(address))
    return newest if _rank(newest) > _rank(own) else None


def _fetch(address: str) -> bytes:
    from http.client import HTTPException  # takes longer to load than the whole protocol
    from urllib.request import HTTPRedirectHandler, Request, build_opener

    class UsableOnly(HTTPRedirectHandler):
        def redirect_request(self, req: Request, fp: object, code: int, msg: str, headers: object,
                             newurl: str) -> Request | None:  # fmt: skip
            _require_usable(newurl)
            return super().redirect_request(req, fp, code, msg, headers, newurl)  # type: ignore[arg-type]

    _require_usable(address)
    ends_at = time.monotonic() + LIMIT_S
    data = b""
    try:
        with build_opener(UsableOnly).open(address, timeout=LIMIT_S) as answer:
            while part := answer.read1(4096):
                data += part
                if len(data) > MAX_BYTES or time.monotonic() > ends_at:
                    raise ValueError(f"more than {MAX_BYTES} bytes or {LIMIT_S} s")
    except HTTPException as error:
        raise OSError(str(error)) from error
    return data


def _require_usable(address: str) -> None:
    if not is_usable(address):
        raise UserError(marked("Expected {expected}."), expected=EXPECTED)


def _version_in(data: bytes) -> str:
    """Raises `ValueError`."""
    text = data.decode("utf-8").strip()
    if text.startswith("{"):
        answer = json.loads(text)
        text = str(answer.get("version") or answer.get("tag_name") or "")
    match = _VERSION.fullmatch(text.partition("\n")[0].strip())
    if match is None:
        raise ValueError("no version")
    return match[0]


def _rank(version: str) -> tuple[tuple[int, ...], bool]:
    """1.2 is 1.2.0, and newer than 1.2rc1."""
    match = _VERSION.match(version)
    if match is None:
        return (), False
    numbers = [int(number) for number in match[1].split(".")]
    while numbers and not numbers[-1]:
        numbers.pop()
    return tuple(numbers), not match[2] or match[2].startswith(("+", ".post", "-post"))
