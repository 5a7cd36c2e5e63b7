"""docs/safety.md names tests; they exist, and none of the twelve requirements is without one."""

import ast
import re
from pathlib import Path

import pytest

TESTS = Path(__file__).parents[2]
PAGE = (TESTS.parent / "docs" / "safety.md").read_text(encoding="utf-8")
_NAMED = re.compile(r"`(test_\w+\.py)::(test_\w+)`")


def functions(path: Path) -> set[str]:
    tree = ast.parse(path.read_text(encoding="utf-8"))
    return {node.name for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)}


def test_each_test_that_is_named_exists() -> None:
    named = set(_NAMED.findall(PAGE))
    found = {(file, name) for file in {file for file, _ in named} for name in functions(next(TESTS.rglob(file)))}
    assert named - found == set()


@pytest.mark.parametrize("letter", "abcdefghijkl")
def test_each_requirement_is_held_by_tests(letter: str) -> None:
    part = PAGE.split(f"\n## {letter}. ")[1].split("\n## ")[0]
    assert len(_NAMED.findall(part)) >= 3


def test_a_test_that_is_gone_is_noticed() -> None:
    assert "test_that_never_was" not in functions(next(TESTS.rglob("test_act.py")))
