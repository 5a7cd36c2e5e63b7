"""The mutation test changes what it should, and notices what the tests notice."""

from functools import cache
from pathlib import Path

import pytest

from tests import mutants


@pytest.mark.parametrize(
    ("source", "changed"),
    [
        ("x = a < b", ["x = a <= b"]),
        ("x = a is not b", ["x = a is b"]),
        ("x = a and b", ["x = a or b"]),
        ("x = a + 2", ["x = a - 2", "x = a + 3"]),
        ("x = True", ["x = False"]),
        ("if a:\n    b()", ["if not a:\n    b()", "if a:\n    pass"]),
        ("self.x += y", ["self.x -= y", "pass"]),
        ("def f(a: int=1) -> int | None:\n    'Text'\n    return marked('1')", ["=2"]),
    ],
)
def test_each_place_is_changed_once(source: str, changed: list[str]) -> None:
    texts = [mutants.mutant_of(source, number)[2] for number in range(mutants.mutants_in(source))]
    assert len(texts) == len(changed)
    assert all(any(wanted in text for text in texts) for wanted in changed)


def test_a_mutant_counts_as_caught_where_a_test_of_its_room_fails(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "app/room").mkdir(parents=True)
    (tmp_path / "tests/app/room").mkdir(parents=True)
    (tmp_path / "app/room/sums.py").write_text(
        "def held():\n    return 1\n\n\ndef open():\n    return 1\n", encoding="utf-8"
    )
    test = "from app.room.sums import held\n\n\ndef test_held():\n    assert held() == 1\n"
    (tmp_path / "tests/app/room/test_sums.py").write_text(test, encoding="utf-8")
    monkeypatch.setattr(mutants, "ROOT", tmp_path)
    monkeypatch.setattr(mutants, "_is_caught", cache(mutants._is_caught))
    assert mutants.main(["app", "--jobs", "1", "--least", "50"]) == 0
    assert mutants.main(["app", "--jobs", "1", "--least", "51"]) == 1
    shown = capsys.readouterr().out
    assert "caught   app/room/sums.py:2: 1" in shown
    assert "SURVIVED app/room/sums.py:6: 1" in shown
