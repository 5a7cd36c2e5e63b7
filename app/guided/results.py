"""Results of guided tests: what was measured against which tolerance, the verdict, and what is kept of it.

They are only added to the store, never changed. A result without a module is kept but counts for none.
"""

from collections.abc import Mapping
from enum import Enum
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

from msgspec import Meta, Struct, ValidationError, convert, to_builtins

from app.store.rows import GuidedTestDone, Text, Word
from app.text.messages import UserMessage, clean
from protocol.translatable import marked

if TYPE_CHECKING:  # a profile names the tests, and opens no store
    from app.store.fact_store import Facts, Kept


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
    """A result that was kept, also in a record. `at`: ISO 8601; `measured`: as the store keeps a `MeasuredValue`."""

    kind: GuidedKind
    verdict: GuidedVerdict
    at: Word
    who: Text = ""
    is_simulated: bool = False
    measured: Annotated[list[dict[Word, Any]], Meta(max_length=20)] = []


# The store


def keep_test(facts: "Facts", result: GuidedResult, *, module: str | None, who: str, is_simulated: bool) -> None:
    """Keep the result of a guided test; only within `Store.write`."""
    measured = []
    for value in result.measured:
        texts = {"name": value.name, "shown": value.shown, "tolerance": value.tolerance}
        measured.append({key: text.to_json() for key, text in texts.items()} | {"verdict": value.verdict.value})
    test = GuidedTestDone(
        test=result.kind.value,
        verdict=result.verdict.value,
        who=clean(who),
        is_simulated=is_simulated,
        measured=measured,
    )
    facts.add(test, module)


def last_tests(facts: "Facts", module: str, *, counts_simulated: bool) -> Mapping[GuidedKind, StoredTest]:
    """The newest result of each test of a module. `counts_simulated`: include those of simulated modules."""
    last: dict[GuidedKind, StoredTest] = {}
    for kept in facts.back_from_newest(GuidedTestDone, module):
        test = read_test(kept)
        if test is not None and (counts_simulated or not test.is_simulated):
            last.setdefault(test.kind, test)
    return last


def read_test(kept: "Kept[GuidedTestDone]") -> StoredTest | None:
    """Return a test as it was kept; None for one that this version does not know."""
    try:
        return convert(to_builtins(kept.content) | {"at": kept.at}, StoredTest)
    except ValidationError:
        return None
