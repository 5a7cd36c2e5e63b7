"""Results of guided tests in the store; they are only added, never changed. Every method raises `StoreTrouble`."""

import json
from collections.abc import Mapping

from app.guided.kept_test import StoredTest
from app.guided.results import GuidedKind, GuidedResult, GuidedVerdict
from app.store.database import Database
from app.text.messages import clean


class GuidedStore:
    """Uses the file of the store; the table is in `schema`."""

    def __init__(self, database: Database) -> None:
        self._database = database

    def add(
        self,
        result: GuidedResult,
        *,
        module_id: int | None,
        adapter: str,
        who: str,
        is_simulated: bool,
        program: str,
    ) -> int:
        """Durable on return. A result without a module is kept but counts for none."""
        measured = json.dumps([one.plain() for one in result.measured], ensure_ascii=False, sort_keys=True)
        return self._database.write(
            "INSERT INTO guided_tests (module_id, adapter, at, who, kind, verdict, is_simulated, program, measured) "
            "VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?)",
            (
                module_id, clean(adapter), self._database.now(), clean(who), result.kind.value, result.verdict.value,
                is_simulated, program, measured,
            ),
        )  # fmt: skip

    def last(self, module_id: int | None, *, counts_simulated: bool) -> Mapping[GuidedKind, StoredTest]:
        """The newest result of each test of a module. `counts_simulated`: include those of simulated modules."""
        if module_id is None:
            return {}
        rows = self._database.read(
            "SELECT kind, verdict, at, who, is_simulated, measured FROM guided_tests WHERE id IN "
            "(SELECT max(id) FROM guided_tests WHERE module_id = ? AND is_simulated <= ? GROUP BY kind)",
            (module_id, counts_simulated),
        )
        found = [kept for row in rows if (kept := _stored_test(*row)) is not None]
        return {one.kind: one for one in found}


def _stored_test(kind: str, verdict: str, at: str, who: str, is_simulated: int, measured: str) -> StoredTest | None:
    """None for a row that this version cannot read."""
    try:
        rows = json.loads(measured)
        return StoredTest(
            kind=GuidedKind(kind),
            verdict=GuidedVerdict(verdict),
            at=at,
            who=who,
            is_simulated=bool(is_simulated),
            measured=tuple(row for row in rows if isinstance(row, dict)) if isinstance(rows, list) else (),
        )
    except ValueError:
        return None
