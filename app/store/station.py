"""This station's key pair (Ed25519), which signs pre-flight records and names the station in facts.

The private key is a file beside the store that only this user can read. A keyring is not used: on Linux it may be
locked, missing or ask for a password during a check, and the file is as safe as the records that it signs.
"""

import base64
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Final, NamedTuple

from app.system.files import write_whole
from app.text.messages import UserError, error_text, message
from protocol.translatable import marked

if TYPE_CHECKING:  # imported on first use, to keep the start fast
    from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey

KEY_FILE: Final = "station.key"
_UNUSABLE: Final = marked("The key of this station cannot be used: {why}.")


class Station(NamedTuple):
    """A station, made by `own_station`. `key` is the public one, as hex."""

    key: str
    private: "Ed25519PrivateKey"


def own_station(folder: Path) -> Station:
    """The station of this data folder; creates its key if it is missing. An unreadable key file is never replaced.
    Raises `UserError`."""
    path = folder / KEY_FILE
    try:
        from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey

        if not path.exists():
            folder.mkdir(parents=True, exist_ok=True)
            made = base64.b64encode(Ed25519PrivateKey.generate().private_bytes_raw())
            write_whole(path, made + b"\n", is_private=True)
        with suppress(OSError):
            path.chmod(0o600)
        private = Ed25519PrivateKey.from_private_bytes(base64.b64decode(path.read_bytes().strip(), validate=True))
    except ValueError as error:  # no base64, or not 32 bytes
        raise UserError(_UNUSABLE, why=message(marked("{file} is damaged"), file=path)) from error
    except (OSError, ImportError) as error:
        raise UserError(_UNUSABLE, why=error_text(error)) from error
    return Station(private.public_key().public_bytes_raw().hex(), private)


def shown_key(key: str) -> str:
    """80 bits of a key's SHA-256 for comparison by people: "3F9A-11C0-…"."""
    import hashlib  # as in `fact_id`

    digits = hashlib.sha256(bytes.fromhex(key)).hexdigest().upper()
    return "-".join(digits[place : place + 4] for place in range(0, 20, 4))


def is_signature(key: str, signature: str, data: bytes) -> bool:
    """Whether the owner of this key signed these bytes."""
    from cryptography.exceptions import InvalidSignature
    from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PublicKey

    try:
        Ed25519PublicKey.from_public_bytes(bytes.fromhex(key)).verify(bytes.fromhex(signature), data)
    except (InvalidSignature, ValueError):
        return False
    return True
