"""`promises.txt` names the tests that hold each promise of docs/safety.md, under the words it begins with."""

import ast
import re
from pathlib import Path

import pytest

TESTS = Path(__file__).parents[2]
PAGE = " ".join((TESTS.parent / "docs" / "safety.md").read_text(encoding="utf-8").split())
HELD = {
    promise: re.findall(r"(test_\w+\.py)::(test_\w+)", tests)
    for promise, _, tests in (
        part.partition("\n")
        for part in (Path(__file__).parent / "promises.txt").read_text(encoding="utf-8").split("\n\n")
    )
}


def functions(file: str) -> set[str]:
    tree = ast.parse(next(TESTS.rglob(file)).read_text(encoding="utf-8"))
    return {node.name for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)}


def test_each_promise_stands_on_the_page() -> None:
    assert [promise for promise in HELD if promise not in PAGE] == []


def test_each_test_that_is_named_exists() -> None:
    named = {held for tests in HELD.values() for held in tests}
    assert named - {(file, name) for file in {file for file, _ in named} for name in functions(file)} == set()


@pytest.mark.parametrize("letter", "abcdefghijkl")
def test_each_requirement_is_held_by_tests(letter: str) -> None:
    part = PAGE.split(f" ## {letter}. ")[1].split(" ## ")[0]
    assert sum(len(tests) for promise, tests in HELD.items() if promise in part) >= 3


def test_a_test_that_is_gone_is_noticed() -> None:
    assert "test_that_never_was" not in functions("test_act.py")
