"""The stored result of a guided test. Apart from the store, so that reading settings does not load it."""

from collections.abc import Mapping
from dataclasses import dataclass

from app.guided.results import GuidedKind, GuidedVerdict


@dataclass(frozen=True, slots=True, kw_only=True)
class StoredTest:
    """One result. `at`: ISO 8601 in UTC; `measured`: as `MeasuredValue.to_json` gives it."""

    kind: GuidedKind
    verdict: GuidedVerdict
    at: str
    who: str
    is_simulated: bool = False
    measured: tuple[Mapping[str, object], ...] = ()

    def plain(self) -> dict[str, object]:
        """For a record."""
        return {
            "test": self.kind.value,
            "verdict": self.verdict.value,
            "at": self.at,
            "who": self.who,
            "is_simulated": self.is_simulated,
            "measured": [dict(one) for one in self.measured],
        }
