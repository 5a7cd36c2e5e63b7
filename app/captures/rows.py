"""Random access to the rows of a capture, in bounded memory."""

from array import array
from collections.abc import Hashable, Iterable, Sequence
from copy import copy
from typing import Any, overload

import numpy as np
from numpy.typing import NDArray

from app.captures.entries import Way
from app.captures.explain import Asked
from app.captures.explained import Explained
from protocol.catalogue import Layout
from protocol.frame import Direction, Fault, Frame, Noise

Places = NDArray[np.intp]
_OUT, _NOISE, _FROM_HOST, _STATUS = 1, 2, 4, 8


class CaptureRows(Sequence[Explained]):
    """All rows of a capture, created on access, or some; in 25 bytes each plus their bytes. Not thread-safe."""

    def __init__(self, rows: Iterable[Explained] = ()) -> None:
        self._at_s = array("d")
        self._flags = bytearray()
        self._ends = array("Q")
        self._offsets = array("Q")
        self._notes = array("L")
        """Places in `_known` of what a row has beside its bytes."""
        self._raw = bytearray()
        self._known: list[Fault | Asked] = []
        self._places: dict[object, int] = {}
        self._last_note: tuple[object, int] = object(), 0
        self._last: tuple[int, Explained] | None = None
        self._chosen: Sequence[int] | None = None
        """Of those that are chosen, in the capture; None: all."""
        for row in rows:
            self.append(row)

    def append(self, row: Explained) -> Explained:
        piece = row.piece
        flags = _OUT if row.way is Way.OUT else 0
        if isinstance(piece, Noise):
            flags |= _NOISE
            note: Fault | Asked = piece.fault
        else:
            from_host = piece.direction is Direction.HOST_TO_MODULE
            flags |= (_FROM_HOST if from_host else 0) | (_STATUS if len(piece.raw) == Layout.STATUS.value else 0)
            note = row.asked
        self._at_s.append(row.at_s)
        self._flags.append(flags)
        self._raw += piece.raw
        self._ends.append(len(self._raw))
        self._offsets.append(piece.offset)
        self._notes.append(self._last_note[1] if self._last_note[0] is note else self._note_place(note))
        return row

    def chosen(self, places: Places) -> "CaptureRows":
        """Some of the rows; both share what they hold."""
        rows = copy(self)
        rows._chosen = places.data
        return rows

    def _note_place(self, note: Fault | Asked) -> int:
        """Place in `_known`, where it is added if it is new."""
        key = (note.text, *note.values.values()) if isinstance(note, Fault) else note
        place = self._places.get(key)
        if place is None:
            place = self._places[key] = len(self._known)
            self._known.append(note)
        self._last_note = note, place
        return place

    def __len__(self) -> int:
        return len(self._flags if self._chosen is None else self._chosen)

    @overload
    def __getitem__(self, row: int) -> Explained: ...
    @overload
    def __getitem__(self, row: slice) -> tuple[Explained, ...]: ...
    def __getitem__(self, row: int | slice) -> Explained | tuple[Explained, ...]:
        rows = range(len(self))[row]
        return (
            self._at(self._place(rows)) if isinstance(rows, int) else tuple(self._at(self._place(row)) for row in rows)
        )

    def _place(self, row: int) -> int:
        return row if self._chosen is None else self._chosen[row]

    def at_s(self, row: int) -> float:
        """Time of a row, in seconds since the capture began."""
        return self._at_s[self._place(row)]

    def same_text_key(self, row: int) -> Hashable:
        """Equal for rows of the same content at any time. Much faster than comparing rows."""
        place = self._place(row)
        begins = self._ends[place - 1] if place else 0
        flags = self._flags[place]
        note = 0 if flags & _STATUS else self._notes[place]  # the meaning of a status does not depend on the request
        return flags, note, bytes(self._raw[begins : self._ends[place]])

    def _at(self, place: int) -> Explained:
        last = self._last
        if last is not None and last[0] == place:  # views read a row once for each cell and role
            return last[1]
        flags, note = self._flags[place], self._known[self._notes[place]]
        begins = self._ends[place - 1] if place else 0
        raw, offset = bytes(self._raw[begins : self._ends[place]]), self._offsets[place]
        way = Way.OUT if flags & _OUT else Way.IN
        if isinstance(note, Fault):
            row = Explained(self._at_s[place], way, Noise(raw, note, offset), None)
        else:
            direction = Direction.HOST_TO_MODULE if flags & _FROM_HOST else Direction.MODULE_TO_HOST
            row = Explained(self._at_s[place], way, Frame(direction, raw, offset), note)
        self._last = place, row
        return row

    def rejected(self) -> Places:
        """Places of the rows that are no frames."""
        return np.flatnonzero(self._as_array() & _NOISE)

    def without_status(self) -> Places:
        """Places of the rows that are no status, which a stream mostly consists of."""
        return np.flatnonzero((self._as_array() & _STATUS) == 0)

    def _as_array(self) -> NDArray[Any]:
        return np.frombuffer(self._flags, dtype=np.uint8)
