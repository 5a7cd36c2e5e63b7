"""Results of guided tests in the store; they are only added, never changed.

A result without a module is kept but counts for none.
"""

from collections.abc import Mapping

from msgspec import to_builtins

from app.guided.results import GuidedKind, GuidedResult, StoredTest, stored_test
from app.store.fact_store import Facts, Kept
from app.store.rows import GuidedTestDone
from app.text.messages import clean


def keep_test(facts: Facts, result: GuidedResult, *, module: str | None, who: str, is_simulated: bool) -> None:
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


def last_tests(facts: Facts, module: str, *, counts_simulated: bool) -> Mapping[GuidedKind, StoredTest]:
    """The newest result of each test of a module. `counts_simulated`: include those of simulated modules."""
    last: dict[GuidedKind, StoredTest] = {}
    for kept in facts.back_from_newest(GuidedTestDone, module):
        test = read_test(kept)
        if test is not None and (counts_simulated or not test.is_simulated):
            last.setdefault(test.kind, test)
        if len(last) == len(GuidedKind):
            break
    return last


def read_test(kept: Kept[GuidedTestDone]) -> StoredTest | None:
    """Return a test as it was kept; None for one that this version does not know."""
    return stored_test(to_builtins(kept.content), kept.at)
