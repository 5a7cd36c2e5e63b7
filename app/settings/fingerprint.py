"""A short checksum of a module's settings, to be read out over the radio.

It covers only the settings that can be read back: with the others (E8) the code of a module would depend on what was
written in this session. It has eight characters without 0, O, 1 and I: seven of a hash and a check character, which
detects any single wrong character and nearly all swapped neighbours.
"""

from collections.abc import Mapping

from app.settings.values import field_of
from protocol.catalogue import READABLE_SETTINGS
from protocol.fields import Value

ALPHABET = "23456789ABCDEFGHJKLMNPQRSTUVWXYZ"
HASHED_CHARACTERS = 7


def fingerprint(settings: Mapping[str, Value]) -> str | None:
    """Return the code of settings by key, such as "K7QF-3M2X"; None where one that it covers is not known."""
    import hashlib  # slow: loads OpenSSL

    if any(command.key not in settings for command in READABLE_SETTINGS):
        return None
    parts = [
        f"{command.code:02X}={field_of(command).encode(settings[command.key]):02X}" for command in READABLE_SETTINGS
    ]
    number = int.from_bytes(hashlib.sha256(";".join(parts).encode()).digest()[:8])
    body = ""
    for _ in range(HASHED_CHARACTERS):
        number, place = divmod(number, len(ALPHABET))
        body += ALPHABET[place]
    code = body + _check(body)
    return f"{code[:4]}-{code[4:]}"


def is_fingerprint(text: str) -> bool:
    """Return whether `text`, as heard or typed, is a complete code with the right check character."""
    plain = "".join(text.upper().split()).replace("-", "")
    if len(plain) != HASHED_CHARACTERS + 1 or not set(plain) <= set(ALPHABET):
        return False
    return _check(plain[:-1]) == plain[-1]


def _check(body: str) -> str:
    """Odd weights 1, 3, 5 … detect every single wrong character, since 32 has no odd divisor."""
    total = sum((2 * place + 1) * ALPHABET.index(letter) for place, letter in enumerate(body))
    return ALPHABET[total % len(ALPHABET)]
