"""Seal of a report page: SHA-256 of the file and of the record hash, signed by the station.

A comment behind the end of the file, which readers ignore.
"""

import hashlib
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from app.stations.station import KEY_BYTES, Station, decoded, encoded, is_signature

SIGNATURE_BYTES: Final = 64
_SEAL: Final = re.compile(
    rb"\n(?:%|<!-- )DPS-S page seal ([0-9a-f]{64})(?: ([A-Za-z0-9+/=]{44}) ([A-Za-z0-9+/=]{88}))?(?: -->)?\n\Z"
)


@dataclass(frozen=True, slots=True)
class PageSeal:
    """`page`: the file without its seal. `is_whole`: the digest matches. `signer`: key of a valid signature."""

    page: bytes
    is_whole: bool
    signer: bytes | None


def is_page(data: bytes) -> bool:
    """Whether this is a PDF or an HTML page, not a bare record."""
    return data.startswith(b"%PDF-") or data.lstrip()[:1] == b"<"


def sealed_pdf(data: bytes, record: Mapping[str, object], station: Station | None = None) -> bytes:
    return data + f"\n%{_words(data, record, station)}\n".encode()


def sealed_html(data: bytes, record: Mapping[str, object], station: Station | None = None) -> bytes:
    return data + f"\n<!-- {_words(data, record, station)} -->\n".encode()


def page_seal_in(data: bytes, record: Mapping[str, object]) -> PageSeal | None:
    """The seal of a page; None where it has none."""
    found = _SEAL.search(data)
    if found is None:
        return None
    page = data[: found.start()]
    is_whole = found[1].decode() == _digest(page, record)
    signer, signature = (decoded((found[number] or b"").decode(), length)
                         for number, length in ((2, KEY_BYTES), (3, SIGNATURE_BYTES)))  # fmt: skip
    if signer is None or signature is None or not is_whole:
        return PageSeal(page, is_whole, None)
    return PageSeal(page, is_whole, signer if is_signature(signer, signature, _signed(found[1].decode())) else None)


def _words(data: bytes, record: Mapping[str, object], station: Station | None) -> str:
    digest = _digest(data, record)
    if station is None:
        return f"DPS-S page seal {digest}"
    return f"DPS-S page seal {digest} {encoded(station.public)} {encoded(station.sign(_signed(digest)))}"


def _digest(data: bytes, record: Mapping[str, object]) -> str:
    return hashlib.sha256(data + str(record.get("hash")).encode("utf-8", "surrogatepass")).hexdigest()


def _signed(digest: str) -> bytes:
    return f"dps-s pre-flight page\n{digest}\n".encode()
