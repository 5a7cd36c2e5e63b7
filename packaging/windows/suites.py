"""The test suites run under Wine, and the tests whose result is unknown there."""

from typing import Final, NamedTuple

from environment import ROOT


class Suite(NamedTuple):
    """Tests that run together; `platform` is Qt's, None for tests that run on Linux and start Windows programs."""

    title: str
    tests: tuple[str, ...]
    platform: str | None
    limit_s: int


def _rooms() -> list[str]:
    """The folders of tests that stand for a room or a page, and the files beside them."""
    tops = [path for top in ("app", "ui", "ui/pages") for path in (ROOT / "tests" / top).iterdir()]
    tops += [ROOT / "tests" / name for name in ("protocol", "scenarios", "gestures", "test_text_files.py")]
    files = (path for path in tops if path.is_dir() or path.name.startswith("test_"))
    return sorted(path.relative_to(ROOT).as_posix() for path in files if path.name not in ("__pycache__", "pages"))


SUITES: Final = (
    *(Suite(name, (name,), "offscreen", 1800) for name in _rooms()),
    Suite("Command line over a COM port", ("tests/windows/test_com_port.py",), None, 900),
    Suite(
        "Window, Qt's windows platform on a virtual screen",
        ("tests/ui/widgets", "tests/ui/connect", "tests/ui/shell/test_shutdown.py", "tests/ui/shell/test_window.py"),
        "windows",
        1200,
    ),
)
INSTALLER: Final = Suite("Installer in a fresh Windows", ("tests/windows/test_installer.py",), None, 1500)
_LINKS: Final = "Wine makes symbolic links that lead nowhere"
NOT_JUDGED: Final[dict[str, str]] = {
    "tests/app/engine/test_reconnect.py::test_a_link_behind_which_an_adapter_has_come_is_left_alone": (
        "a link into /dev, which Wine follows when it is deleted"
    ),
    "tests/app/engine/test_worker.py::test_a_stream_at_line_rate_from_another_process_arrives_whole": (
        "needs a pseudo-terminal"
    ),
    "tests/app/diagnosis/test_adapter_facts.py::test_the_latency_timer_and_the_rule_are_found": "a file of Linux'",
    "tests/app/cli/test_goldens.py::test_csv_file_is_replaced_as_a_whole": _LINKS,
    "tests/app/settings/test_profile_file.py::test_a_profile_named_after_its_file_can_be_saved_again": (
        "its path is longer than the 260 characters of Windows"
    ),
    "tests/scenarios/test_hostile_input.py::"
    "test_circular_links_and_links_of_other_users_in_shared_folders_are_refused": _LINKS,
    "tests/windows/test_com_port.py::test_the_port_is_listed": "Wine keeps no list of ports as devices",
    "tests/windows/test_com_port.py::test_a_second_program_reports_that_the_port_is_in_use": (
        "Wine lets two programs open one pseudo-terminal"
    ),
}
"""Tests that are deselected, with the reason."""
