"""What voids a verdict of the Pre-flight page, and what is never GO or READY; a module exchanged behind the same
port.
"""

from collections.abc import Callable
from functools import partial

import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QLineEdit

from app.engine.worker import Batch
from app.preflight.checks import CheckResult, Person
from app.safety.journal import REQUESTS, Act
from app.store.acts import note_triggered
from protocol.events import Sent
from tests.support.window.fakes_ui import store_of
from tests.support.window.preflight_window import OnBench, kept, name_module
from tests.support.window.screen_reader import announced
from tests.support.window.steps import given, notice_text
from ui.session.check import Standing


def type_another_name(bench: OnBench) -> None:
    edit = bench.find(QLineEdit, "preflight_who")
    edit.setFocus()
    bench.qtbot.keyClicks(edit, "Li Wei")
    bench.qtbot.keyClick(edit, Qt.Key.Key_Return)


def deploying(bench: OnBench) -> Batch:
    """A batch in which a deploy left the computer; the module says nothing of it."""
    port, request, at = bench.assembly.ports.current, REQUESTS[Act.DEPLOY], bench.clock()
    return Batch(at, port.connection, port.module.view, None, events=(Sent(request.encode(), request, 1, at),))


@pytest.mark.parametrize(
    ("act", "why"),
    [
        (lambda bench: bench.bench.unplug(), "The port was lost."),
        (lambda bench: bench.bench.set_charger(is_plugged_in=True), "Changed: Charging."),
        (
            lambda bench: bench.assembly.ports.current.bridge.batch.emit(deploying(bench)),
            "The module was told to fire, or reports TRIGGERED.",
        ),
    ],
)
def test_what_voids_a_go(act: Callable[[OnBench], None], why: str, rig: OnBench) -> None:
    page = rig.preflight
    assert rig.check() is Standing.READY, page.banner.accessibleName()
    offered = [row.act.text() for row in page.list.rows.values() if row.act is not None]
    assert offered == ["Measure", "Approve these settings"]
    act(rig)
    rig.wait_standing(Standing.VOID)
    assert all(row.act is None for row in page.list.rows.values())
    one = page.banner.announcement
    assert one.word == "VOID"
    assert one.head == why
    checked_at = f"{given(rig.last.filed).record.at:%H:%M:%S}"
    assert one.lines[-1].endswith(checked_at)  # whose results these are, also beside another module's name
    assert "GO" not in page.banner.accessibleName()
    assert not page.export.isEnabled()
    assert page.work.signed is None
    assert rig.assembly.ports.module.check is rig.last  # the card on Fleet says the same
    assert "void" in page.list.rows["tilt"].accessibleName()


@pytest.mark.promise("f")
def test_what_is_only_written_on_the_record_voids_nothing(rig: OnBench) -> None:
    """The name of the module, too: the check is judged again by what is kept under it, and the word that the module is
    new is not forgotten."""
    rig.preflight.check(Person(are_records_reviewed=True), is_enabling=True)
    rig.wait_standing(Standing.READY)
    type_another_name(rig)
    name_module(rig, "M-08")
    rig.until(lambda: rig.preflight.work.signed is not None)
    record = given(rig.preflight.work.signed).record
    assert (record.who, record.module) == ("Li Wei", "M-08")
    assert rig.preflight.work.standing is Standing.READY
    assert kept(rig, "M-08") == ["READY"]
    assert rig.last.person.are_records_reviewed
    name_module(rig, "M-09")  # now another one is meant
    rig.wait_standing(Standing.VOID)


def test_a_name_under_which_something_is_against_it_ends_ready(rig: OnBench) -> None:
    store_of(rig.assembly.storage).write(partial(note_triggered, module="M-08", port=rig.url)).result()
    assert rig.check() is Standing.READY
    name_module(rig, "M-08")
    rig.wait_standing(Standing.NO_GO)
    assert given(rig.preflight.work.assessment).result("service") is CheckResult.FAIL


@pytest.mark.promise("l")
def test_a_check_that_becomes_void_while_the_page_is_hidden_is_announced_and_stays_void(
    full_rig: OnBench, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert full_rig.check() is Standing.READY
    page, spoken = full_rig.preflight, announced(monkeypatch)
    assert full_rig.triggers.isVisible()
    full_rig.bench.set_world(bay_is_open=True)
    full_rig.until(lambda: page.work.standing is Standing.VOID)
    assert spoken == ["VOID. Changed: Light."]
    full_rig.bench.set_world(bay_is_open=False)
    full_rig.until(lambda: full_rig.assembly.ports.module.view.values["light_v"].value < 1.0)
    assert page.banner.announcement.standing is Standing.READY
    assert full_rig.preflight.banner.announcement.standing is Standing.VOID


def test_a_check_that_is_cancelled_is_void_and_not_kept(rig: OnBench) -> None:
    page = rig.preflight
    rig.click(page.run)
    rig.until(page.cancel.isVisible)
    rig.click(page.cancel)
    rig.wait_standing(Standing.VOID)
    assert page.banner.announcement.head == "It was cancelled."
    assert not page.export.isEnabled()
    assert kept(rig) == []


@pytest.mark.promise("a")
def test_a_check_that_is_interrupted_says_so_and_leaves_a_report(rig: OnBench) -> None:
    page, port = rig.preflight, rig.assembly.ports.current
    name_module(rig, "M-07")
    rig.click(page.run)
    rig.wait(1.0)
    rig.restart()
    rig.wait_standing(Standing.NOT_CHECKED)
    assert not page.export.isEnabled()
    assert kept(rig, "M-07") == []
    (report,) = [one for one in port.interruptions.remainders if one.text is not None]
    assert (report.module, given(report.text).in_english()) == ("M-07", "Pre-flight: The module restarted.")
    bar = rig.assembly.window.notice_bar
    rig.until(lambda: bar.button("name_other") is not None)
    rig.click(bar.button("name_other"))
    rig.until(lambda: "Pre-flight: The module restarted." in notice_text(bar))
    given(given(bar.notice).dismiss)()
    assert port.interruptions.remainders == ()


@pytest.mark.promise("a")
def test_a_new_check_shows_nothing_of_the_old_one(rig: OnBench) -> None:
    page = rig.preflight
    assert rig.check() is Standing.READY
    rig.bench.set_world(cell_v=3.0)
    rig.click(page.run)
    assert page.banner.announcement.word == "CHECKING"
    assert "GO" not in page.banner.accessibleName()
    assert all("checking…" in row.accessibleName() for row in page.list.rows.values())
    assert all(not row.measured.text() for row in page.list.rows.values())
    assert not page.export.isEnabled()
    rig.wait_standing(Standing.NO_GO)
