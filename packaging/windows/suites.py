"""The test suites run under Wine, and the tests whose result is unknown there."""

from typing import Final, NamedTuple

from environment import ROOT


class Suite(NamedTuple):
    """Tests that run together; `platform` is Qt's, None for tests that run on Linux and start Windows programs."""

    title: str
    tests: tuple[str, ...]
    platform: str | None
    limit_s: int


_NAMED: Final = (
    Suite("Protocol", ("tests/protocol",), "offscreen", 300),
    Suite("Text and files", ("tests/app/text", "tests/app/system", "tests/test_text_files.py"), "offscreen", 300),
    Suite(
        "Engine and procedures",
        ("tests/app/engine", "tests/app/procedures", "tests/app/safety", "tests/app/port_urls", "tests/app/samples"),
        "offscreen",
        600,
    ),
    Suite("Store", ("tests/app/store",), "offscreen", 600),
    Suite("Profiles and limits", ("tests/app/settings", "tests/app/limits"), "offscreen", 600),
    Suite("Recordings", ("tests/app/recordings", "tests/app/captures", "tests/app/firing"), "offscreen", 900),
    Suite(
        "Pre-flight check and records",
        ("tests/app/preflight", "tests/app/records", "tests/app/trigger_records"),
        "offscreen",
        900,
    ),
    Suite("Diagnosis", ("tests/app/diagnosis",), "offscreen", 300),
    Suite("Simulated module", ("tests/app/simulator",), "offscreen", 600),
    Suite("Command line", ("tests/app/cli", "tests/app/terminal", "tests/app/test_frozen.py"), "offscreen", 1200),
    Suite("Command line over a COM port", ("tests/windows/test_com_port.py",), None, 900),
    Suite("Flight logs", ("tests/app/flight_logs", "tests/app/flight_analysis", "tests/app/guided"), "offscreen", 600),
    Suite("Scenarios and gestures", ("tests/scenarios", "tests/gestures"), "offscreen", 1800),
    Suite(
        "Window, its parts",
        ("tests/ui/core", "tests/ui/files", "tests/ui/help", "tests/ui/plots", "tests/ui/services",
         "tests/ui/simulator", "tests/ui/style", "tests/ui/widgets"),
        "offscreen",
        1800,
    ),
    Suite("Window, shell and connecting", ("tests/ui/shell", "tests/ui/lock", "tests/ui/connect"), "offscreen", 1800),
    Suite("Window, live page", ("tests/ui/pages/live",), "offscreen", 1800),
    Suite(
        "Window, check, commands and settings",
        ("tests/ui/pages/preflight", "tests/ui/pages/commands", "tests/ui/pages/settings", "tests/ui/pages/tests"),
        "offscreen",
        1800,
    ),
    Suite(
        "Window, recordings and diagnosis",
        ("tests/ui/pages/recordings", "tests/ui/pages/flights", "tests/ui/pages/diagnosis", "tests/ui/pages/triggers"),
        "offscreen",
        1800,
    ),
    Suite(
        "Window, Qt's windows platform on a virtual screen",
        ("tests/ui/widgets", "tests/ui/connect", "tests/ui/shell/test_shutdown.py", "tests/ui/shell/test_window.py"),
        "windows",
        1200,
    ),
)  # fmt: skip


def _unnamed() -> tuple[str, ...]:
    """Test files that no suite names."""
    named = {ROOT / path for suite in _NAMED for path in suite.tests}
    files = (path for top in ("protocol", "app", "ui") for path in (ROOT / "tests" / top).rglob("test_*.py"))
    return tuple(sorted(path.relative_to(ROOT).as_posix() for path in files if not named & {path, *path.parents}))


_NEW: Final = _unnamed()
SUITES: Final = (*_NAMED, *([Suite("Everything else", _NEW, "offscreen", 1800)] if _NEW else []))
QUICK: Final = Suite(
    "A short part",
    ("tests/protocol/test_frame.py", "tests/protocol/test_messages.py", "tests/app/settings/test_profile_file.py",
     "tests/app/system/test_logs.py"),
    "offscreen",
    150,
)  # fmt: skip
INSTALLER: Final = Suite("Installer in a fresh Windows", ("tests/windows/test_installer.py",), None, 1500)
_LINKS: Final = "Wine makes symbolic links that lead nowhere"
NOT_JUDGED: Final[dict[str, str]] = {
    "tests/app/engine/test_reconnect.py::test_a_link_behind_which_an_adapter_has_come_is_left_alone": (
        "a link into /dev, which Wine follows when it is deleted"
    ),
    "tests/app/engine/test_worker.py::test_reading_everything_over_a_pseudo_terminal": "needs a pseudo-terminal",
    "tests/app/engine/test_worker.py::test_a_stream_at_line_rate_from_another_process_arrives_whole": (
        "needs a pseudo-terminal"
    ),
    "tests/app/diagnosis/test_adapter_facts.py::test_the_latency_timer_and_the_rule_are_found": "a file of Linux'",
    "tests/app/cli/test_cli_shapes.py::test_csv_file_is_replaced_as_a_whole": _LINKS,
    "tests/scenarios/test_hostile_input.py::test_the_target_of_a_link_is_replaced_and_the_link_kept": _LINKS,
    "tests/scenarios/test_hostile_input.py::"
    "test_circular_links_and_links_of_other_users_in_shared_folders_are_refused": _LINKS,
    "tests/windows/test_com_port.py::test_the_port_is_listed": "Wine keeps no list of ports as devices",
    "tests/windows/test_com_port.py::test_a_second_program_reports_that_the_port_is_in_use": (
        "Wine lets two programs open one pseudo-terminal"
    ),
}
"""Tests that are deselected, with the reason."""
