"""Results of guided tests in the store; they are only added, never changed. Every method raises `StoreTrouble`."""

from collections.abc import Mapping

from app.guided.kept_test import StoredTest
from app.guided.results import GuidedKind, GuidedResult, GuidedVerdict
from app.store.database import Database
from app.store.facts import FactKind, Facts, Kept
from app.text.messages import clean


class GuidedStore:
    """`module`: its name. A result without a module is kept but counts for none."""

    def __init__(self, database: Database) -> None:
        self._facts = Facts(database)

    def add(
        self, result: GuidedResult, *, module: str | None, adapter: str, who: str, is_simulated: bool, program: str
    ) -> int:
        """Durable on return."""
        content = {
            "adapter": clean(adapter), "who": clean(who), "test": result.kind.value, "verdict": result.verdict.value,
            "is_simulated": is_simulated, "program": program, "measured": [one.plain() for one in result.measured],
        }  # fmt: skip
        return self._facts.add(FactKind.GUIDED_TEST, content, module=module)

    def last(self, module: str | None, *, counts_simulated: bool) -> Mapping[GuidedKind, StoredTest]:
        """The newest result of each test of a module. `counts_simulated`: include those of simulated modules."""
        facts = self._facts.select(FactKind.GUIDED_TEST, "AND module = ? ORDER BY number", (module,))
        newest = {str(fact.content.get("test")): fact for fact in facts
                  if counts_simulated or not fact.content.get("is_simulated")}  # fmt: skip
        tests = map(_stored_test, newest.values())
        return {test.kind: test for test in tests if test is not None}


def _stored_test(fact: Kept) -> StoredTest | None:
    """None for a result that this version cannot read."""
    content = fact.content
    try:
        return StoredTest(
            kind=GuidedKind(content["test"]), verdict=GuidedVerdict(content["verdict"]), at=fact.at,
            who=content["who"], is_simulated=content["is_simulated"],
            measured=tuple(row for row in content["measured"] if isinstance(row, dict)),
        )  # fmt: skip
    except (ValueError, KeyError, TypeError):
        return None
