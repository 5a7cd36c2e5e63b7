"""The Tests page on the smallest screen, in sunlight: what a person needs now is in sight, without scrolling; and the
picture of each step."""

import pytest
from PySide6.QtCore import QPoint
from PySide6.QtWidgets import QScrollArea

from app.guided.catalogue import GUIDED_TESTS
from app.guided.results import GuidedKind
from tests.gestures.gesture_bench import GestureBench
from tests.support.window.steps import find
from ui.pages.tests.controller import Stage
from ui.pages.tests.widgets import GuidedPicture
from ui.style.theme import Choice
from ui.widgets.step_button import is_in_sight


@pytest.fixture
def bench(bench: GestureBench) -> GestureBench:
    bench.assembly.appearance.choose(Choice.SUNLIGHT)
    bench.window.resize(960, 540)
    return bench


def test_every_stage_of_a_guided_test_fits(bench: GestureBench) -> None:
    page = bench.guided
    bench.window.go_to("tests")
    scroll = find(page, QScrollArea, "tests_scroll")
    bar = scroll.verticalScrollBar()
    page.work.choose(GuidedKind.TILT)
    bench.refresh()
    bench.turn()
    assert (page.work.stage, bar.maximum()) == (Stage.READY, 0)
    assert page.title.isVisible()
    bench.prepare_test(GuidedKind.TILT)
    bench.turn()
    assert (page.work.stage, bar.maximum()) == (Stage.CONFIRMING, 0)
    assert is_in_sight(page.instruction)
    assert is_in_sight(page.activate.confirm)
    assert not page.title.isVisible()
    page.work.cancel()
    bench.until(lambda: page.work.stage is Stage.DONE)
    bench.refresh()
    bench.turn()
    assert bar.maximum() == 0
    assert is_in_sight(page.result.verdict)
    assert page.title.isVisible()


def test_every_step_has_a_picture_of_its_own(bench: GestureBench) -> None:
    """In the colours of the theme: none is empty, and no two are alike."""
    picture, seen = GuidedPicture(), []
    picture.resize(picture.sizeHint())
    for choice in (Choice.LIGHT, Choice.DARK, Choice.SUNLIGHT):
        bench.assembly.appearance.choose(choice)
        picture.show_step(GuidedKind.ZERO, 0, "nothing")
        seen.append(picture.grab().toImage())
        for test in GUIDED_TESTS:
            for step in range(len(test.steps)):
                picture.show_step(test.kind, step, "a step")
                seen.append(picture.grab().toImage())
    assert not [(one, two) for two in range(len(seen)) for one in range(two) if seen[one] == seen[two]]


def test_nothing_is_cut_off_at_the_smallest_size_in_either_language(bench: GestureBench) -> None:
    page = bench.guided
    bench.window.go_to("tests")
    for language in ("en", "zh_CN"):
        bench.assembly.language_switch.use(language)
        for kind in (test.kind for test in GUIDED_TESTS):
            page.go_to(kind.value)
            bench.wait(0.2)
            for label in (page.title, page.safety, page.instruction):
                assert label.height() >= label.heightForWidth(label.width()), (kind, label.text())
            place = page.primary.mapTo(page, QPoint(0, 0))
            assert page.rect().contains(place + QPoint(page.primary.width() - 1, page.primary.height() - 1))
    bench.assembly.language_switch.use("en")
