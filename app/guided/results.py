"""Results of guided tests: what was measured against which tolerance, and the verdict."""

from collections.abc import Mapping
from enum import Enum
from typing import NamedTuple

from app.text.messages import UserMessage
from protocol.translatable import marked


class GuidedKind(Enum):
    """The value is its name in the store, in records and in profiles."""

    TILT = "tilt"
    FREE_FALL = "free_fall"
    BAY = "bay"
    LINK = "link"


TITLES: Mapping[GuidedKind, str] = {
    GuidedKind.TILT: marked("Attitude trigger"),
    GuidedKind.FREE_FALL: marked("Free fall"),
    GuidedKind.BAY: marked("Parachute bay"),
    GuidedKind.LINK: marked("Plug and cable"),
}


class GuidedVerdict(Enum):
    """The value is its name in the store and in records."""

    PASSED = "passed"
    FAILED = "failed"
    UNCLEAR = "unclear"
    """Measured too coarsely or not at all: counts as not tested."""


VERDICT_WORDS: Mapping[GuidedVerdict, str] = {
    GuidedVerdict.PASSED: marked("passed"),
    GuidedVerdict.FAILED: marked("FAILED"),
    GuidedVerdict.UNCLEAR: marked("unclear"),
}


class MeasuredValue(NamedTuple):
    """`value`: for programs, in the unit of `shown`; None if unknown."""

    name: UserMessage
    shown: UserMessage
    tolerance: UserMessage
    verdict: GuidedVerdict
    value: float | None = None

    def plain(self) -> dict[str, object]:
        """For the store and for records."""
        return {
            "name": self.name.to_json(),
            "shown": self.shown.to_json(),
            "tolerance": self.tolerance.to_json(),
            "verdict": self.verdict.value,
            "value": self.value,
        }


class GuidedResult(NamedTuple):
    """A test that was completed. `advice`: what to do."""

    kind: GuidedKind
    measured: tuple[MeasuredValue, ...]
    advice: UserMessage | None = None

    @property
    def verdict(self) -> GuidedVerdict:
        verdicts = {value.verdict for value in self.measured}
        if GuidedVerdict.FAILED in verdicts:
            return GuidedVerdict.FAILED
        return GuidedVerdict.PASSED if verdicts == {GuidedVerdict.PASSED} else GuidedVerdict.UNCLEAR


class StoredTest(NamedTuple):
    """A result that was kept. `at`: ISO 8601; `measured`: as `MeasuredValue.plain` gives it."""

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
            "measured": [dict(row) for row in self.measured],
        }


def stored_test(plain: Mapping[str, object], at: str) -> StoredTest | None:
    """A result in a fact or a record, which is untrusted; None for a test that this version does not know. A verdict
    that it does not know is unclear."""
    kind = next((kind for kind in GuidedKind if kind.value == plain.get("test")), None)
    verdict = next(
        (verdict for verdict in GuidedVerdict if verdict.value == plain.get("verdict")), GuidedVerdict.UNCLEAR
    )
    if kind is None:
        return None
    measured = plain.get("measured")
    rows = tuple(row for row in measured if isinstance(row, Mapping)) if isinstance(measured, list) else ()
    return StoredTest(kind=kind, verdict=verdict, at=at, who=str(plain.get("who") or ""),
                      is_simulated=plain.get("is_simulated") is True, measured=rows)  # fmt: skip


def passed_if(is_fine: bool) -> GuidedVerdict:
    return GuidedVerdict.PASSED if is_fine else GuidedVerdict.FAILED
