"""The stored result of a guided test. Apart from the store, so that reading settings does not load it."""

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime

from app.guided.results import GuidedKind, GuidedVerdict

SECONDS_A_DAY = 86_400.0


@dataclass(frozen=True, slots=True, kw_only=True)
class StoredTest:
    """One result. `at`: ISO 8601 in UTC; `measured`: as `MeasuredValue.to_json` gives it."""

    kind: GuidedKind
    verdict: GuidedVerdict
    at: str
    who: str
    is_simulated: bool = False
    measured: tuple[Mapping[str, object], ...] = ()

    def age_days(self, now: datetime) -> float | None:
        """None if the time is invalid, or more than a day in the future."""
        try:
            at = datetime.fromisoformat(self.at)
        except ValueError:
            return None
        at = at if at.tzinfo is not None else at.replace(tzinfo=UTC)
        days = (now - at).total_seconds() / SECONDS_A_DAY
        return None if days < -1 else max(0.0, days)

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
