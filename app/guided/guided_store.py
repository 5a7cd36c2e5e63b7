"""Results of guided tests in the store; they are only added, never changed. Raises `StoreTrouble`.

A result without a module is kept but counts for none.
"""

from collections.abc import Mapping

from app.guided.results import GuidedKind, GuidedResult, StoredTest, stored_test
from app.store.facts import FactKind, Facts
from app.text.messages import clean


def keep_test(
    facts: Facts, result: GuidedResult, *, module: str | None, adapter: str, who: str, is_simulated: bool, program: str
) -> int:
    """Durable on return."""
    content = {
        "adapter": clean(adapter), "who": clean(who), "test": result.kind.value, "verdict": result.verdict.value,
        "is_simulated": is_simulated, "program": program, "measured": [value.plain() for value in result.measured],
    }  # fmt: skip
    return facts.add(FactKind.GUIDED_TEST, content, module=module)


def last_tests(facts: Facts, module: str, *, counts_simulated: bool) -> Mapping[GuidedKind, StoredTest]:
    """The newest result of each test of a module. `counts_simulated`: include those of simulated modules."""
    kept = facts.select(FactKind.GUIDED_TEST, "AND module = ? ORDER BY number", (module,))
    # What a newer version measured in another form counts as not tested.
    tests = (stored_test(fact.content, fact.at) for fact in kept if isinstance(fact.content.get("measured"), list))
    return {test.kind: test for test in tests if test is not None and (counts_simulated or not test.is_simulated)}
