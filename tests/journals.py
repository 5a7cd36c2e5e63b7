"""A journal in memory that remembers in which order things happened."""

from collections.abc import Mapping

from app.acts import Act
from app.journal import JournalFailed, Outcome


class FakeJournal:
    """`on_begin` runs while the intent is being written; `is_broken`: writing fails."""

    def __init__(self) -> None:
        self.intents: list[tuple[Act, bytes, Mapping[str, object]]] = []
        self.outcomes: dict[int, Outcome] = {}
        self.rates: list[tuple[int, int]] = []
        self.settled_rates: dict[int, str] = {}
        self.is_ready = True
        self.is_broken = False
        self.sent_before: list[int] = []
        self.line_length = lambda: 0
        self.on_begin = lambda: None

    def begin(self, act: Act, frame: bytes, detail: Mapping[str, object], /) -> int:
        if self.is_broken:
            raise JournalFailed("The disk is full.")
        self.intents.append((act, frame, detail))
        self.sent_before.append(self.line_length())
        self.on_begin()
        return len(self.intents) - 1

    def settle(self, entry: int, outcome: Outcome, result: Mapping[str, object], /) -> None:
        self.outcomes[entry] = outcome

    def begin_baud(self, old_rate: int, new_rate: int, /) -> int:
        if self.is_broken:
            raise JournalFailed("The disk is full.")
        self.rates.append((old_rate, new_rate))
        return len(self.rates) - 1

    def settle_baud(self, entry: int, outcome: str, /) -> None:
        self.settled_rates[entry] = outcome
