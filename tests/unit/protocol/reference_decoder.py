"""An independent decoder, written from the vendor's table without `protocol/`, to compare the product's with.

It finds the frames of a finished capture: at each position it tries every kind of frame, else it skips one byte. Its
only state is the last request.
"""

from typing import NamedTuple

ANY = set(range(256))
YES_OR_NO = {0, 1}
BAUD_CODES = {1, 2, 3, 4, 5, 6}
CELL_VOLTAGE, TRIGGER_RECORDS = 0x34, 0x35

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


class Found(NamedTuple):
    """A frame and its offset."""

    offset: int
    raw: bytes


def sum_is_right(raw: bytes) -> bool:
    return sum(raw[2:-1]) % 256 == raw[-1]


def is_request(raw: bytes) -> bool:
    is_one = len(raw) == 6 and raw[:2] == b"\x42\x61" and sum_is_right(raw)
    return is_one and raw[4] in REQUESTS.get((raw[2], raw[3]), set())


def frame_length(data: bytes, at: int, asked: int | None) -> int:
    """Return the length of the frame at `at`, or 0."""
    six, eight, sixteen = (data[at : at + length] for length in (6, 8, 16))
    if is_request(six) or six == b"\x41\x75\x01\xa5\x5a\x00":
        return 6
    if len(six) == 6 and six[:2] == b"\x41\x75" and six[3] == 1 and sum_is_right(six):
        if six[4] in REPLIES.get(six[2], set()):
            return 6
        # E3: the cell voltage comes as 35, like the beginning of a record.
        is_followed = data[at + 6 : at + 8] in (b"", b"\x41\x75", b"\x42\x61")
        if six[2] == 0x35 and (asked == CELL_VOLTAGE or (asked != TRIGGER_RECORDS and is_followed)):
            return 6
    if len(eight) == 8 and eight[:3] == b"\x41\x75\x32" and {eight[5], eight[6]} <= YES_OR_NO and sum_is_right(eight):
        return 8
    if len(sixteen) == 16 and sixteen[:4] == b"\x41\x75\x35\x01" and sum_is_right(sixteen):
        is_unused = set(sixteen[4:15]) in ({0x00}, {0xFF})
        return 16 if is_unused or {sixteen[11], sixteen[12]} <= YES_OR_NO else 0
    return 0


def frames(data: bytes, *, asked: int | None = None, follows_host: bool = False) -> list[Found]:
    """Return the frames of a finished capture; `asked` is the code of the last request before it."""
    found, at = [], 0
    while at < len(data):
        length = frame_length(data, at, asked)
        if length:
            raw = data[at : at + length]
            found.append(Found(at, raw))
            if follows_host and is_request(raw):
                asked = raw[2]
        at += length or 1
    return found
