"""Splits a capture into unasked frames and replies to requests, read slightly ahead of playback."""

from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Final

from app.captures.entries import CaptureEntry, Way
from app.captures.explained import Explained, Explainer
from protocol.catalogue import Layout, Request
from protocol.frame import Direction, Frame, decode_request
from protocol.messages import answers

MAX_ANSWER_S: Final = 3.0
"""A frame later than this after the question no longer counts as its answer; records get ten seconds more."""
MAX_RECORDS_S: Final = 13.0


@dataclass(slots=True)
class Answer:
    """One answer of the module; `data` is empty if it did not answer."""

    request: Request
    asked_at_s: float
    after_s: float = 0.0
    data: bytes = b""

    @property
    def is_multi_frame(self) -> bool:
        """Whether it consists of several frames: trigger records."""
        return self.request.command.layout is Layout.RECORD

    def accept(self, one: Explained) -> bool:
        """Add a frame if it belongs to this answer; whether it does."""
        limit_s = MAX_RECORDS_S if self.is_multi_frame else MAX_ANSWER_S
        is_free = self.is_multi_frame or not self.data
        if not (is_free and one.at_s - self.asked_at_s <= limit_s and answers(one.piece.raw, self.request)):
            return False
        if not self.data:
            self.after_s = max(0.0, one.at_s - self.asked_at_s)
        self.data += one.piece.raw
        return True


class Script:
    """The part of a capture that is still to be played, as far as it has been read.

    One thread reads; any may ask for the duration.
    """

    def __init__(self, steps: Iterator[Sequence[CaptureEntry]], expected_s: Callable[[], float]) -> None:
        """`steps`: the capture's entries, in steps of some milliseconds of work. `expected_s`: the expected duration
        until all of it has been read."""
        self.unasked: deque[tuple[float, bytes]] = deque()
        """Times and bytes that the module sent without a request."""
        self.answers: dict[Request, deque[Answer]] = {}
        """By request, in order of time; the last one may not have its data yet."""
        self.alive_at_s: deque[float] = deque()
        """Times of the module's frames."""
        self.read_s = 0.0
        """Time up to which everything has been read."""
        self.is_read = False
        """Everything has been read."""
        self._steps = steps
        self._expected_s = expected_s
        self._explainer = Explainer()
        self._question: Answer | None = None

    @property
    def duration_s(self) -> float:
        """Approximate until all of it has been read."""
        return self.read_s if self.is_read else max(self.read_s, self._expected_s())

    def read_on(self) -> None:
        """Read one step. Raises what `steps` raises."""
        if self.is_read:
            return
        entries = next(self._steps, None)
        if entries is None:
            self._sort(self._explainer.end())
            self.is_read = True
            return
        for entry in entries:
            self._sort(self._explainer.feed(entry))
            self.read_s = entry.at_s

    def discard_before(self, position_s: float, alive_for_s: float) -> None:
        """Discard what is not needed any more at `position_s`."""
        while self.alive_at_s and self.alive_at_s[0] < position_s - alive_for_s:
            self.alive_at_s.popleft()
        for given in self.answers.values():
            while len(given) > 1 and given[1].asked_at_s <= position_s:
                given.popleft()

    def _sort(self, rows: Iterable[Explained]) -> None:
        for one in rows:
            frame = one.piece if isinstance(one.piece, Frame) else None
            if one.way is Way.OUT:
                if frame is not None and frame.direction is Direction.HOST_TO_MODULE:
                    self._ask(decode_request(frame.raw), one.at_s)
                continue
            is_modules = frame is not None and frame.direction is Direction.MODULE_TO_HOST
            if is_modules:
                self.alive_at_s.append(one.at_s)
            if not (is_modules and self._question is not None and self._question.accept(one)):
                self.unasked.append((one.at_s, one.piece.raw))

    def _ask(self, request: Request, at_s: float) -> None:
        self._question = Answer(request, at_s)
        self.answers.setdefault(request, deque()).append(self._question)
