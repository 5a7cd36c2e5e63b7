"""Every place where a write begins asks the same question, and a new one cannot miss it."""

import ast
from pathlib import Path

ROOT = Path(__file__).parents[3]
SENDS = frozenset({"write_all", "write_logged", "write_verified"})
"""The procedures that set settings; that they refuse what nobody accepted is held by `test_write_all.py`."""
BEGINNINGS = {
    "app/cli/settings/set.py": "test_goldens.py::test_what_is_said_and_sent",
    "app/preflight/provision.py": "test_cli_provision.py::"
    "test_without_consent_or_where_no_module_can_pass_nothing_is_sent",
    "app/preflight/run.py": "test_accepted_risks.py::test_a_check_only_enables",
    "app/procedures/write_all.py": "test_write_all.py::"
    "test_nothing_that_takes_protection_away_is_sent_unless_a_person_accepted_it",
    "ui/pages/fleet/group_jobs.py": "test_fleet_groups.py::"
    "test_a_profile_that_takes_protection_away_is_asked_about_before_it_is_written_to_any",
    "ui/pages/settings/controller.py": "test_settings_page.py::test_against_the_advice_needs_a_second_click",
}
"""Files that write settings, and the test that shows how each asks: what is applied, restored or proposed becomes an
edit of the Settings page and is written there."""


def _calls(path: Path) -> set[str]:
    tree = ast.parse(path.read_text(encoding="utf-8"))
    return {node.func.id for node in ast.walk(tree) if isinstance(node, ast.Call) and isinstance(node.func, ast.Name)}


def test_every_place_where_a_write_begins_is_in_the_table() -> None:
    files = [path for room in ("app", "ui") for path in (ROOT / room).rglob("*.py")]
    writing = {path.relative_to(ROOT).as_posix() for path in files if _calls(path) & SENDS}
    assert writing == BEGINNINGS.keys()
    for file, function in (row.split("::") for row in BEGINNINGS.values()):
        (path,) = (ROOT / "tests").rglob(file)
        assert f"def {function}(" in path.read_text(encoding="utf-8")


def test_a_check_only_enables() -> None:
    tree = ast.parse((ROOT / "app/preflight/run.py").read_text(encoding="utf-8"))
    changes = [ast.unparse(node) for node in ast.walk(tree)
               if isinstance(node, ast.Call) and ast.unparse(node.func) == "SettingChange"]  # fmt: skip
    assert changes == ["SettingChange(command, True)"]
