"""Results of guided tests: what was measured against which tolerance, and the verdict."""

from collections.abc import Mapping
from enum import Enum
from typing import Any, NamedTuple

from msgspec import Struct, ValidationError, convert, to_builtins

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
    # Measured too coarsely or not at all: counts as not tested.
    UNCLEAR = "unclear"


VERDICT_WORDS: Mapping[GuidedVerdict, str] = {
    GuidedVerdict.PASSED: marked("passed"),
    GuidedVerdict.FAILED: marked("FAILED"),
    GuidedVerdict.UNCLEAR: marked("unclear"),
}


def passed_if(is_fine: bool) -> GuidedVerdict:
    return GuidedVerdict.PASSED if is_fine else GuidedVerdict.FAILED


class MeasuredValue(NamedTuple):
    name: UserMessage
    shown: UserMessage
    tolerance: UserMessage
    verdict: GuidedVerdict


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


class StoredTest(Struct, frozen=True, kw_only=True, rename={"kind": "test"}):
    """A result that was kept. `at`: ISO 8601; `measured`: as the store keeps a `MeasuredValue`."""

    kind: GuidedKind
    verdict: GuidedVerdict
    at: str
    who: str = ""
    is_simulated: bool = False
    measured: list[dict[str, Any]] = []

    def plain(self) -> dict[str, Any]:
        plain: dict[str, Any] = to_builtins(self)
        return plain


def stored_test(plain: Mapping[str, object], at: str) -> StoredTest | None:
    """A result in a fact or a record, which is untrusted; None for one that this version does not know."""
    try:
        return convert({**plain, "at": at}, StoredTest)
    except ValidationError:
        return None
