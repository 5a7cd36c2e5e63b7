"""The panel "Would it have fired?" read aloud, in a language 40 % longer, and in the three themes."""

import pytest
from PySide6.QtWidgets import QApplication, QScrollArea, QToolButton
from pytestqt.qtbot import QtBot

from app.engine.device import StatusSample
from app.text.i18n import ENGLISH, PSEUDO, set_language
from tests.app.text.test_pseudo_language import untranslated
from tests.support.window.cut_off import cut_off, cut_off_in_paint
from tests.support.window.live_bench import Bench, live_bench
from tests.support.window.painted_text import picture_of, watching
from tests.ui.shell.test_accessibility import out_of_order, repeats, silent_paint, unnamed
from tests.ui.style.test_contrast import unusable_in, weak_in_paint, weak_in_style
from ui.style.theme import Choice


def opened(bench: Bench) -> Bench:
    """With something of everything in it."""
    samples = [
        StatusSample(bench.now_s + n / 50, tilt, 1.0, False, n < 5) for n, tilt in enumerate((0, 58, 0, 70, 0, 0, 0))
    ]
    bench.say(*samples, leave_out="freefall_acceleration_g")
    bench.now_s += 20.0
    bench.say()
    bench.click("live_would_fire", QToolButton)
    panel = bench.page.fired.panel
    panel.wanted.choose("freefall_time_s", 1.2)
    panel.wanted.type_text("freefall_acceleration_g", "x")
    panel.about.click()
    bench.page.refresh()
    bench.page.draw()
    QApplication.processEvents()  # what was shown is laid out
    return bench


@pytest.mark.parametrize("scrolled", [0, 10_000])
def test_every_control_is_named_and_in_order(qtbot: QtBot, qapp: QApplication, scrolled: int) -> None:
    with live_bench(qtbot, qapp) as bench:
        page = opened(bench).page
        bench.find(QScrollArea, "fired_scroll").verticalScrollBar().setValue(scrolled)
        assert not [*unnamed(page), *repeats(page), *out_of_order(page), *silent_paint(page)]


@pytest.mark.parametrize("language", [ENGLISH, PSEUDO])
def test_nothing_is_cut_off(qtbot: QtBot, qapp: QApplication, language: str) -> None:
    set_language(language)
    with live_bench(qtbot, qapp) as bench:
        bench.page.resize(864, 478)  # what 1024x600 leaves
        page = opened(bench).page
        with watching() as drawn:
            picture_of(page)
        assert page.width() == 864
        assert not [*cut_off(page), *cut_off_in_paint(drawn)]
        assert language == ENGLISH or not list(untranslated(page))


@pytest.mark.parametrize("choice", [Choice.LIGHT, Choice.DARK, Choice.SUNLIGHT], ids=lambda one: one.value)
def test_every_text_can_be_read(qtbot: QtBot, qapp: QApplication, choice: Choice) -> None:
    with live_bench(qtbot, qapp) as bench:
        bench.appearance.choose(choice)
        page = opened(bench).page
        with watching() as drawn:
            picture = picture_of(page)
        assert not [*weak_in_style(page, picture, unusable_in(page)), *weak_in_paint(page, picture, drawn)]
