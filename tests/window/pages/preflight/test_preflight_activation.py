"""From READY to GO and back on the Pre-flight page, and what ends either while it stands."""

import re
from pathlib import Path

import pytest
from PySide6.QtWidgets import QAbstractButton, QApplication, QLabel, QWidget
from pytestqt.qtbot import QtBot

from app.preflight.checks import Person
from app.preflight.verdict import Verdict
from app.records.record import read_document
from app.records.verification import RecordState, verify
from app.settings.profiles import NO_PROFILE
from protocol.catalogue import LOCK
from tests.support.line.frames import at_each_frame
from tests.support.window.preflight_window import NOBODY, OnBench, kept, name_module, on_bench, press_row
from tests.support.window.steps import choosing, given, notice_text, settle
from ui.session.check import Standing
from ui.widgets.step_button import StepButton


def activate(bench: OnBench) -> None:
    """By the page's own row: ask, then confirm."""
    row = bench.preflight.activation
    bench.until(row.confirm.ask.isEnabled)
    for _ in range(10):  # a step that has just come to lie elsewhere does not count a press
        settle(row.confirm.ask)
        bench.click(row.confirm.ask)
        bench.wait(0.1)
        if row.confirm.is_asking:
            break
    settle(row.confirm.go)
    bench.click(row.confirm.go)


def counted_presses(page: QWidget) -> list[str]:
    """The buttons of the page whose presses counted, from now on."""
    pressed: list[str] = []
    for button in page.findChildren(QAbstractButton):
        counts = button.chosen if isinstance(button, StepButton) else button.clicked
        counts.connect(lambda *_, button=button: pressed.append(button.objectName()))
    return pressed


@pytest.mark.promise("f")
def test_three_presses_lead_from_ready_to_the_activation_and_to_go(rig: OnBench) -> None:
    page = rig.preflight
    pressed = counted_presses(page)
    name_module(rig, "M-07")
    assert not page.activation.isVisible()
    assert rig.check() is Standing.READY
    count = re.sub(r"\D", "", page.list.fold.text())
    assert f"Passed: {count};" in page.banner.accessibleName()  # as the list below says, warnings apart
    assert page.activation.isVisible()
    activate(rig)
    rig.wait_standing(Standing.GO)
    assert len(pressed) == 3, pressed
    assert rig.bench.module.state.is_active
    assert [act.command.name for act in rig.acts[2:]] == ["activation"]
    assert not page.activation.isVisible()
    shown = page.banner.announcement
    assert (shown.word, shown.head) == ("GO", "Fit to fly")
    signed = given(page.work.signed)
    record = signed.record
    assert record.verdict is Verdict.GO
    assert record.read["status"]["active"] is True
    assert kept(rig, "M-07") == ["GO", "READY"]
    assert verify(read_document(signed.text.encode()), NOBODY).state is RecordState.INTACT
    # Nothing on the page says of an active module that it is locked or does not fire.
    texts = [label.text() for label in page.findChildren(QLabel) if label.isVisible()]
    texts += [page.banner.accessibleName(), *(row.toolTip() for row in page.list.rows.values())]
    assert not [text for text in texts if re.search(r"does not fire|is locked|LOCKED", text)]
    rig.assembly.ports.lock.press()
    rig.wait_standing(Standing.READY)
    assert given(page.work.signed).record.read["status"]["active"] is False
    assert page.activation.isVisible()
    activate(rig)
    rig.wait_standing(Standing.GO)


def test_a_module_has_one_check_whoever_begins_it_and_each_leads_from_ready_to_go(rereads: None, rig: OnBench) -> None:
    port, page = rig.assembly.ports.current, rig.preflight
    assert rig.check() is Standing.READY
    first = rig.last
    check = port.module.begin_check(NO_PROFILE, Person(), is_enabling=True)  # as on Fleet
    assert (first.standing, page.work.standing) == (Standing.VOID, Standing.CHECKING)
    assert port.module.is_busy  # no page reads by itself beside it
    rig.until(lambda: not page.run.isEnabled())  # one at a time
    rig.until(lambda: check.standing is Standing.READY)
    assert rig.last is check
    assert check.held is not None
    assert check.held.verdict is Verdict.READY
    rig.bench.module.activate(is_active=True)
    rig.until(lambda: check.standing is Standing.GO)
    assert kept(rig) == ["GO", "READY", "READY"]
    rig.bench.module.memory.attitude_threshold = 70
    rig.until(lambda: page.work.standing is Standing.NOT_CHECKED)  # with the conversation


@pytest.mark.promise("f")
def test_where_the_module_may_have_fired_before_a_restart_there_is_no_ready(rig: OnBench) -> None:
    port, bar = rig.assembly.ports.current, rig.assembly.window.notice_bar
    rig.bench.module.activate(is_active=True)
    rig.until(lambda: port.is_active)
    rig.restart()
    assert port.firing_doubt.is_open
    assert rig.check() is Standing.NO_GO
    rig.until(lambda: "may have fired before the restart" in notice_text(bar))
    given(given(bar.notice).dismiss)()
    assert not port.firing_doubt.is_open, "the check has read the records"
    assert rig.check() is Standing.READY


def test_where_the_aircraft_activates_ready_is_the_end(tmp_path: Path, rig: OnBench) -> None:
    profile = tmp_path / "h6.toml"
    profile.write_text('[expectations]\nactivated_by = "aircraft"\n', encoding="utf-8")
    page = rig.preflight
    page.form.ask_open = choosing(profile)
    page.form.choose_file()
    assert rig.check() is Standing.READY
    assert page.banner.announcement.head == "The aircraft activates it"
    assert not page.activation.isVisible()
    rig.bench.module.activate(is_active=True)  # by the aircraft
    rig.wait_standing(Standing.GO)


def test_on_an_active_module_nothing_is_written_until_its_row_locks_it(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path
) -> None:
    with on_bench(qtbot, qapp, tmp_path, "active", "preflight", active=True) as bench:
        page = bench.preflight
        page.tick()
        assert page.enable.text() == "Lock, enable and check again"
        assert "lock it first" in page.banner.accessibleName()
        assert bench.check(is_enabling=False) is Standing.NO_GO
        assert bench.acts == []
        row = page.list.rows["attitude_trigger"]
        assert "Lock it" in row.reason.text()
        assert given(row.act).text() == "Lock, enable and check again"
        press_row(bench, "attitude_trigger")
        bench.until(lambda: page.work.standing is Standing.READY)
        assert set(bench.acts[:-2]) == {LOCK}


@pytest.mark.parametrize("is_said_new", [False, True])
@pytest.mark.promise("f")
def test_where_the_lock_of_this_module_is_not_reported_nothing_is_enabled(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, is_said_new: bool
) -> None:
    with on_bench(qtbot, qapp, tmp_path, "stays", "preflight", active=True) as bench:
        page = bench.preflight
        bench.until(lambda: page.enable.text() == "Lock, enable and check again")
        hear_lock = at_each_frame(bench.bench, lambda request: request != LOCK)
        settle(page.enable)
        bench.click(page.enable)
        bench.wait(0.5)
        if is_said_new:  # LOCK goes on; what was to follow it was meant for another module
            bench.assembly.ports.current.treat_as_another()
            hear_lock()
            bench.until(lambda: not bench.bench.module.state.is_active)
        bench.wait(1.0)
        assert page.work.standing is Standing.NOT_CHECKED
        assert set(bench.acts) == {LOCK}


# What ends it while it stands


@pytest.fixture
def rereads(monkeypatch: pytest.MonkeyPatch) -> None:
    """What a verdict depends on, every 0.2 s."""
    monkeypatch.setattr("ui.session.check.REREAD_EVERY_S", 0.2)


@pytest.mark.promise("f")
def test_what_cannot_be_read_again_ends_it(rereads: None, rig: OnBench) -> None:
    assert rig.check() is Standing.READY
    rig.bench.change(mute_codes=frozenset((0x20,)))
    rig.wait_standing(Standing.VOID)
    assert rig.preflight.banner.announcement.head == "Not everything could be read again."
