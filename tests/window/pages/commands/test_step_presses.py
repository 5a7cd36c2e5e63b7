"""The steps of an act: which presses count, by mouse, by key and by both at once."""

from itertools import product

import pytest
from PySide6.QtCore import QPoint, Qt

from app.safety.journal import Act
from tests.support.window.hand import Hand
from ui.widgets.gestures import gestures
from ui.widgets.step_button import StepButton, bring_into_sight


def ask_to_forbid(bench: Hand) -> StepButton:
    """Its last button, which takes both hands."""
    bench.window.resize(1366, 768)
    bench.reset()
    confirm = bench.commands.acts[Act.FORBID_DEPLOY].confirm
    bring_into_sight(confirm)
    bench.click(confirm.ask)
    assert confirm.is_asking
    bench.wait(1.0)
    bench.sent.clear()
    return confirm.go


def is_nothing_sent(bench: Hand) -> bool:
    bench.wait(0.5)
    return not bench.sent


def a_click_that_does_not_count(bench: Hand) -> None:
    for is_double in (False, True):
        go = ask_to_forbid(bench)
        bench.move(bench.at(go))
        if not is_double:
            go.block_pointer()  # as where a layout brought it there
        go.setFocus()
        bench.key(Qt.Key.Key_Space, is_press=True)
        bench.press(is_double=is_double)
        bench.release()
        bench.key(Qt.Key.Key_Space, is_press=False)
        assert is_nothing_sent(bench), is_double
        bench.reset()


def two_hands_on_one_step(bench: Hand) -> None:
    go = ask_to_forbid(bench)
    bench.move(bench.at(go))
    go.setFocus()
    bench.key(Qt.Key.Key_Space, is_press=True)
    bench.press()
    bench.release()
    bench.key(Qt.Key.Key_Space, is_press=False)
    assert is_nothing_sent(bench)
    bench.press()
    bench.key(Qt.Key.Key_Space, is_press=True)
    bench.release()
    bench.key(Qt.Key.Key_Space, is_press=False)
    assert is_nothing_sent(bench)
    bench.click()
    assert not is_nothing_sent(bench)


def the_release_of_a_key_pressed_elsewhere(bench: Hand) -> None:
    go = ask_to_forbid(bench)
    bench.move(bench.at(go))
    bench.window.top_bar.lock.setFocus()
    bench.key(Qt.Key.Key_Return, is_press=True)
    bench.press()
    bench.key(Qt.Key.Key_Space, is_press=False)
    assert is_nothing_sent(bench)
    bench.release()
    bench.key(Qt.Key.Key_Return, is_press=False)
    assert not is_nothing_sent(bench)


def a_press_that_left_the_step(bench: Hand) -> None:
    go = ask_to_forbid(bench)
    bench.move(bench.at(go))
    bench.press()
    bench.move(QPoint(1, 1))
    bench.move(bench.at(go))
    assert not go.isDown()
    bench.release()
    assert is_nothing_sent(bench)


def a_press_that_began_before_the_step_moved(bench: Hand) -> None:
    go = ask_to_forbid(bench)
    bench.move(bench.at(go))
    bench.press()
    bench.window.resize(1180, 720)
    bench.look()
    go.check_place()
    bench.move(QPoint(1, 1))
    bench.wait(1.0)
    bench.move(bench.at(go))
    bench.release()
    assert is_nothing_sent(bench)


def any_click_on_cancel(bench: Hand) -> None:
    ask_to_forbid(bench)
    confirm = bench.commands.acts[Act.FORBID_DEPLOY].confirm
    bench.move(bench.at(confirm.cancel))
    confirm.cancel.setFocus()
    bench.key(Qt.Key.Key_Space, is_press=True)
    bench.press()
    bench.move(QPoint(1, 1))
    bench.move(bench.at(confirm.cancel))
    bench.release()
    assert not confirm.is_asking
    bench.key(Qt.Key.Key_Space, is_press=False)
    assert is_nothing_sent(bench)


@pytest.mark.promise("d")
def test_what_completes_nothing(bench: Hand) -> None:
    for way in (
        a_click_that_does_not_count, two_hands_on_one_step, the_release_of_a_key_pressed_elsewhere,
        a_press_that_left_the_step, a_press_that_began_before_the_step_moved, any_click_on_cancel,
    ):  # fmt: skip
        way(bench)
        bench.reset()


@pytest.mark.promise("d")
def test_a_held_key_and_a_held_mouse_complete_nothing(bench: Hand, monkeypatch: pytest.MonkeyPatch) -> None:
    """What X11 repeats is neither the release of the key nor a press of its own, in whichever order they are let go."""
    monkeypatch.setattr(gestures(), "has_paired_repeats", True)

    def repeat(is_marked: bool) -> None:
        for _ in range(10):
            bench.wait(0.04)
            bench.key(Qt.Key.Key_Space, is_press=False, is_repeat=True, is_marked=is_marked)
            bench.key(Qt.Key.Key_Space, is_press=True, is_repeat=True, is_marked=is_marked)

    for is_marked in (True, False):
        go = ask_to_forbid(bench)
        bench.move(bench.at(go))
        for is_key_first, is_key_last in product((False, True), repeat=2):
            go.setFocus()
            if is_key_first:
                bench.key(Qt.Key.Key_Space, is_press=True)
                repeat(is_marked)
            bench.press()
            if not is_key_first:
                bench.key(Qt.Key.Key_Space, is_press=True)
            repeat(is_marked)
            if is_key_last:
                bench.release()
                repeat(is_marked)
            bench.key(Qt.Key.Key_Space, is_press=False)
            bench.wait(0.1)
            if not is_key_last:
                bench.release()
            assert is_nothing_sent(bench), (is_marked, is_key_first, is_key_last)
        bench.click()
        assert not is_nothing_sent(bench), is_marked
        bench.wait(5.0)
        bench.reset()
