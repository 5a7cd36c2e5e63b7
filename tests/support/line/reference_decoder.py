"""An independent decoder, written from the vendor's table without `protocol/`, to compare the product's with.

It finds the frames of a finished capture: at each position it tries every kind of frame, else it skips one byte. Its
only state is the last request.
"""

from typing import NamedTuple

ANY = set(range(256))
YES_OR_NO = {0, 1}
BAUD_CODES = {1, 2, 3, 4, 5, 6}

# code -> values of D4 in a six-byte reply (41 75 code 01 D4 sum)
REPLIES = {
    0x10: YES_OR_NO, 0x11: YES_OR_NO, 0x12: {1}, 0x13: YES_OR_NO, 0x14: ANY, 0x15: ANY,
    0x16: YES_OR_NO, 0x17: YES_OR_NO,
    0x20: ANY, 0x21: ANY, 0x22: ANY, 0x23: ANY, 0x24: BAUD_CODES, 0x25: {1},
    0x30: ANY, 0x31: ANY, 0x33: YES_OR_NO, 0x34: ANY,
}  # fmt: skip

# (code, control) -> values of D4 in a host frame
REQUESTS = {
    (0x01, 0xA5): {0x5A},
    (0x10, 2): YES_OR_NO, (0x11, 2): YES_OR_NO, (0x12, 2): {1}, (0x13, 2): YES_OR_NO,
    (0x14, 1): {1}, (0x15, 2): ANY, (0x15, 1): {0}, (0x16, 2): YES_OR_NO, (0x17, 2): YES_OR_NO,
    (0x20, 2): ANY, (0x20, 1): {0}, (0x21, 2): ANY, (0x21, 1): {0}, (0x22, 2): ANY, (0x22, 1): {0},
    (0x23, 1): {0}, (0x24, 2): BAUD_CODES, (0x25, 1): {0},
    (0x30, 1): {0}, (0x31, 1): {0}, (0x32, 1): {0}, (0x33, 1): {0}, (0x34, 1): {0}, (0x35, 1): {0},
}  # fmt: skip

CELL_VOLTAGE, TRIGGER_RECORDS = 0x34, 0x35


class Found(NamedTuple):
    """A frame and its offset."""

    offset: int
    raw: bytes


def sum_is_right(raw: bytes) -> bool:
    total = 0
    for byte in raw[2:-1]:
        total += byte
    return total % 256 == raw[-1]


def is_request(raw: bytes) -> bool:
    return (
        len(raw) == 6
        and raw[:2] == b"\x42\x61"
        and raw[4] in REQUESTS.get((raw[2], raw[3]), set())
        and sum_is_right(raw)
    )


def is_heartbeat(raw: bytes) -> bool:
    return raw == b"\x41\x75\x01\xa5\x5a\x00"


def is_reply(raw: bytes) -> bool:
    return (
        len(raw) == 6
        and raw[:2] == b"\x41\x75"
        and raw[3] == 1
        and raw[4] in REPLIES.get(raw[2], set())
        and sum_is_right(raw)
    )


def is_voltage_as_35(raw: bytes) -> bool:
    return len(raw) == 6 and raw[:4] == b"\x41\x75\x35\x01" and sum_is_right(raw)


def is_status(raw: bytes) -> bool:
    return (
        len(raw) == 8
        and raw[:3] == b"\x41\x75\x32"
        and raw[5] in YES_OR_NO
        and raw[6] in YES_OR_NO
        and sum_is_right(raw)
    )


def is_record(raw: bytes) -> bool:
    if len(raw) != 16 or raw[:4] != b"\x41\x75\x35\x01" or not sum_is_right(raw):
        return False
    is_unused = set(raw[4:15]) in ({0x00}, {0xFF})
    return is_unused or (raw[11] in YES_OR_NO and raw[12] in YES_OR_NO)


def frame_length(data: bytes, at: int, asked: int | None) -> int:
    """Return the length of the frame at `at`, or 0."""
    six = data[at : at + 6]
    if is_request(six) or is_heartbeat(six) or is_reply(six):
        return 6
    if is_status(data[at : at + 8]):
        return 8
    if is_voltage_as_35(six):
        if asked == CELL_VOLTAGE:
            return 6
        behind = data[at + 6 : at + 8]
        if asked != TRIGGER_RECORDS and behind in (b"", b"\x41\x75", b"\x42\x61"):
            return 6
    return 16 if is_record(data[at : at + 16]) else 0


def frames(data: bytes, *, asked: int | None = None, follows_host: bool = False) -> list[Found]:
    """Return the frames of a finished capture; `asked` is the code of the last request before it."""
    found = []
    at = 0
    while at < len(data):
        length = frame_length(data, at, asked)
        if length:
            raw = data[at : at + length]
            found.append(Found(at, raw))
            if follows_host and is_request(raw):
                asked = raw[2]
        at += length or 1
    return found
