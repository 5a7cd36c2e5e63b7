"""What is tried under Wine is there: a name that is gone would be tried by nobody, and noticed by nobody."""

import ast
from collections.abc import Iterator
from types import ModuleType

import pytest

from tests.support.setup_files import PACKAGING, ROOT


@pytest.fixture(scope="module")
def suites() -> Iterator[ModuleType]:
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(PACKAGING))
        import windows.suites

        yield windows.suites


def test_every_suite_has_tests(suites: ModuleType) -> None:
    for suite in (*suites.SUITES, suites.QUICK):
        assert [name for name in suite.tests if not (ROOT / name).exists()] == []


def test_every_exception_is_a_test_and_has_a_reason(suites: ModuleType) -> None:
    for name, reason in suites.NOT_JUDGED.items():
        path, _, function = name.partition("::")
        tree = ast.parse((ROOT / path).read_text(encoding="utf-8"))
        assert function in {node.name for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)}, name
        assert reason


def test_no_test_of_the_program_is_left_out(suites: ModuleType) -> None:
    tried = {ROOT / name for suite in suites.SUITES for name in suite.tests}
    files = {path for top in ("protocol", "app", "ui") for path in (ROOT / "tests" / top).rglob("test_*.py")}
    assert {path for path in files if not tried & {path, *path.parents}} == set()
