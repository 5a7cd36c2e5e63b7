"""Which modules of several stations may be one."""

from itertools import permutations
from typing import Any

from app.archive.module_names import ConflictKind, NamedModule, _names


def test_all_stations_ask_the_same_questions_in_the_same_order() -> None:
    """Whatever order the sets of records have in memory."""
    members = [NamedModule("a", "M-1"), NamedModule("b", "M-2"), NamedModule("c", "M-3")]

    def asked(order: Any) -> list[tuple[ConflictKind, Any]]:
        records: Any = {members[0]: order, members[1]: ("x",), members[2]: ("y",)}
        return [(one.kind, one.pair) for one in _names(members, {}, records).conflicts]

    questions = [asked(order) for order in permutations(("x", "y"))]
    assert len(questions[0]) == 2
    assert questions[0] == questions[1]
