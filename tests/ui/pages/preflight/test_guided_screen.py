"""The Tests page on the smallest screen, in sunlight: what a person needs now is in sight, without scrolling; the
picture of each step; the printed results."""

import pytest
from PySide6.QtCore import QPoint
from PySide6.QtWidgets import QScrollArea

from app.engine.conversation import ConversationView
from app.guided.catalogue import GUIDED_TESTS
from app.guided.results import GuidedKind
from app.text.i18n import CHINESE, ENGLISH
from protocol.fields import Value
from tests.gestures.gesture_bench import GestureBench
from tests.support.window.steps import find, notice_text
from tests.support.window.walk import SMALL_SCREEN
from tests.ui.pages.preflight.test_guided import activated
from ui.pages.preflight.guided import GuidedPicture, live_text
from ui.session.guided import Stage
from ui.style.theme import DARK, LIGHT, SUNLIGHT, Choice, use
from ui.widgets.step_button import is_in_sight


@pytest.fixture
def bench(bench: GestureBench) -> GestureBench:
    bench.assembly.appearance.choose(Choice.SUNLIGHT)
    bench.window.resize(960, 540)
    return bench


@pytest.mark.parametrize("spoken", [CHINESE, ENGLISH], indirect=True)
def test_every_stage_fits_and_nothing_is_cut_off_in_either_language(
    spoken: str, bench: GestureBench, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Nor is anything scrolled where the screen is as large as we ask for. A value stands beside its limit, and an
    unknown state is not said."""
    page = bench.guided
    bench.show_guided()
    for kind in (test.kind for test in GUIDED_TESTS):
        page.choose(kind)
        bench.wait(0.2)
        for label in (page.title, page.safety):
            assert label.height() >= label.heightForWidth(label.width()), (kind, label.text())
        place = page.primary.mapTo(page, QPoint(0, 0))
        assert page.rect().contains(place + QPoint(page.primary.width() - 1, page.primary.height() - 1))
    if spoken == CHINESE:
        return
    bench.window.resize(SMALL_SCREEN)
    scroll = find(page, QScrollArea, "guided_scroll")
    bar = scroll.verticalScrollBar()
    page.work.choose(GuidedKind.TILT)
    bench.refresh()
    bench.turn()
    assert (page.work.stage, bar.maximum()) == (Stage.READY, 0)
    assert page.title.isVisible()
    bench.prepare_test(GuidedKind.TILT)
    bench.turn()
    assert (page.work.stage, bar.maximum()) == (Stage.CONFIRMING, 0)
    assert is_in_sight(page.title)
    assert is_in_sight(page.activate.confirm)
    page.work.cancel()
    bench.until(lambda: page.work.stage is Stage.DONE)
    bench.refresh()
    bench.turn()
    assert bar.maximum() == 0
    assert is_in_sight(page.result.verdict)
    assert page.title.isVisible()
    known: dict[str, Value | None] = {"tilt_deg": 12, "attitude_threshold_deg": 60}
    monkeypatch.setattr(ConversationView, "fresh", lambda _self, key, _now: known.get(key))
    page.work.choose(GuidedKind.TILT)
    for known["triggered"], note in ((None, ""), (False, " · not triggered"), (True, " · TRIGGERED")):
        assert live_text(page.work, page.module) == f"Tilt: 12° · limit 60°{note}"


@pytest.mark.usefixtures("qapp")
def test_every_step_has_a_picture_of_its_own() -> None:
    """In the colours of the theme: none is empty, and no two are alike."""
    picture, seen = GuidedPicture(), []
    picture.resize(picture.sizeHint())
    for theme in (LIGHT, DARK, SUNLIGHT):
        use(theme)
        picture.show_step(GuidedKind.TILT, 9, "nothing")
        seen.append(picture.grab().toImage())
        for test in GUIDED_TESTS:
            for step in range(len(test.steps)):
                picture.show_step(test.kind, step, "a step")
                seen.append(picture.grab().toImage())
    assert not [(one, two) for two in range(len(seen)) for one in range(two) if seen[one] == seen[two]]


def test_the_banner_does_not_contradict_the_test_that_makes_the_module_fire(bench: GestureBench) -> None:
    bar = bench.window.notice_bar

    def is_said() -> bool:
        return "has triggered" in notice_text(bar)

    activated(bench)
    bench.bench.set_world(tilt_deg=70)
    bench.until(lambda: bench.guided._ports.current.module.view.fresh("triggered", bench.clock.now_s))
    bench.wait(1.0)
    assert bench.bench.module.is_triggered
    assert not is_said()
    bench.guided.work.cancel()
    bench.until(is_said)  # nobody else says now what comes next
