"""The top bar, announcements, each state once, sounds; notices, and that no button takes the place of another."""

import re
import sys
import wave
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree

import pytest
from PySide6.QtCore import QPoint, QRect
from PySide6.QtWidgets import QApplication, QLabel, QWidget
from pytestqt.qtbot import QtBot

from app.engine.target import Target
from app.limits.limits import LimitsInUse
from app.safety.last_known import keep_away
from protocol.events import EndReason
from tests.support.window import screen_reader
from tests.support.window.controls import covered, moved, places, visible_in
from tests.support.window.cut_off import cut_off
from tests.support.window.fake_ports import VALUES, FakePorts, fake_window, ports_alone
from tests.support.window.fakes_ui import connect, page_entries, simulated, window
from tests.support.window.screen_reader import announced
from tests.support.window.steps import given, let_lay_out, notice_text
from ui.core.preferences import Preferences
from ui.main import PAGES, WindowOptions
from ui.shell.announcements import Sound, StateAnnouncer, write_tones
from ui.shell.bars import TopBar
from ui.shell.main_window import MainWindow
from ui.style.theme import Choice as Theme
from ui.style.theme import Meaning
from ui.widgets.notice_bar import NoticeBar
from ui.widgets.notices import Choice, Notice


@pytest.fixture
def ports(qapp: QApplication) -> Iterator[FakePorts]:
    made = ports_alone()
    yield made
    made.stop()


@pytest.fixture
def bar(qtbot: QtBot, ports: FakePorts) -> TopBar:
    made = TopBar(ports.ports, LimitsInUse())
    qtbot.addWidget(made)
    return made


@pytest.mark.parametrize(
    ("values", "says", "is_loud"),
    [
        ({}, "not known", False),
        ({"attitude_trigger": True}, "not known", False),
        ({"attitude_trigger": True, "freefall_trigger": True}, "both on", False),
        ({"attitude_trigger": False}, "tilt off", True),
        ({"attitude_trigger": True, "freefall_trigger": False}, "fall off", True),
        ({"attitude_trigger": False, "freefall_trigger": False}, "both off", True),
    ],
)
def test_it_says_whether_the_triggers_are_on(
    qtbot: QtBot, ports: FakePorts, bar: TopBar, values: dict[str, bool], says: str, is_loud: bool
) -> None:
    port, _module = ports.plug_in("/dev/one", **values)
    qtbot.waitUntil(lambda: port.is_open and bar.activation.word == "LOCKED")
    assert bar.triggers.word == says
    assert bar.triggers.accessibleName() == f"triggers: {says}"
    assert (bar.triggers.meaning is Meaning.ATTENTION) is is_loud


def test_what_the_module_reports_otherwise_is_shown_at_once(qtbot: QtBot, ports: FakePorts, bar: TopBar) -> None:
    """Each by itself: nothing else changes that would bring it up to date."""
    port, module = ports.plug_in("/dev/one", attitude_trigger=True)
    qtbot.waitUntil(lambda: port.is_open and bar.activation.word == "LOCKED")
    for values, shows, wanted in (
        ({"freefall_trigger": False}, lambda: bar.triggers.word, "fall off"),
        ({"freefall_trigger": True}, lambda: bar.triggers.word, "both on"),
        ({"attitude_trigger": False}, lambda: bar.triggers.word, "tilt off"),
        ({"cell_voltage_v": 3.1}, bar.cell.accessibleName, "3.10 V"),
        ({"charging": True}, bar.cell.accessibleName, "charging"),
        ({"triggered": True}, lambda: bar.trigger.word, "TRIGGERED"),
        ({"active": True}, lambda: bar.activation.word, "ACTIVE"),
    ):
        assert wanted not in re.split(r", |: ", shows())
        module.say(**values)
        qtbot.waitUntil(lambda shows=shows, wanted=wanted: wanted in re.split(r", |: ", shows()))  # type: ignore[misc]


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


@pytest.mark.promise("h")
def test_without_reports_it_says_how_old_the_last_one_is(qtbot: QtBot, ports: FakePorts, bar: TopBar) -> None:
    """As where a driver hangs."""
    bar.show()
    ports.plug_in("/dev/one", active=True)
    qtbot.waitUntil(lambda: bar.activation.word == "ACTIVE")
    for age_s in (12, 15):
        ports.now_s = 1000.0 + age_s
        qtbot.waitUntil(lambda age_s=age_s: f"{age_s} s ago" in bar.activation.accessibleName())  # type: ignore[misc]


USB0, USB1 = "/dev/ttyUSB0", "/dev/ttyUSB1"


class Listener(NamedTuple):
    ports: FakePorts
    said: list[str]
    played: list[Sound]

    def heard(self, qtbot: QtBot, count: int) -> list[str]:
        """What was announced since it was last asked."""
        qtbot.waitUntil(lambda: len(self.said) >= count)
        qtbot.wait(0)  # what else waits is said now
        said = self.said.copy()
        self.said.clear()
        return said


@pytest.fixture
def listener(qtbot: QtBot, ports: FakePorts, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Iterator[Listener]:
    window = QWidget()
    qtbot.addWidget(window)
    window.show()
    announcer, played = StateAnnouncer(ports.ports, Preferences(tmp_path / "window.ini")), list[Sound]()
    monkeypatch.setattr(announcer, "play", played.append)
    yield Listener(ports, announced(monkeypatch), played)
    window.close()


def test_with_several_ports_a_word_and_a_sound_are_of_the_one(qtbot: QtBot, listener: Listener) -> None:
    _, first = listener.ports.plug_in(USB0)
    _, second = listener.ports.plug_in(USB1, active=True)
    assert listener.heard(qtbot, 2)[-1] == f"{USB1}: ACTIVE"
    first.unplug()  # it was locked, whatever the other one is
    listener.heard(qtbot, 1)
    assert listener.played == [Sound.ACTIVE]
    second.say(active=True, triggered=True)
    listener.heard(qtbot, 1)
    second.unplug()
    listener.heard(qtbot, 1)
    assert listener.played == [Sound.ACTIVE, Sound.TRIGGERED, Sound.LOST_WHILE_ACTIVE]


@pytest.mark.promise("j")
def test_each_state_is_told_once_when_it_becomes_so(qtbot: QtBot, listener: Listener) -> None:
    _, module = listener.ports.plug_in(USB0)
    assert listener.heard(qtbot, 1) == ["LOCKED"]
    module.say(active=True)
    assert listener.heard(qtbot, 1) == ["ACTIVE"]
    for second in range(1, 31):  # values and ages change all the time
        listener.ports.now_s += 1
        module.say(active=True, triggered=False, tilt_deg=second, cell_voltage_v=4 - second / 100, light_v=0.1)
    module.say(triggered=True)
    assert listener.heard(qtbot, 1) == ["TRIGGERED!"]
    module.say(triggered=True, active=False)
    assert listener.heard(qtbot, 1) == ["LOCKED"]


@pytest.mark.promise("j")
def test_a_lost_link_is_told_with_what_it_means_and_the_state_again_afterwards(
    qtbot: QtBot, listener: Listener
) -> None:
    connection, module = listener.ports.plug_in(USB0, active=True)
    assert listener.heard(qtbot, 1) == ["ACTIVE"]
    module.unplug()
    (lost,) = listener.heard(qtbot, 1)
    assert lost.endswith(f"treat it as ready to fire. {keep_away()}!")
    connection.connect_to(connection.target)  # type: ignore[arg-type]
    module.say(active=True, triggered=True)
    assert listener.heard(qtbot, 2) == ["TRIGGERED!", "ACTIVE"]
    connection.treat_as_another()
    module.begin(active=True, triggered=True)
    assert listener.heard(qtbot, 2) == ["TRIGGERED!", "ACTIVE"], "another module, of which all is told again"


@pytest.mark.promise("f")
def test_a_doubt_belongs_to_its_adapter(ports: FakePorts, bar: TopBar) -> None:
    port, module = ports.plug_in(USB0, active=True)
    QApplication.processEvents()
    module.end(EndReason.RESTARTED)
    QApplication.processEvents()
    for device, word in ((USB0, "may have fired"), (USB1, "NOT TRIGGERED"), (USB0, "may have fired")):
        port.connect_to(Target(device, 115200))
        module.begin(**VALUES)
        QApplication.processEvents()
        bar.refresh()
        assert bar.trigger.word == word, device


@pytest.mark.promise("a")
def test_neither_a_name_nor_a_shutdown_is_said_of_another_adapter(qtbot: QtBot, ports: FakePorts) -> None:
    port, module = ports.plug_in(USB0)
    qtbot.waitUntil(lambda: port.module.is_going)
    port.module.say_name("M-07")
    port.note_shutdown()
    module.end(EndReason.SILENT)
    module.hand_over()
    qtbot.waitUntil(lambda: port.last_name == "M-07")
    for device, name in ((USB0, "M-07"), (USB1, "")):
        port.connect_to(Target(device, 115200))
        assert (port.last_name, port.switched_off_at is not None) == (name, bool(name)), device


def player(folder: Path, name: str, *, code: int) -> Path:
    """A program that notes what it is to play."""
    played = folder / f"{name}.txt"
    program = folder / name
    program.write_text(f'#!/bin/sh\necho "$@" >> {played}\nexit {code}\n', encoding="utf-8")
    program.chmod(0o755)
    return played


@pytest.mark.skipif(sys.platform == "win32", reason="the players are scripts")
def test_a_chosen_sound_is_played_by_the_first_player_that_works(
    qtbot: QtBot, ports: FakePorts, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    beeps: list[bool] = []
    monkeypatch.setattr(QApplication, "beep", lambda: beeps.append(True))
    preferences = Preferences(tmp_path / "window.ini")
    sounds = StateAnnouncer(ports.ports, preferences)
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


def test_notices_after_a_trigger_and_a_restart(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with (
        simulated("next", active=True) as bench,
        window(qapp, tmp_path, entries=page_entries("triggers", "preflight")) as assembly,
    ):
        main = assembly.window
        connect(qtbot, assembly, "sim://next")
        main.go_to("preflight")
        bench.pulse_pwm()
        qtbot.waitUntil(lambda: main.notice_bar.button("after_trigger") is not None)
        notice = given(main.notice_bar.notice)
        assert notice.meaning is Meaning.DANGER
        notice.choices[0].act()
        assert main.navigation.chosen == "triggers"
        assert main.notice_bar.button("after_trigger") is None  # it leads to the page that is shown
        given(notice.dismiss)()
        assert main.notice_bar.notice is None  # it was read; the top bar still says TRIGGERED
        port = assembly.ports.current
        qtbot.waitUntil(lambda: port.module.is_read)
        main.go_to("preflight")
        bench.restart()
        qtbot.waitUntil(lambda: "reported TRIGGERED before" in notice_text(main.notice_bar))
        notice = given(main.notice_bar.notice)
        assert notice.meaning is Meaning.DANGER
        given(notice.dismiss)()
        qtbot.waitUntil(lambda: given(main.notice_bar.notice).cause == "interruptions")  # once it answers again
        assert "The module restarted." in notice_text(main.notice_bar)
        given(given(main.notice_bar.notice).dismiss)()
        assert main.notice_bar.notice is None


def test_a_notice_that_was_closed_comes_again_with_its_cause(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with fake_window(qapp, tmp_path) as (ports, assembly):
        bar = assembly.window.notice_bar
        _port, worker = ports.plug_in("ttyUSB0")
        for is_triggered in (True, False, True):
            worker.say(triggered=is_triggered)
            QApplication.processEvents()
            qtbot.waitUntil(lambda wanted=is_triggered: ("has triggered" in notice_text(bar)) is wanted)  # type: ignore[misc]
            if is_triggered:
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


@pytest.mark.promise("l")
def test_lock_first_locks_every_module_and_closing_asks_while_that_is_not_reported(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path
) -> None:
    with fake_window(qapp, tmp_path) as (ports, assembly):
        active = [ports.plug_in(name, active=True) for name in ("ttyUSB0", "ttyUSB1")]
        qtbot.waitUntil(lambda: all(port.is_active for port, _worker in active))
        assembly.window.close()
        given(assembly.window.notice_bar.button("lock_and_leave")).click()
        assert [port.lock.is_repeating for port, _worker in active] == [True, True]
        assembly.window.leaving.stay()
        for _port, worker in active:
            worker.say(active=False)  # as before LOCK: it is not the answer
        QApplication.processEvents()
        assembly.window.close()
        assert assembly.window.isVisible()
        assert "it does not report LOCKED" in notice_text(assembly.window.notice_bar)
