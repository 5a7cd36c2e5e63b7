"""The mutation run: what it changes, what it leaves alone, and which tests it thinks fit."""

import ast

import pytest

from tests.mutants import FOLDERS, chosen, fitting_tests, mutant_at


@pytest.mark.parametrize(
    ("source", "changes"),
    [
        ("x = a < b", ["a < b  ->  a <= b"]),
        ("x = a is not b", ["a is not b  ->  a is b"]),
        ("x = a and b", ["a and b  ->  a or b"]),
        ("x = a + 2", ["a + 2  ->  a - 2", "2  ->  3"]),
        ("x = True", ["True  ->  False"]),
        ("if a:\n    b()\nelse:\n    c()", ["branches swapped: a", "dropped: b()", "dropped: c()"]),
        ("self.x += y", ["self.x += y  ->  self.x -= y", "dropped: self.x += y"]),
        ("def f(a: int = 1) -> int | None:\n    '''Text'''\n    return marked('1')", ["1  ->  2"]),
        ("isinstance(a, Long | Short)", ["dropped: isinstance(a, Long | Short)"]),
    ],
)
def test_each_place_is_changed_once(source: str, changes: list[str]) -> None:
    found: list[str] = []
    while True:
        try:
            one = mutant_at("x.py", source, len(found))
        except IndexError:
            break
        assert ast.dump(ast.parse(one.text)) != ast.dump(ast.parse(source))
        found.append(one.change)
    assert sorted(found) == sorted(changes)


def test_the_same_seed_chooses_the_same() -> None:
    assert chosen(1, 5, FOLDERS) == chosen(1, 5, FOLDERS) != chosen(2, 5, FOLDERS)


def test_the_tests_of_the_module_come_first_and_those_of_its_room_are_there() -> None:
    fitting = fitting_tests("protocol/stream.py")
    assert fitting[0] == "tests/protocol/test_stream.py"
    assert "tests/protocol/test_link.py" in fitting
