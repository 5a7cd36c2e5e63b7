"""No careless gesture completes an act: a sample of the table; the soak test runs all of it."""

from pathlib import Path

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QSignalSpy
from PySide6.QtWidgets import QApplication, QToolButton

from tests.gestures.gesture_bench import gesture_bench
from tests.gestures.gesture_table import ACTS, LANGUAGES, SIZES, is_possible, run_window
from tests.support.window.steps import find

EVERY = 499
"""Of some 6,000 tries at each button."""


@pytest.mark.parametrize(("number", "language"), list(enumerate(LANGUAGES)))
def test_no_careless_gesture_completes_an_act(qapp: QApplication, number: int, language: str) -> None:
    """Each act is tried in one of the languages."""
    acts = ACTS[number :: len(LANGUAGES)]
    tallies = run_window(qapp, SIZES[number % len(SIZES)], language, 1, every=EVERY, first_try=7 * number, acts=acts)
    assert all(sum(tally.tries.values()) >= 5 for tally in tallies)
    assert [one for tally in tallies for one in tally.left] == []


def test_the_whole_gesture_completes_each(qapp: QApplication, tmp_path: Path) -> None:
    """The complete gesture succeeds, without which the table would prove nothing."""
    with gesture_bench(qapp, tmp_path) as bench:
        assert [act.name for act in ACTS if not is_possible(bench, act)] == []


def test_a_menu_that_a_key_opens_is_closed(qapp: QApplication, tmp_path: Path) -> None:
    """Else it would wait for a person for ever."""
    with gesture_bench(qapp, tmp_path) as bench:
        bench.window.go_to("settings")
        bench.turn()
        more = find(bench.settings, QToolButton, "settings_more")
        more.setFocus()
        assert more.hasFocus()
        opened = QSignalSpy(more.menu().aboutToShow)
        bench.key(Qt.Key.Key_Space, is_press=True)
        bench.key(Qt.Key.Key_Space, is_press=False)
        assert opened.count() == 1
        assert QApplication.activePopupWidget() is None
