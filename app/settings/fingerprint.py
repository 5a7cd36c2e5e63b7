"""Short checksum of a module's settings, to be read out over the radio.

It covers the settings that can be read back, and nothing else: what can never be read (E8) would make the code of one
and the same module depend on what was done in this session. What it does not cover is named.

Eight characters without 0, O, 1 and I: seven of a hash, the last one a check that finds any one wrong character
and nearly all neighbours that were swapped.
"""

from collections.abc import Mapping
from dataclasses import dataclass

from app.engine.device import DeviceView
from protocol.catalogue import SETTINGS, Command
from protocol.fields import Value

ALPHABET = "23456789ABCDEFGHJKLMNPQRSTUVWXYZ"
HASHED_CHARACTERS = 7
COVERED: tuple[Command, ...] = tuple(command for command in SETTINGS if command.reads_back)


@dataclass(frozen=True, slots=True)
class Fingerprint:
    """`code` as spoken, "K7QF-3M2X"; None where nothing is known. `missing`: covered settings that are not known."""

    code: str | None
    missing: tuple[Command, ...] = ()

    @property
    def is_complete(self) -> bool:
        return self.code is not None and not self.missing


def fingerprint(settings: Mapping[str, Value]) -> Fingerprint:
    """Of settings by key. Those that are missing are left out, which gives another code than any complete one."""
    import hashlib  # loads OpenSSL

    known = [command for command in COVERED if command.key in settings]
    missing = tuple(command for command in COVERED if command.key not in settings)
    if not known:
        return Fingerprint(None, missing)
    parts = [f"{command.code:02X}={_raw(command, settings[command.key]):02X}" for command in known]
    number = int.from_bytes(hashlib.sha256(";".join(parts).encode()).digest()[:8])
    characters = []
    for _ in range(HASHED_CHARACTERS):
        number, place = divmod(number, len(ALPHABET))
        characters.append(ALPHABET[place])
    body = "".join(characters)
    code = body + _check(body)
    return Fingerprint(f"{code[:4]}-{code[4:]}", missing)


def fingerprint_of(device: DeviceView, now: float) -> Fingerprint:
    """Of what is known about the module at `now` and in no doubt."""
    known = {command.key: device.fresh(command.key, now) for command in COVERED}
    return fingerprint({key: value for key, value in known.items() if value is not None})


def is_fingerprint(text: str) -> bool:
    """Whether `text`, as heard or typed, is a whole code with the right check character."""
    plain = "".join(text.upper().split()).replace("-", "")
    if len(plain) != HASHED_CHARACTERS + 1 or any(one not in ALPHABET for one in plain):
        return False
    return _check(plain[:-1]) == plain[-1]


def _raw(command: Command, value: Value) -> int:
    if command.write is None:
        raise LookupError(f"{command.name} cannot be set")
    return command.write.encode(value)


def _check(body: str) -> str:
    """Weights 1, 3, 5 …: odd, so that every single error shows (32 has no odd divisor)."""
    total = sum((2 * place + 1) * ALPHABET.index(one) for place, one in enumerate(body))
    return ALPHABET[total % len(ALPHABET)]
