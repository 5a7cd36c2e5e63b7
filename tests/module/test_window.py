"""The window at the independent module, whose log and state are the judge.

One truth on all pages: after everything that happens to a module, whoever did it, no place in the window says of it
what it does not hold, and no two places disagree. Old and unknown are always allowed, but not for long.
"""

import sys
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from app.diagnosis.link_state import Phase
from app.engine.transport import PortError, PortErrorKind
from app.engine.worker import Batch
from app.preflight.verdict import Standing
from app.safety.journal import Act
from tests.module.line import Line, now
from tests.module.module import ACTIVATION, ACTIVE, ATTITUDE_OFF, BAUD, BY_PWM, FREEFALL_OFF, STATUS, Module
from tests.module.wire import Question
from tests.support.line.module_line import ModuleLine
from tests.support.window.fakes_ui import connect, page_entries, wait_for_disk, window
from tests.support.window.rig import Rig, on_fake_time
from tests.support.window.steps import given, press
from ui.pages.commands.page import CommandsPage
from ui.pages.fleet.board import MODULE, STATE, TRIGGERS_CELL, VERDICT
from ui.pages.fleet.page import FleetPage
from ui.pages.live.page import LivePage
from ui.pages.preflight.page import PreflightPage
from ui.pages.settings.page import SettingsPage
from ui.services.page import Page
from ui.widgets.notices import Notice
from ui.widgets.readout import Freshness

PORT = "/dev/ttyUSB8"
PAGES: dict[str, type[Page]] = {
    "live": LivePage,
    "settings": SettingsPage,
    "preflight": PreflightPage,
    "commands": CommandsPage,
    "fleet": FleetPage,
}
SETTINGS = {
    "light_threshold_v": (0x15, "{:.1f} V", 10),
    "attitude_threshold_deg": (0x20, "{:.0f}°", 1),
    "freefall_acceleration_g": (0x21, "{:.1f} g", 10),
    "freefall_time_s": (0x22, "{:.2f} s", 100),
}
FLAGS = {"attitude_trigger": ATTITUDE_OFF, "freefall_trigger": FREEFALL_OFF}


class Said(NamedTuple):
    """`word`: None where the place says that it does not know, or how old it is."""

    place: str
    subject: str
    word: str | None


@dataclass
class Desk(Rig):
    """A window, and a module at `PORT`; `key` is the page that is in sight."""

    key: str = "live"

    @cached_property
    def pages(self) -> dict[str, Page]:
        return {key: self.find(kind) for key, kind in PAGES.items()}

    @property
    def line(self) -> ModuleLine:
        """The last one that was opened to `PORT`."""
        return next(line for line in reversed(self.lines) if isinstance(line, ModuleLine) and line.port == PORT)

    @property
    def module(self) -> Module:
        return self.line.modules[0]

    def go_to(self, key: str) -> None:
        self.key = key
        super().go_to(key)

    def until_true(self, *known: str) -> None:
        """The page in sight and the top bar tell the truth soon. `known`: subjects of
        which the top bar has to say more than that it does not know."""
        self.until(lambda: not self.wrong(known), 4.0)

    def walk(self, *known: str) -> None:
        """The same on the page in sight, and then on every other one."""
        for key in (self.key, *PAGES):
            self.go_to(key)
            self.until_true(*known)

    def bar(self, subject: str) -> str | None:
        return dict(self._bar())[subject]

    def notices(self, part: str) -> list[Notice]:
        return [one for one in self.assembly.window.notice_bar.notices if part in one.text]

    def wrong(self, known: tuple[str, ...] = ()) -> list[str]:
        said, truth = self.said(), self.truth()
        wrong = [
            f"{one.place}: {one.subject} {one.word}, not {truth[one.subject]}"
            for one in said
            if one.word is not None and one.word != truth[one.subject]
        ]
        return wrong + [f"bar: {subject} is not known" for subject in known if self.bar(subject) is None]

    # What the module holds

    def truth(self) -> dict[str, str]:
        module, settings = self.module, self.module.settings
        port = self.assembly.ports.current
        is_tilt_off, is_fall_off = settings[ATTITUDE_OFF] == 1, settings[FREEFALL_OFF] == 1
        flags = {(False, False): "both on", (True, False): "tilt off", (False, True): "fall off"}
        truth = {
            "active": "ACTIVE" if settings[ACTIVATION] else "LOCKED",
            "triggered": "TRIGGERED" if module.triggered else "NOT TRIGGERED",
            "flags": flags.get((is_tilt_off, is_fall_off), "both off"),
            "attitude_trigger": "Disabled" if is_tilt_off else "Enabled",
            "freefall_trigger": "Disabled" if is_fall_off else "Enabled",
            "cell": f"{module.readings.cell * 0.02:.2f} V",
            "name": port.module.name,
            "verdict": port.module.check_state.standing.value,
        }
        if port.module.may_have_fired and not module.triggered:
            truth["triggered"] = "may have fired"
        return truth | {key: text.format(settings[code] / per) for key, (code, text, per) in SETTINGS.items()}

    # What the window says

    def said(self) -> list[Said]:
        told = {"live": _live, "settings": _settings, "preflight": _preflight, "commands": _commands, "fleet": _fleet}
        on_page: Iterator[tuple[str, str | None]] = told[self.key](self.pages[self.key])  # type: ignore[operator]
        said = [Said(self.key, subject, word) for subject, word in on_page]
        return said + [Said("bar", subject, word) for subject, word in self._bar()]

    def _bar(self) -> Iterator[tuple[str, str | None]]:
        bar = self.assembly.window.top_bar
        for subject, chip in (
            ("active", bar.activation),
            ("triggered", bar.trigger),
            ("flags", bar.triggers),
            ("cell", bar.cell),
        ):
            is_known = chip.word not in ("unknown", "not known") and not chip.stale_age
            yield subject, chip.word.partition(",")[0] if is_known else None
        # Of a module without a name the title is that of the port, which then is not in the line below.
        yield "name", bar.port.title.text() if " · " in bar.port.word.text() else ""


def _live(page: LivePage) -> Iterator[tuple[str, str | None]]:
    if page.is_empty:
        return
    panel = page.panel
    cell = panel.cell
    yield "cell", f"{cell.text} V" if cell.freshness is Freshness.FRESH else None
    for readout, subject in ((panel.tilt, "attitude_trigger"), (panel.acceleration, "freefall_trigger")):
        if readout.freshness is Freshness.FRESH:
            words = {"trigger off": "Disabled", "trigger not known": None, "": "Enabled"}
            yield subject, words.get(readout.note)
    if panel.tilt.freshness is Freshness.FRESH and page.module.is_read:
        yield "attitude_threshold_deg", panel.tilt._limit or None
        yield "light_threshold_v", panel.light._limit or None


def _settings(page: SettingsPage) -> Iterator[tuple[str, str | None]]:
    for key in (*SETTINGS, *FLAGS):
        row = page.rows[key]
        is_old = row.held.value.property("role") == "muted"
        yield key, None if is_old else row.held.value.text().replace("\xa0", " ")


def _preflight(page: PreflightPage) -> Iterator[tuple[str, str | None]]:
    shown = page.banner.announcement
    yield "verdict", shown.standing.value
    yield "name", page.form.name_field.currentText()
    if "The module is ACTIVE: lock it first." in shown.lines:
        yield "active", "ACTIVE"


def _commands(page: CommandsPage) -> Iterator[tuple[str, str | None]]:
    words = {"Ready to fire: lock it before you touch it.": "ACTIVE", "The module is LOCKED.": "LOCKED"}
    yield "active", words.get(page.meaning.text())
    beside, _, word = page.acts[Act.ACTIVATE].live.text().partition(": ")
    yield "verdict", "void" if beside == "Check again" else word.partition(",")[0].rstrip("…")


def _fleet(page: FleetPage) -> Iterator[tuple[str, str | None]]:
    board = page.board
    if board.rowCount() == 0:
        return
    cells = {
        column: given(board.item(0, column)).text().split("\n") for column in (MODULE, STATE, TRIGGERS_CELL, VERDICT)
    }
    name = cells[MODULE][0].partition(" (")[0]
    yield "name", "" if name == "Unnamed" else name
    is_old = len(cells[STATE]) > 2
    active, triggered = cells[STATE][:2]
    yield "active", None if is_old or active not in ("ACTIVE", "LOCKED") else active
    yield "triggered", None if is_old or triggered.startswith("Trigger:") else triggered.partition(" before")[0]
    flags, cell = cells[TRIGGERS_CELL][:2]
    yield "flags", None if flags == "not known" else flags
    yield "cell", None if cell == "unknown" else cell
    word = cells[VERDICT][0]
    yield "verdict", word


@pytest.fixture
def desk(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> Iterator[Desk]:
    with on_fake_time(Desk, qtbot, qapp, tmp_path, "unused", page_entries(*PAGES)) as desk:
        desk.window.resize(1024, 600)
        desk.plug_in(PORT)
        yield desk


def test_a_module_that_may_have_fired_before_its_restart(desk: Desk) -> None:
    """Until its records were read and a person has closed the notice; and no longer, although nothing else changes."""
    port = desk.assembly.ports.current
    desk.go_to("fleet")
    desk.module.settings[ACTIVATION] = 1
    desk.until_true("active")
    desk.module.restart(desk.clock())
    desk.until(lambda: port.module.may_have_fired and port.module.is_read)
    desk.until_true("active", "triggered")
    desk.module.trigger(desk.clock(), BY_PWM)
    desk.until_true("triggered")
    assert desk.bar("triggered") == "TRIGGERED"
    desk.module.triggered = False
    port.module.triggers.read()
    for notice in desk.notices("may have fired"):
        given(notice.dismiss)()
    desk.until(lambda: not port.module.may_have_fired)
    desk.until_true("triggered")


def test_another_name_is_not_taken_before_what_speaks_against_it_was_shown(desk: Desk) -> None:
    """Also where it has a name already."""
    ports = desk.assembly.ports
    ports.module.name_it("M-01")
    before, other = ports.module.number, Module(now=desk.clock())
    other.readings.boots = 200
    desk.line.move(other, 0.0, is_announced=False)
    desk.until(lambda: ports.module.number > before and ports.module.is_read)
    ports.module.name_it("M-02")
    ports.module.name_it("M-01")
    assert ports.module.name == "M-02"
    desk.until(lambda: desk.notices("M-01"))
    desk.until_true()
    ports.module.name_it("M-01")
    assert ports.module.name == "M-01"
    ports.module.name_it("")
    desk.until_true()


def test_an_activation_after_whose_frame_another_module_answers(desk: Desk) -> None:
    """The first one is left ACTIVE, wherever it is now: that the other one was locked does not end this."""
    port, page = desk.port, desk.commands
    first, other = desk.module, Module(now=desk.clock())
    other.readings.boots = 77

    def exchange(question: Question) -> None:
        if question.is_set and question.code == ACTIVATION:
            first.at_frame = None
            desk.line.modules = (other,)

    first.at_frame = exchange
    desk.go_to("commands")
    confirm = page.acts[Act.ACTIVATE].confirm
    desk.until(confirm.ask.isEnabled)
    press(desk.qtbot, confirm.ask)
    press(desk.qtbot, confirm.go)
    desk.until(lambda: other.log.sets(ACTIVATION) and port.module.is_read)
    desk.until(lambda: not port.lock.is_owed and desk.notices("LOCK not confirmed on"))
    desk.until_true("active")
    assert (first.settings[ACTIVATION], other.settings[ACTIVATION]) == (1, 0)
    assert len(desk.notices("Activate: Sent, not confirmed: treat the module as ACTIVE.")) == 1
    wait_for_disk(desk.assembly)
    desk.until_true("active")
    assert desk.notices("LOCK not confirmed on")


def test_lock_that_is_pressed_before_the_window_hears_of_another_module(desk: Desk) -> None:
    """The first module stays left ACTIVE: the next conversation goes on already when LOCK leaves."""
    port, first, other = desk.assembly.ports.current, desk.module, Module(now=desk.clock())
    other.readings.boots = 77
    first.settings[ACTIVATION] = 1
    desk.until_true("active")
    wait_for_disk(desk.assembly)
    (worker,) = desk.workers
    hear, held = worker._callback, list[Batch]()
    worker._callback = held.append
    desk.line.modules = (other,)
    desk.until(lambda: held and held[-1].conversation.number > port.module.number and held[-1].conversation.is_going)
    port.lock.press()
    worker._callback = hear
    for batch in held:
        hear(batch)
    desk.until(lambda: other.log.sets(ACTIVATION) and port.module.is_read and not port.lock.is_repeating)
    wait_for_disk(desk.assembly)
    desk.until_true("active")
    assert first.settings[ACTIVATION] == 1
    # What is left ACTIVE is read again in the background, behind what the journal wrote.
    desk.until(lambda: desk.notices("LOCK not confirmed on"))
    wait_for_disk(desk.assembly)
    assert desk.notices("LOCK not confirmed on")


def test_a_verdict_goes_with_the_report_of_the_activation(desk: Desk) -> None:
    """A module that is there and no longer says whether it is ACTIVE is no GO."""
    ports = desk.assembly.ports
    ports.module.name_it("M-01")
    desk.check()
    assert given(ports.module.check).state.standing is Standing.READY
    desk.go_to("fleet")
    desk.module.settings[ACTIVATION] = 1
    desk.until(lambda: given(ports.module.check).state.standing is Standing.GO)
    desk.until_true("active", "flags")
    wait_for_disk(desk.assembly)
    desk.until_true("active")
    assert not desk.notices("left ACTIVE"), "its conversation goes on"
    desk.module.options.lost_queries = {STATUS: -1, ACTIVE: -1}
    desk.module.options.stream_hz = 0
    # Where it was last heard long enough before, six questions without an answer are a silence, which ends all.
    desk.until(lambda: ports.module.check_state.standing in (Standing.VOID, Standing.NOT_CHECKED), 7.0)
    desk.until_true()


def test_on_the_way_through_everything_that_happens_to_a_module(desk: Desk) -> None:
    """Each on another page, and then the top bar agrees with all of them."""
    desk.port.module.name_it("M-01")
    desk.check()
    desk.walk("flags", "cell")
    for key, happen, known in (
        ("live", lambda module: setattr(module.readings, "charging", 1), ("cell", "flags")),
        ("preflight", lambda module: setattr(module.readings, "cell", 0xB0), ("cell",)),
        ("commands", lambda module: module.settings.update({ACTIVATION: 1}), ("active",)),
        ("settings", lambda module: module.be_silent(desk.clock(), 1.0), ()),
        ("fleet", lambda module: module.trigger(desk.clock(), BY_PWM), ("active", "triggered")),
        ("live", lambda module: module.settings.update({ACTIVATION: 0}), ("active", "triggered")),
        ("commands", lambda module: module.restart(desk.clock()), ()),
    ):
        desk.go_to(key)
        happen(desk.module)
        desk.wait(1.0)
        desk.walk(*known)
    desk.line.error = PortError(PortErrorKind.LOST, PORT, "unplugged")
    desk.until(lambda: not desk.assembly.ports.module.is_going)
    desk.walk()


# What leaves


def test_a_module_that_is_lost_with_its_baud_rate(desk: Desk) -> None:
    """It acknowledges, and answers at no rate: until all were tried, nobody is told to switch it off."""
    desk.go_to("settings")
    page, port = desk.find(SettingsPage), desk.assembly.ports.current
    page.baud.editor.setCurrentIndex(page.baud.editor.findData(9600))
    page.baud.refresh()
    desk.click(page.baud.confirm.ask)
    line, module = desk.line, desk.module

    def lose(question: Question) -> None:
        if question.code == BAUD:
            line.plan(0.011, lambda: setattr(module, "rate", 300))

    module.at_frame = lose
    desk.click(page.baud.confirm.go)
    desk.until(lambda: not desk.assembly.ports.module.is_going)
    phases, notices, tried = set(), set(), set()
    while port.is_changing_rate:
        phases.add(port.state.phase)
        tried.add(port.connection.baud_rate)
        notices |= {one.text for one in desk.assembly.window.notice_bar.notices}
        desk.turn()
    assert (phases, len(tried)) == ({Phase.FINDING}, 6)
    assert not notices, "they are about a link that is lost"
    desk.until(lambda: desk.notices("no answer at any rate"))
    desk.until(lambda: port.state.phase is Phase.OFFLINE)
    assert desk.assembly.window.notice_bar.button("find_rate") is not None
    assert len(desk.module.log.acts()) == 1


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo-terminals")
def test_lock_reaches_an_active_module_by_key(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    """In real time, on a pseudo-terminal."""
    module = Module(now=now())
    module.settings[ACTIVATION] = 1
    with Line(module) as line, window(qapp, tmp_path) as assembly:
        connect(qtbot, assembly, line.port)
        qtbot.keyClick(assembly.window, Qt.Key.Key_L, Qt.KeyboardModifier.ControlModifier)
        qtbot.waitUntil(lambda: module.settings[ACTIVATION] == 0)
    assert {entry.frame for entry in module.log.acts()} == {bytes.fromhex("42 61 10 02 00 12")}
