"""The Commands page on the smallest screen: what is in sight, and what never moves."""

import pytest
from PySide6.QtCore import QPoint, QRect

from app.safety.acts import Act
from app.safety.ritual import Stage
from protocol.link_states import Presence
from protocol.messages import Source
from tests.gestures.gesture_bench import GestureBench
from tests.gestures.gesture_table import ACTS, go_to
from tests.support.window.controls import place
from ui.acts.ritual_widget import RitualWidget
from ui.style.theme import Choice as Theme
from ui.widgets.step_button import is_in_sight


@pytest.mark.parametrize(
    ("theme", "whole"), [(Theme.LIGHT, (Act.ACTIVATE, Act.ZERO)), (Theme.SUNLIGHT, (Act.ACTIVATE,))], ids=str
)
def test_on_the_smallest_screen_the_first_acts_are_whole_and_nothing_moves_them(
    bench: GestureBench, theme: Theme, whole: tuple[Act, ...]
) -> None:
    bench.assembly.appearance.choose(theme)
    bench.window.resize(960, 540)
    bench.window.go_to("commands")
    page = bench.commands

    def places() -> list[QPoint]:
        bench.refresh()
        bench.turn()
        return [place(page.meaning).topLeft(), *(place(row).topLeft() for row in page.acts.values())]

    locked = places()
    for act in whole:
        assert is_in_sight(page.acts[act].confirm), act
    bench.settle_module(is_active=True)
    assert places() == locked
    bench.bench.module.fire(Source.SERIAL, bench.clock())
    bench.until(lambda: bench.device.fresh("triggered", bench.clock()) is True)
    assert places() == locked
    bench.bench.change(mute=True)
    bench.until(lambda: bench.device.presence is not Presence.ONLINE)
    assert places() == locked
    assert "ready to fire" in page.meaning.text()


@pytest.mark.parametrize("theme", [Theme.LIGHT, Theme.SUNLIGHT])
def test_the_deploy_panel_keeps_its_place_at_every_step(bench: GestureBench, theme: Theme) -> None:
    bench.assembly.appearance.choose(theme)
    bench.window.resize(960, 540)
    go_to(bench, ACTS[-2])
    ritual = bench.commands.ritual

    def places() -> tuple[QRect, list[QPoint]]:
        bench.refresh()
        bench.turn()
        steps = (ritual.choose, ritual.rehearse, ritual.arm, ritual.hold, ritual.cancel)
        return place(ritual), [place(one).topLeft() for one in steps]

    bench.go_and_click(ritual.rehearse)
    bench.hand_s += 1.0
    bench.go_and_click(ritual.arm)
    assert ritual.ritual.stage is Stage.ARMED
    armed = places()
    bench.go_and_click(ritual.cancel)
    assert ritual.notice_bar.notice is not None
    assert places() == armed
    ritual._job.dismiss()
    assert places() == armed
    bench.go_and_click(ritual.choose)
    assert ritual.ritual.stage is Stage.CHOSEN
    assert places() == armed
    bench.settle_module(is_active=False)
    assert places() == armed


def test_a_new_deploy_panel_shows_only_its_first_step(bench: GestureBench) -> None:
    ritual = RitualWidget(bench.commands.ritual._services)
    ritual.show()
    bench.turn()
    shown = {one for one in (ritual.rehearse, ritual.choose, ritual.arm, ritual.hold, ritual.cancel, ritual.countdown)
             if one.isVisible()}  # fmt: skip
    ritual.close()
    assert shown == {ritual.rehearse, ritual.choose}
