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


@pytest.mark.parametrize(("file", "name"), sorted(set(_NAMED.findall(PAGE))))
def test_each_test_that_is_named_exists(file: str, name: str) -> None:
    assert name in functions(next(TESTS.rglob(file)))


@pytest.mark.parametrize("letter", "abcdefghijkl")
def test_each_requirement_is_held_by_tests(letter: str) -> None:
    part = PAGE.split(f"\n## {letter}. ")[1].split("\n## ")[0]
    assert len(_NAMED.findall(part)) >= 3


def test_a_test_that_is_gone_is_noticed() -> None:
    assert "test_that_never_was" not in functions(next(TESTS.rglob("test_act.py")))
