"""What a module got and sent. The judge of every test against it."""

import json
from typing import NamedTuple, TextIO

from tests.module.wire import SET

GOT = "got"
SENT = "sent"
NOT_A_FRAME = "not a frame"


class Entry(NamedTuple):
    """One frame, or a run of bytes that was none."""

    at_s: float
    """Since the module was made."""
    kind: str
    frame: bytes
    note: str = ""
    """What was done with it, where not the usual."""
    module: str = ""

    @property
    def code(self) -> int:
        return self.frame[2] if len(self.frame) > 2 else -1

    @property
    def is_set(self) -> bool:
        return self.kind == GOT and self.frame[3] == SET

    @property
    def value(self) -> int:
        return self.frame[4]

    def as_json(self) -> str:
        return json.dumps({**self._asdict(), "at_s": round(self.at_s, 4), "frame": self.frame.hex(" ")})


def entry_of(line: str) -> Entry:
    """Read what `as_json` wrote."""
    parts = json.loads(line)
    return Entry(**{**parts, "frame": bytes.fromhex(parts["frame"])})


class Log(list[Entry]):
    """All entries, in the order in which they happened; each is also written to `copy`, a line each."""

    def __init__(self, copy: TextIO | None = None) -> None:
        super().__init__()
        self._copy = copy

    def add(self, entry: Entry) -> None:
        self.append(entry)
        if self._copy is not None:
            self._copy.write(entry.as_json() + "\n")
            self._copy.flush()

    def got(self, code: int | None = None) -> list[Entry]:
        """Return what the host sent; only that of `code` if it is given."""
        return [one for one in self if one.kind == GOT and code in (None, one.code)]

    def sent(self, code: int | None = None) -> list[Entry]:
        return [one for one in self if one.kind == SENT and code in (None, one.code)]

    def sets(self, code: int | None = None) -> list[Entry]:
        return [one for one in self.got(code) if one.is_set]

    def acts(self) -> list[Entry]:
        """Return the frames that can hurt: activation, deploy, shut down, baud rate and zeroing."""
        return [one for one in self.got() if (one.is_set and one.code in (0x10, 0x11, 0x12, 0x24)) or one.code == 0x25]
