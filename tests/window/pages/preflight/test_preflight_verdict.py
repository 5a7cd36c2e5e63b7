"""From READY to GO and back on the Pre-flight page, what ends either while it stands, and what is never GO or READY."""

import re
from collections.abc import Callable
from functools import partial
from pathlib import Path

import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QAbstractButton, QLabel, QLineEdit

from app.engine.worker import Batch
from app.preflight.checks import CheckResult, Person
from app.preflight.verdict import Standing, Verdict
from app.records.record import read_document
from app.records.verification import RecordState, verify
from app.safety.journal import REQUESTS, Act
from app.settings.profiles import NO_PROFILE
from app.store.acts import note_triggered
from protocol.events import Sent
from tests.support.line.frames import lose
from tests.support.window.desk import NOBODY, kept, name_module, unfold
from tests.support.window.fakes_ui import store_of
from tests.support.window.rig import Rig
from tests.support.window.screen_reader import announced
from tests.support.window.steps import choosing, given, notice_text, settle
from ui.widgets.step_button import StepButton


def activate(bench: Rig) -> None:
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


@pytest.mark.promise("f")
def test_three_presses_lead_from_ready_to_the_activation_and_to_go(one: Rig) -> None:
    page, pressed = one.preflight, list[str]()
    for button in page.findChildren(QAbstractButton):
        counts = button.chosen if isinstance(button, StepButton) else button.clicked
        counts.connect(lambda *_, button=button: pressed.append(button.objectName()))
    name_module(one, "M-07")
    assert one.check() is Standing.READY
    count = re.sub(r"\D", "", page.list.fold.text())
    assert f"Passed: {count};" in page.banner.accessibleName()  # as the list below says, warnings apart
    assert page.activation.isVisible()
    activate(one)
    one.wait_standing(Standing.GO)
    assert len(pressed) == 3, pressed
    assert one.bench.module.state.is_active
    assert [act.command.name for act in one.acts[2:]] == ["activation"]
    assert not page.activation.isVisible()
    shown = page.banner.announcement
    assert (shown.word, shown.head) == ("GO", "Fit to fly")
    signed = given(page.signed)
    assert (signed.record.verdict, signed.record.read["status"]["active"]) == (Verdict.GO, True)
    assert kept(one, "M-07") == ["GO", "READY"]
    assert verify(read_document(signed.text.encode()), NOBODY).state is RecordState.INTACT
    # Nothing on the page says of an active module that it is locked or does not fire.
    texts = [label.text() for label in page.findChildren(QLabel) if label.isVisible()]
    texts += [page.banner.accessibleName(), *(row.toolTip() for row in page.list.rows.values())]
    assert not [text for text in texts if re.search(r"does not fire|is locked|LOCKED", text)]
    one.assembly.ports.lock.press()
    one.wait_standing(Standing.READY)
    assert given(page.signed).record.read["status"]["active"] is False
    activate(one)
    one.wait_standing(Standing.GO)


def test_a_module_has_one_check_whoever_begins_it_and_each_leads_from_ready_to_go(rereads: None, one: Rig) -> None:
    port, page = one.assembly.ports.current, one.preflight
    assert one.check() is Standing.READY
    first = one.port.module.check
    check = port.module.begin_check(NO_PROFILE, Person(), is_enabling=True)  # as on Fleet
    assert (given(first).state.standing, page.state.standing) == (Standing.VOID, Standing.CHECKING)
    assert port.module.is_busy  # no page reads by itself beside it
    one.until(lambda: not page.run.isEnabled())  # one at a time
    one.until(lambda: check.state.standing is Standing.READY)
    assert one.port.module.check is check
    assert check.state.verdict is Verdict.READY
    one.bench.module.activate(is_active=True)
    one.until(lambda: check.state.standing is Standing.GO)
    assert kept(one) == ["GO", "READY", "READY"]
    one.bench.module.memory.attitude_threshold = 70
    one.until(lambda: page.state.standing is Standing.NOT_CHECKED)  # with the conversation


@pytest.mark.promise("f")
def test_where_the_module_may_have_fired_before_a_restart_there_is_no_ready(one: Rig) -> None:
    port, bar = one.assembly.ports.current, one.assembly.window.notice_bar
    one.bench.module.activate(is_active=True)
    one.until(lambda: port.is_active)
    one.restart()
    assert port.firing_doubt.is_open
    assert one.check() is Standing.NO_GO
    one.until(lambda: "may have fired before the restart" in notice_text(bar))
    given(given(bar.notice).dismiss)()
    assert not port.firing_doubt.is_open, "the check has read the records"
    assert one.check() is Standing.READY


def test_where_the_aircraft_activates_ready_is_the_end(tmp_path: Path, one: Rig) -> None:
    profile = tmp_path / "h6.toml"
    profile.write_text('[expectations]\nactivated_by = "aircraft"\n', encoding="utf-8")
    page = one.preflight
    page.form.ask_open = choosing(profile)
    page.form.choose_file()
    assert one.check() is Standing.READY
    assert page.banner.announcement.head == "The aircraft activates it"
    assert not page.activation.isVisible()
    one.bench.module.activate(is_active=True)  # by the aircraft
    one.wait_standing(Standing.GO)


@pytest.mark.promise("f")
@pytest.mark.module(active=True)
def test_on_an_active_module_nothing_is_written_until_a_person_locks_it(one: Rig) -> None:
    page = one.preflight
    assert "lock it first" in page.banner.accessibleName()
    assert not page.enable.isVisible()
    assert one.check() is Standing.NO_GO
    row = page.list.rows["attitude_trigger"]
    assert "Lock it" in row.reason.text()
    assert not given(row.act).isEnabled()
    assert one.acts == []
    one.assembly.ports.lock.press()
    one.until(page.enable.isVisible)
    assert one.check() is Standing.READY


# What ends it while it stands


@pytest.fixture
def rereads(monkeypatch: pytest.MonkeyPatch) -> None:
    """What a verdict depends on, every 0.2 s."""
    monkeypatch.setattr("ui.session.check.REREAD_EVERY_S", 0.2)


def deploying(bench: Rig) -> Batch:
    """A batch in which a deploy left the computer; the module says nothing of it."""
    port, request, at = bench.assembly.ports.current, REQUESTS[Act.DEPLOY], bench.clock()
    return Batch(at, port.connection, port.module.view, None, events=(Sent(request.encode(), request, 1, at),))


@pytest.mark.parametrize(
    ("act", "why"),
    [
        (lambda bench: bench.bench.unplug(), "The port was lost."),
        (lambda bench: bench.bench.set_charger(is_plugged_in=True), "Changed: Charging."),
        (lambda bench: lose(bench.bench, 0x20), "Not everything could be read again."),
        (
            lambda bench: bench.assembly.ports.current.bridge.batch.emit(deploying(bench)),
            "The module was told to fire, or reports TRIGGERED.",
        ),
    ],
)
@pytest.mark.promise("f")
def test_what_voids_a_verdict(rereads: None, act: Callable[[Rig], None], why: str, one: Rig) -> None:
    page = one.preflight
    assert one.check() is Standing.READY, page.banner.accessibleName()
    offered = [row.act.text() for row in page.list.rows.values() if row.act is not None]
    assert offered == ["Measure", "Approve these settings"]
    act(one)
    one.wait_standing(Standing.VOID)
    assert all(row.act is None for row in page.list.rows.values())
    shown = page.banner.announcement
    assert (shown.word, shown.head) == ("VOID", why)
    assert shown.lines[-1].endswith(
        f"{given(given(one.port.module.check).filed).record.at:%H:%M:%S}"
    )  # whose results these are
    assert "GO" not in page.banner.accessibleName()
    assert (page.export.isEnabled(), page.signed) == (False, None)
    unfold(one)
    assert "void" in page.list.rows["tilt"].accessibleName()


@pytest.mark.promise("f")
def test_what_is_only_written_on_the_record_voids_nothing(one: Rig) -> None:
    """The name of the module, too: the check is judged again by what is kept under it, and the word that the module is
    new is not forgotten. READY ends where something is against that name."""
    store_of(one.assembly.storage).write(partial(note_triggered, module="M-10", port=one.url)).result()
    one.preflight.check(Person(are_records_reviewed=True), is_enabling=True)
    one.wait_standing(Standing.READY)
    edit = one.find(QLineEdit, "preflight_who")
    edit.setFocus()
    one.qtbot.keyClicks(edit, "Li Wei")
    one.qtbot.keyClick(edit, Qt.Key.Key_Return)
    name_module(one, "M-08")
    one.until(lambda: one.preflight.signed is not None)
    record = given(one.preflight.signed).record
    assert (record.who, record.module) == ("Li Wei", "M-08")
    assert one.preflight.state.standing is Standing.READY
    assert kept(one, "M-08") == ["READY"]
    assert given(one.port.module.check).person.are_records_reviewed
    name_module(one, "M-09")  # now another one is meant
    one.wait_standing(Standing.VOID)
    name_module(one, "")
    assert one.check() is Standing.READY
    name_module(one, "M-10")
    one.wait_standing(Standing.NO_GO)
    assert given(one.preflight.state.assessment).result("service") is CheckResult.FAIL


@pytest.mark.promise("l")
@pytest.mark.module("triggers", "preflight")
def test_a_check_that_becomes_void_while_the_page_is_hidden_is_announced_and_stays_void(
    one: Rig, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert one.check() is Standing.READY
    page, spoken = one.preflight, announced(monkeypatch)
    one.go_to("triggers")
    one.bench.set_world(bay_is_open=True)
    one.until(lambda: page.state.standing is Standing.VOID)
    assert spoken == ["VOID. Changed: Light."]
    one.bench.set_world(bay_is_open=False)
    one.until(lambda: one.assembly.ports.module.view.values["light_v"].value < 1.0)
    assert page.banner.announcement.standing is Standing.READY
    one.go_to("preflight")
    assert page.banner.announcement.standing is Standing.VOID


@pytest.mark.promise("a")
def test_a_new_check_shows_nothing_of_the_old_one_and_cancelled_is_void_and_not_kept(one: Rig) -> None:
    page = one.preflight
    assert one.check() is Standing.READY
    one.click(page.run)
    assert page.banner.announcement.word == "CHECKING"
    assert "GO" not in page.banner.accessibleName()
    assert all("checking…" in row.accessibleName() for row in page.list.rows.values())
    assert all(not row.measured.text() for row in page.list.rows.values())
    assert not page.export.isEnabled()
    one.until(page.cancel.isVisible)
    one.click(page.cancel)
    one.wait_standing(Standing.VOID)
    assert page.banner.announcement.head == "It was cancelled."
    assert kept(one) == ["READY"]


@pytest.mark.promise("a")
def test_a_check_that_is_interrupted_says_so_and_leaves_a_report(one: Rig) -> None:
    page, port = one.preflight, one.assembly.ports.current
    name_module(one, "M-07")
    one.click(page.run)
    one.wait(1.0)
    one.restart()
    one.wait_standing(Standing.NOT_CHECKED)
    assert not page.export.isEnabled()
    assert kept(one, "M-07") == []
    (report,) = [report for report in port.interruptions.remainders if report.text is not None]
    assert (report.module, given(report.text).in_english()) == ("M-07", "Pre-flight: The module restarted.")
    bar = one.assembly.window.notice_bar
    one.until(lambda: bar.button("name_other") is not None)
    before = port.module.number
    one.click(bar.button("name_other"))
    one.until(lambda: port.module.number == before + 1 and port.module.is_read)  # nothing is taken for the former one's
    assert (port.module.name, bar.button("name_other")) == ("", None)
    one.until(lambda: "Pre-flight: The module restarted." in notice_text(bar))
    given(given(bar.notice).dismiss)()
    assert port.interruptions.remainders == ()
