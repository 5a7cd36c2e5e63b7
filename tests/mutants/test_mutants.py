"""The mutation test: what it changes, which tests it runs, and what it concludes."""

import ast
import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import pytest

from tests.mutants import FOLDERS, ROOT, __main__, judging
from tests.mutants.changes import Mutant, chosen, mutant_at
from tests.mutants.executed import IMPORT, ROOM_BUDGET_S, TestMap
from tests.mutants.judging import Verdict


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


@pytest.mark.parametrize(
    ("change", "lines"),
    [
        ("1  ->  2", range(0)),
        ("a > 3  ->  a >= 3", range(3, 5)),
        ("dropped: b(4)", range(5, 7)),
        ("7  ->  8", range(8, 9)),
    ],
)
def test_the_lines_of_a_mutant_are_those_of_its_statement(change: str, lines: range) -> None:
    source = "X = 1\ndef f(a):\n    if (a\n        > 3):\n        b(\n            4)\n    else:\n        return 7\n"
    mutants = [mutant_at("x.py", source, number) for number in range(7)]
    assert next(one.lines for one in mutants if one.change == change) == lines


def test_only_tests_that_execute_the_line_run_those_of_the_room_and_the_fastest_first() -> None:
    tests = TestMap()
    tests.add("tests/ui/test_c.py::test_1", 0.1, {"protocol/x.py": [3]})
    tests.add("tests/protocol/test_b.py::test_1", 0.3, {"protocol/x.py": [2, 3]})
    tests.add("tests/protocol/test_a.py::test_2", 0.2, {"protocol/x.py": [3]})
    tests.add("tests/protocol/test_a.py::test_1", 0.5, {"protocol/x.py": [3]})
    tests.add("tests/protocol/test_a.py::test_3", ROOM_BUDGET_S, {"protocol/x.py": [3]})
    tests.add("tests/protocol/test_d.py::test_1", 0.1, {"protocol/y.py": [3]})
    room = ["tests/protocol/test_b.py::test_1", "tests/protocol/test_a.py::test_2", "tests/protocol/test_a.py::test_1"]
    assert tests.batches(Mutant("protocol/x.py", range(3, 4), 3, "", "")) == [room, ["tests/ui/test_c.py::test_1"]]
    assert tests.batches(Mutant("protocol/x.py", range(4, 5), 4, "", "")) == []
    tests.add(IMPORT, 0.0, {"protocol/x.py": [5]})
    for lines in (range(0), range(5, 6)):
        at_import = tests.batches(Mutant("protocol/x.py", lines, 1, "", ""))
        assert at_import[0][0] == "tests/protocol/test_d.py::test_1"  # may read a constant of the file


@pytest.mark.parametrize(("survivors", "score"), [([], "100.0"), ([1], "50.0")])
def test_an_interrupted_run_prints_the_score_of_what_was_judged(
    survivors: list[int], score: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    mutants = chosen(1, 4, FOLDERS)

    def judged(mutant: Mutant, _: list[list[str]]) -> Verdict:
        if mutants.index(mutant) == 2:
            raise KeyboardInterrupt
        return Verdict(mutant, 1, None if mutants.index(mutant) in survivors else "test", 0.0)

    monkeypatch.setattr(__main__, "pool", ThreadPoolExecutor)
    monkeypatch.setattr(__main__, "recorded_map", lambda *_: TestMap())
    monkeypatch.setattr(__main__, "judged", judged)
    assert __main__.main(["--seed", "1", "--count", "4", "--jobs", "1"]) == 1
    printed = capsys.readouterr().out
    assert f"2 of 4 mutants, seed 1: {score} % caught" in printed
    assert printed.splitlines()[0].startswith("  1/4 100 %  caught")


@pytest.mark.parametrize(
    ("failures", "caught_by"),
    [
        (["a", "a", None], "a"),
        (["a", None, None], None),  # a failure that does not repeat
        (["a", "a", "a", None], None),  # fails without the mutant, too
        (["import of a", "import of a"], "import of a"),
    ],
)
def test_only_a_failure_that_repeats_and_that_the_mutant_causes_counts(
    failures: list[str | None], caught_by: str | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    following = iter(failures)
    monkeypatch.setattr(judging, "_first_failure", lambda *_: next(following))
    assert judging.judged(chosen(1, 1, FOLDERS)[0], [["a", "b"]]).caught_by == caught_by
    assert not list(following)


JUDGE = """
from tests.mutants import ROOT
from tests.mutants.changes import Mutant
from tests.mutants.judging import judged

source = (ROOT / "protocol/frame.py").read_text(encoding="utf-8")
broken = Mutant("protocol/frame.py", range(0), 0, "", source.replace("sum(body) & 0xFF", "0"))
noticing = "tests/protocol/test_frame.py::test_a_request_with_a_wrong_sum_is_refused_with_the_reason"
other = "tests/protocol/test_frame.py::test_lengths_by_code"
assert judged(broken, [[other], [noticing]]).caught_by == noticing
assert judged(broken, [[other]]).caught_by is None
assert judged(broken._replace(text=source), [[noticing]]).caught_by is None
"""


if hasattr(os, "fork"):

    def test_a_mutant_is_caught_by_a_test_that_fails_on_it_only() -> None:
        ended = subprocess.run([sys.executable, "-c", JUDGE], cwd=ROOT, capture_output=True, text=True, check=False)
        assert ended.returncode == 0, ended.stderr
