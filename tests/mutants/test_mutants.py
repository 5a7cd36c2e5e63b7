"""The mutation test: what it changes, which tests it runs, and what it concludes."""

import os
import subprocess
import sys
from collections.abc import Iterator

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
    before, found = compile(source, str(ROOT / "x.py"), "exec"), list[str]()
    while True:
        try:
            one = mutant_at("x.py", source, len(found))
        except IndexError:
            break
        assert one.code() != before
        found.append(one.change)
    assert sorted(found) == sorted(changes)


@pytest.mark.parametrize(
    ("source", "are_functions"),
    [
        ("X = 1", False),
        ("def f(a=1):\n    pass", False),
        ("class C:\n    def f(self):\n        return 1", True),
        ("def f():\n    return lambda: 1", True),
        ("class C:\n    def f(self):\n        super().f()", False),  # without the call, it holds no class
    ],
)
def test_what_importing_a_file_executes_is_not_changed_in_its_functions(source: str, are_functions: bool) -> None:
    assert mutant_at("x.py", source, 0).changes_functions_only() is are_functions


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
    mutant = Mutant("protocol/x.py", "", 0, range(3, 4), 3, "")
    room = ["tests/protocol/test_b.py::test_1", "tests/protocol/test_a.py::test_2", "tests/protocol/test_a.py::test_1"]
    assert tests.batches(mutant) == [room, ["tests/ui/test_c.py::test_1"]]
    assert tests.batches(mutant._replace(lines=range(4, 5))) == []
    tests.add(IMPORT, 0.0, {"protocol/x.py": [5]})
    for lines in (range(0), range(5, 6)):
        at_import = tests.batches(mutant._replace(lines=lines))
        assert at_import[0][0] == "tests/protocol/test_d.py::test_1"  # may read a constant of the file


def test_every_test_has_its_turn_before_a_second_case_of_another() -> None:
    tests, mutant = TestMap(), chosen(1, 1, FOLDERS)[0]._replace(path="protocol/x.py", lines=range(1, 2))
    for case in range(200):
        tests.add(f"tests/protocol/test_a.py::test_1[{case}]", 0.2, {"protocol/x.py": [1]})
    tests.add("tests/protocol/test_a.py::test_2", 9.0, {"protocol/x.py": [1]})
    (batch,) = tests.batches(mutant)
    assert "tests/protocol/test_a.py::test_2" in batch
    assert len(batch) == 1 + (20 - 9) * 5


@pytest.mark.parametrize(("survivors", "score"), [([], "100.0"), ([1], "50.0")])
def test_an_interrupted_run_prints_the_score_of_what_was_judged(
    survivors: list[int], score: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    mutants = chosen(1, 4, FOLDERS)

    def judged(*_: object) -> Iterator[Verdict]:
        for number, mutant in enumerate(mutants[:2]):
            yield Verdict(mutant, 1, None if number in survivors else "test", 0.0)
        raise KeyboardInterrupt

    monkeypatch.setattr(__main__, "preload", lambda: None)
    monkeypatch.setattr(__main__, "recorded_map", lambda *_: TestMap())
    monkeypatch.setattr(__main__, "verdicts", judged)
    assert __main__.main(["--seed", "1", "--count", "4", "--jobs", "1"]) == 1
    printed = capsys.readouterr().out
    assert f"2 of 4 mutants, seed 1: {score} % caught" in printed
    assert printed.splitlines()[0].startswith("   1/4 100 %  caught")


@pytest.mark.parametrize(
    ("failures", "caught_by"),
    [
        (["a", "a", None], "a"),
        (["a", None, None], None),  # a failure that does not repeat
        (["a", "a", "a", None], None),  # fails without the mutant, too
        (["import of a", "import of a", None], "import of a"),
    ],
)
def test_only_a_failure_that_repeats_and_that_the_mutant_causes_counts(
    failures: list[str | None], caught_by: str | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    following = iter(failures)
    monkeypatch.setattr(judging, "_first_failure", lambda *_: next(following))
    assert judging.judged(judging.run_imported, chosen(1, 1, FOLDERS)[0], [["a", "b"]]).caught_by == caught_by
    assert not list(following)


JUDGE = """
from tests.mutants import ROOT
from tests.mutants.changes import mutant_at
from tests.mutants.executed import IMPORT, TestMap
from tests.mutants.judging import judged, run_imported, verdicts

source = (ROOT / "protocol/frame.py").read_text(encoding="utf-8")
mutants = [mutant_at("protocol/frame.py", source, number) for number in range(30)]
in_function = next(one for one in mutants if one.change == "sum(body) & 255  ->  sum(body) | 255")
at_import = next(one for one in mutants if not one.lines)
while_imported = next(one for one in mutants if one.change == "dropped: forms[command.code] = by_control")
noticing = "tests/protocol/test_frame.py::test_exactly_the_requests_of_the_table_pass"
other = "tests/protocol/test_frame.py::test_lengths_by_code"
executed = TestMap()
executed.add(other, 0.1, {"protocol/frame.py": [*in_function.lines, *while_imported.lines]})
assert [one.caught_by for one in verdicts(2, ["tests/protocol"], executed, [in_function])] == [None]
executed.add(noticing, 0.1, {"protocol/frame.py": list(in_function.lines)})
executed.add(IMPORT, 0.1, {"protocol/frame.py": list(while_imported.lines)})
found = list(verdicts(2, ["tests/protocol"], executed, [at_import, while_imported, in_function]))
assert found[0].mutant == in_function and found[0].caught_by == noticing
assert {one.mutant: one.caught_by for one in found[1:]} == {at_import: None, while_imported: noticing}
assert judged(run_imported, in_function, [[other], [noticing]]).caught_by == noticing
"""


if hasattr(os, "fork"):

    def test_a_mutant_is_caught_by_a_test_that_fails_on_it_only() -> None:
        ended = subprocess.run([sys.executable, "-c", JUDGE], cwd=ROOT, capture_output=True, text=True, check=False)
        assert ended.returncode == 0, ended.stderr
