"""This station's key pair (Ed25519), which signs pre-flight records and names the station in facts.

The private key is a file beside the store that only this user can read. A keyring is not used: on Linux it may be
locked, missing or ask for a password during a check, and the file is as safe as the records that it signs.
"""

import base64
import binascii
import hashlib
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Final

from app.system.files import write_whole
from app.text.messages import UserError, UserMessage, error_text, message
from protocol.translatable import marked

if TYPE_CHECKING:
    from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey

KEY_FILE: Final = "station.key"
_KEY_BYTES: Final = 32
_LARGEST_FILE: Final = 4096


@dataclass(frozen=True, slots=True)
class Station:
    """Made by `own_station`."""

    public: bytes
    _private: "Ed25519PrivateKey"

    def sign(self, data: bytes) -> bytes:
        signature: bytes = self._private.sign(data)
        return signature


def fingerprint_of(public: bytes) -> str:
    """80 bits of the key's SHA-256 for comparison by people: "3F9A-11C0-…"."""
    digits = hashlib.sha256(public).hexdigest().upper()
    return "-".join(digits[place : place + 4] for place in range(0, 20, 4))


def is_signature(public: bytes, signature: bytes, data: bytes) -> bool:
    """Whether the owner of this key signed these bytes."""
    from cryptography.exceptions import InvalidSignature
    from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PublicKey

    try:
        Ed25519PublicKey.from_public_bytes(public).verify(signature, data)
    except (InvalidSignature, ValueError):
        return False
    return True


def own_station(folder: Path) -> Station:
    """The station of this data folder; creates its key if it is missing. An unreadable key file is never replaced.
    Raises `UserError`."""
    path = folder / KEY_FILE
    try:
        if not path.exists():
            folder.mkdir(parents=True, exist_ok=True)
            _make(path)
        return _station(path)
    except (OSError, ImportError) as error:
        raise _unusable(error_text(error)) from error


def _unusable(why: str | UserMessage) -> UserError:
    return UserError(marked("The key of this station cannot be used: {why}."), why=why)


def _station(path: Path) -> Station:
    from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey

    with suppress(OSError):
        path.chmod(0o600)
    with path.open("rb") as file:
        text = file.read(_LARGEST_FILE).strip()
    try:
        seed = base64.b64decode(text, validate=True)
    except binascii.Error:
        seed = b""
    if len(seed) != _KEY_BYTES:
        raise _unusable(message(marked("{file} is damaged"), file=path))
    private = Ed25519PrivateKey.from_private_bytes(seed)
    return Station(private.public_key().public_bytes_raw(), private)


def _make(path: Path) -> None:
    from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey

    seed = base64.b64encode(Ed25519PrivateKey.generate().private_bytes_raw())
    write_whole(path, seed + b"\n", is_private=True)
