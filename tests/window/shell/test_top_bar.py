"""The top bar, announcements, each state once, sounds; notices, and that no button takes the place of another."""

import re
import sys
import wave
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree

import pytest
from PySide6.QtCore import QPoint, QRect
from PySide6.QtWidgets import QApplication, QLabel, QWidget
from pytestqt.qtbot import QtBot

from app.engine.target import Target
from app.safety.last_known import keep_away
from tests.module.module import ACTIVATION, BY_PWM, Module
from tests.support.records.recordings_made import batch, talk
from tests.support.window import screen_reader
from tests.support.window.controls import covered, moved, places, visible_in
from tests.support.window.cut_off import cut_off
from tests.support.window.fakes_ui import window
from tests.support.window.rig import Rig
from tests.support.window.screen_reader import announced
from tests.support.window.steps import given, let_lay_out, notice_text
from ui.core.preferences import Preferences
from ui.main import PAGES, WindowOptions
from ui.shell.announcements import Sound, StateAnnouncer, write_tones
from ui.shell.main_window import MainWindow
from ui.style.theme import Choice as Theme
from ui.style.theme import Meaning
from ui.widgets.notice_bar import NoticeBar
from ui.widgets.notices import Choice, Notice

ALONE = pytest.mark.module(is_connected=False)
"""No module but those that the test plugs in."""


@ALONE
def test_a_cell_that_runs_down_and_its_charger_are_shown_each_by_itself(one: Rig) -> None:
    (_port, module), cell = one.plug_in(USB0), one.window.top_bar.cell
    module.readings.cell = 0x9B
    one.until(lambda: "3.10 V" in cell.accessibleName())
    module.readings.charging = 1
    one.until(lambda: "charging" in cell.accessibleName())


FIRES = r"(?:fires?|deploys?)\b"
REASSURES = re.compile(
    rf"\b(?:does not|do not|will not|won't|cannot|never|nothing can|no longer|not going to) {FIRES}|neither arms"
    r"|\bnothing that can fire|\bnot to fire|(?<!可能)(?:不会|永不|不再|不能|无法)(?:自动|真的)?(?:触发)?(?:开伞|触发)"
    r"|也不开伞",
    re.IGNORECASE,
)
CONDITIONAL = re.compile(r"\bwould not (?:have fired|fire)\b", re.IGNORECASE)
TRANSLATION = Path(__file__).parents[3] / "app" / "locale" / "zh_CN.ts"


@pytest.mark.promise("l")
def test_no_text_of_the_program_says_that_a_module_does_not_fire() -> None:
    found = []
    for message in ElementTree.parse(TRANSLATION).getroot().iter("message"):
        source, chinese = message.findtext("source") or "", message.findtext("translation") or ""
        if not CONDITIONAL.search(source):  # of what was measured, not of the module
            found += [text for text in (source, chinese) if REASSURES.search(text)]
    assert not found


@ALONE
@pytest.mark.promise("h")
def test_without_reports_it_says_how_old_the_last_one_is(one: Rig) -> None:
    one.plug_in(USB0, {ACTIVATION: 1})
    activation = one.window.top_bar.activation
    assert activation.word == "ACTIVE"
    one.workers.clear()  # as where a driver hangs
    for age_s in (12, 15):
        one.until(lambda age_s=age_s: f"{age_s} s ago" in activation.accessibleName())  # type: ignore[misc]


USB0, USB1 = "/dev/ttyUSB0", "/dev/ttyUSB1"


class Listener(NamedTuple):
    said: list[str]
    played: list[Sound]

    def heard(self, one: Rig, count: int = 1) -> list[str]:
        """What was announced since it was last asked."""
        one.until(lambda: len(self.said) >= count)
        one.wait(1.0)  # what else waits is said now
        said = self.said.copy()
        self.said.clear()
        return said


@pytest.fixture
def listener(one: Rig, monkeypatch: pytest.MonkeyPatch) -> Listener:
    played = list[Sound]()
    monkeypatch.setattr(StateAnnouncer, "play", lambda _announcer, sound: played.append(sound))
    return Listener(announced(monkeypatch), played)


@ALONE
def test_with_several_ports_a_word_and_a_sound_are_of_the_one(one: Rig, listener: Listener) -> None:
    first, _ = one.plug_in(USB0)
    second, module = one.plug_in(USB1, {ACTIVATION: 1})
    assert listener.heard(one, 2)[-1] == f"{USB1}: ACTIVE"
    one.unplug(first)  # it was locked, whatever the other one is
    listener.heard(one)
    assert listener.played == [Sound.ACTIVE]
    module.trigger(one.clock(), BY_PWM)
    listener.heard(one)
    one.unplug(second)
    listener.heard(one)
    assert listener.played == [Sound.ACTIVE, Sound.TRIGGERED, Sound.LOST_WHILE_ACTIVE]


@ALONE
@pytest.mark.promise("j")
def test_each_state_is_told_once_when_it_becomes_so(one: Rig, listener: Listener) -> None:
    _, module = one.plug_in(USB0)
    assert listener.heard(one) == ["LOCKED"]
    module.settings[ACTIVATION] = 1
    assert listener.heard(one) == ["ACTIVE"]
    for second in range(1, 31):  # values and ages change all the time
        module.readings.tilt_deg, module.readings.cell = second, 0xC8 - second
        one.wait(1.0)
    module.trigger(one.clock(), BY_PWM)
    assert listener.heard(one) == ["TRIGGERED!"]
    module.settings[ACTIVATION] = 0
    assert listener.heard(one) == ["LOCKED"]


@ALONE
@pytest.mark.promise("j")
def test_a_lost_link_is_told_with_what_it_means_and_the_state_again_afterwards(one: Rig, listener: Listener) -> None:
    port, module = one.plug_in(USB0, {ACTIVATION: 1})
    assert listener.heard(one) == ["ACTIVE"]
    one.unplug(port)
    (lost,) = listener.heard(one)
    assert lost.endswith(f"treat it as ready to fire. {keep_away()}!")
    activation = one.window.top_bar.activation
    assert (activation.word, activation.meaning, activation.stale_age != "") == ("was ACTIVE", Meaning.ATTENTION, True)
    assert any("Last heard ACTIVE" in notice.text for notice in one.window.notice_bar.notices)
    assert one.window.top_bar.lock.isEnabled()  # it is owed
    module.trigger(one.clock(), BY_PWM)
    port.connect_to(given(port.target))
    assert listener.heard(one, 2) == ["TRIGGERED!", "ACTIVE"]
    port.treat_as_another()
    assert listener.heard(one, 2) == ["TRIGGERED!", "ACTIVE"], "another module, of which all is told again"


@ALONE
@pytest.mark.promise("a", "f")
def test_neither_a_doubt_nor_a_name_nor_a_shutdown_is_said_of_another_adapter(one: Rig) -> None:
    port, module = one.plug_in(USB0, {ACTIVATION: 1})
    port.module.say_name("M-07")
    module.restart(one.clock())
    one.until(lambda: port.module.number > 1 and port.module.is_read)
    port.note_shutdown()
    module.be_silent(one.clock(), 20.0)
    one.until(lambda: not port.module.is_going)
    one.devices[USB1] = (Module(now=one.clock()),)
    for device, name in ((USB0, "M-07"), (USB1, "")):
        port.connect_to(Target(device, 115200))
        assert (port.last_name, port.switched_off_at is not None) == (name, bool(name)), device
    for device, word in ((USB0, "may have fired"), (USB1, "NOT TRIGGERED")):
        port.connect_to(Target(device, 115200))
        one.until(lambda: port.module.is_read)
        one.until(lambda word=word: one.window.top_bar.trigger.word == word)  # type: ignore[misc]


def player(folder: Path, name: str, *, code: int) -> Path:
    """A program that notes what it is to play."""
    played = folder / f"{name}.txt"
    program = folder / name
    program.write_text(f'#!/bin/sh\necho "$@" >> {played}\nexit {code}\n', encoding="utf-8")
    program.chmod(0o755)
    return played


@ALONE
@pytest.mark.skipif(sys.platform == "win32", reason="the players are scripts")
def test_a_chosen_sound_is_played_by_the_first_player_that_works(
    qtbot: QtBot, one: Rig, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    beeps: list[bool] = []
    monkeypatch.setattr(QApplication, "beep", lambda: beeps.append(True))
    preferences = Preferences(tmp_path / "sounds.ini")
    sounds = StateAnnouncer(one.assembly.ports, preferences)
    sounds.play(Sound.ACTIVE)
    preferences.has_sounds = True
    sounds.play(Sound.ACTIVE)
    qtbot.waitUntil(lambda: beeps == [True])  # no player; before it was chosen, nothing
    broken = player(tmp_path, "paplay", code=1)
    works = player(tmp_path, "aplay", code=0)
    sounds.play(Sound.TRIGGERED)
    # The shell makes the file before it writes into it.
    qtbot.waitUntil(lambda: works.exists() and works.read_text(encoding="utf-8").endswith("\n"))
    assert broken.exists()
    option, path = works.read_text(encoding="utf-8").split()
    assert (option, Path(path).name) == ("-q", "triggered.wav")
    write_tones(tmp_path / "tones.wav", Sound.TRIGGERED.value)
    with wave.open(str(tmp_path / "tones.wav")) as file:
        assert 0.5 < file.getnframes() / file.getframerate() < 2
    assert beeps == [True]


def test_a_name_on_a_button_is_whole(qtbot: QtBot) -> None:
    """Qt takes "&" for the mark of a key: R&D-1 would read as RD-1, which may be another module."""
    bar = NoticeBar()
    qtbot.addWidget(bar)
    bar.show_notices([Notice(Meaning.ATTENTION, "", (Choice("same_module", "It is R&D-1", bar.hide),))])
    button = given(bar.button("same_module"))
    assert (button.text(), screen_reader.name_of(button)) == ("It is R&&D-1", "It is R&D-1")
    assert button.shortcut().isEmpty()


def test_the_close_button_never_takes_the_place_of_another(qtbot: QtBot) -> None:
    bar = NoticeBar()
    qtbot.addWidget(bar)
    bar.setFixedWidth(800)
    buttons = tuple(Choice(key, key, lambda: None) for key in ("one", "two"))
    shown = []
    for choices, dismiss in ((buttons, None), ((), bar.hide), (buttons[:1], bar.hide), (buttons[:1], None)):
        bar.show_notices([Notice(Meaning.ATTENTION, "Something", choices, dismiss)])
        let_lay_out(bar)
        shown.append(places(bar))
    assert "notice_dismiss" in shown[1]
    for before in shown:
        for after in shown:
            assert [one for one in covered(before, after) if one.startswith("notice_dismiss")] == []
    assert moved(shown[2], shown[3]) == []


@pytest.mark.module("triggers", "preflight", active=True)
def test_notices_after_a_trigger_and_a_restart(one: Rig) -> None:
    main = one.window
    main.go_to("preflight")
    one.bench.pulse_pwm()
    one.until(lambda: main.notice_bar.button("after_trigger") is not None)
    notice = given(main.notice_bar.notice)
    assert notice.meaning is Meaning.DANGER
    notice.choices[0].act()
    assert main.navigation.chosen == "triggers"
    assert main.notice_bar.button("after_trigger") is None  # it leads to the page that is shown
    given(notice.dismiss)()
    assert main.notice_bar.notice is None  # it was read; the top bar still says TRIGGERED
    main.go_to("preflight")
    one.bench.restart()
    one.until(lambda: "reported TRIGGERED before" in notice_text(main.notice_bar))
    notice = given(main.notice_bar.notice)
    assert notice.meaning is Meaning.DANGER
    given(notice.dismiss)()
    one.until(lambda: given(main.notice_bar.notice).cause == "interruptions")  # once it answers again
    assert "The module restarted." in notice_text(main.notice_bar)
    given(given(main.notice_bar.notice).dismiss)()
    assert main.notice_bar.notice is None


@ALONE
def test_a_notice_that_was_closed_comes_again_with_its_cause(one: Rig) -> None:
    bar, (_port, module) = one.window.notice_bar, one.plug_in(USB0)
    for is_triggered in (True, False, True):
        module.triggered = is_triggered
        word = "TRIGGERED" if is_triggered else "NOT TRIGGERED"
        one.until(lambda word=word: one.window.top_bar.trigger.word == word)  # type: ignore[misc]
        if is_triggered:
            assert "has triggered" in notice_text(bar)
            given(given(bar.notice).dismiss)()
            assert "has triggered" not in notice_text(bar)


NOTICES = (
    Notice(Meaning.ATTENTION, "Short."),
    Notice(Meaning.DANGER, "Long enough for a second line. " * 5, (Choice("one", "One", lambda: None),), lambda: None),
    Notice(
        Meaning.ATTENTION,
        "With the most buttons that a notice has.",
        tuple(Choice(key, "Leave it ACTIVE", lambda: None, is_main=key == "a") for key in "abc"),
    ),
)


@pytest.mark.parametrize("language", ["en", "zh_CN"])
@pytest.mark.promise("d")
def test_nothing_moves_on_any_page_when_a_notice_comes_and_goes(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, language: str
) -> None:
    shown: list[Notice | None] = [None]
    with window(qapp, tmp_path, options=WindowOptions(language=language), entries=PAGES) as assembly:
        main = assembly.window
        qtbot.waitSignal(main.pages_made).wait()
        monkeypatch.setattr(main.attention, "_notices", lambda: [] if shown[0] is None else [shown[0]])
        assembly.appearance.choose(Theme.SUNLIGHT)
        main.resize(960, 540)
        for entry in PAGES:
            main.go_to(entry.key)
            before = laid_out(main, entry.key)
            for shown[0] in (*NOTICES, None):
                after = laid_out(main, entry.key)
                assert after == before, (entry.key, shown[0])
                assert cut_off(main.statusBar()) == []
        assembly.appearance.choose(Theme.LIGHT)


def laid_out(main: MainWindow, page: str) -> dict[QWidget, QRect]:
    """The exact places of everything but the status bar."""
    let_lay_out(main)
    assert main.navigation.chosen == page
    return {
        one: QRect(one.mapTo(main, QPoint()), one.size())
        for one in visible_in(main)
        if not one.isWindow() and not main.statusBar().isAncestorOf(one)
    }


def test_several_notices_stand_at_once_and_the_graver_one_is_whole(qtbot: QtBot) -> None:
    calm = Notice(Meaning.INFORMATION, "Advice.", (Choice("advice", "Do it", lambda: None),))
    grave = Notice(Meaning.DANGER, "Silent for 1 s", cause="link")
    bar = NoticeBar(is_foot=True)
    qtbot.addWidget(bar)
    bar.show_notices([calm])
    assert not bar.more.isVisibleTo(bar)
    bar.show_notices([grave, calm])
    assert notice_text(bar) == "Silent for 1 s"
    assert bar.more.isVisibleTo(bar)
    bar.more.click()
    button = given(bar.button("advice"))
    later = grave._replace(text="Silent for 2 s")
    bar.show_notices([later, calm])
    assert notice_text(bar) == "Advice.", "a text that ticks is no new notice"
    assert bar.button("advice") is button, "it would swallow a click in progress"
    bar.show_notices([Notice(Meaning.DANGER, "It fired."), later, calm])
    assert notice_text(bar) == "It fired."
    bar.show_passing("The module reports LOCKED.")
    bar.show_notices([grave])
    shown = given(bar.findChild(QLabel, "notice_text")).text()
    assert shown == "Silent for 1 s · The module reports LOCKED.", "it is none of what the notice says"


@ALONE
@pytest.mark.promise("l")
def test_lock_first_locks_every_module_and_closing_asks_while_that_is_not_reported(one: Rig) -> None:
    modules = [one.plug_in(device, {ACTIVATION: 1}) for device in (USB0, USB1)]
    one.workers.clear()  # no LOCK leaves
    one.window.close()
    given(one.window.notice_bar.button("lock_and_leave")).click()
    assert [port.lock.is_repeating for port, _module in modules] == [True, True]
    one.window.leaving.stay()
    for port, _module in modules:  # as before LOCK: it is not the answer
        view = talk(one.clock(), number=port.module.number, active=False)
        port.bridge.batch.emit(batch(one.clock(), view=view, connection=port.connection))
    one.window.close()
    assert one.window.isVisible()
    assert "it does not report LOCKED" in notice_text(one.window.notice_bar)
