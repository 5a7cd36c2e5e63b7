"""What a module got and sent. The judge of every test against it."""

from typing import NamedTuple

GOT, SENT, NOT_A_FRAME = "got", "sent", "not a frame"


class Entry(NamedTuple):
    """One frame, or a run of bytes that was none. `note`: what was done with it, where not the usual."""

    at_s: float
    kind: str
    frame: bytes
    note: str = ""
    module: str = ""

    @property
    def code(self) -> int:
        return self.frame[2]

    @property
    def value(self) -> int:
        return self.frame[4]

    @property
    def is_set(self) -> bool:
        return self.kind == GOT and self.frame[3] == 0x02


class Log(list[Entry]):
    """All entries, in the order in which they happened."""

    def add(self, entry: Entry) -> None:
        self.append(entry)

    def got(self, code: int | None = None) -> list[Entry]:
        """Return the frames of the host; only those of `code` if it is given."""
        return [one for one in self if one.kind == GOT and code in (None, one.code)]

    def sent(self, code: int | None = None) -> list[Entry]:
        return [one for one in self if one.kind == SENT and code in (None, one.code)]

    def sets(self, code: int | None = None) -> list[Entry]:
        return [one for one in self.got(code) if one.is_set]

    def acts(self) -> list[Entry]:
        """Return the frames that can hurt: activation, deploy, shut down, baud rate and zeroing."""
        return [one for one in self.got() if one.code == 0x25 or (one.is_set and one.code in (0x10, 0x11, 0x12, 0x24))]
