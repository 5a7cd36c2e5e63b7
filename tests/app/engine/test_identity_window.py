"""Another module where a known one was: asked about, shown without that one's name, and sent nothing but questions; a
name that a person gave is compared with what was last read under it.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QApplication, QLineEdit, QPushButton
from pytestqt.qtbot import QtBot

from app.engine.identity import UNKNOWN, IdentityEvidence, evidence_of
from app.engine.snapshots import Snapshot
from app.engine.target import Target
from app.safety.acts import Act
from app.simulator.module import BOOT_GAP_S
from app.store.fact_store import Store
from protocol.catalogue import SERIAL_OUTPUT, Request
from protocol.link_states import Presence
from tests.app.engine.test_identity import FOUND, NOT_PROVEN, with_setting
from tests.app.engine.test_identity_of_a_name import OF_ANOTHER
from tests.support.line.odd_module import end_faults
from tests.support.records.stored import evidence_of as kept_evidence
from tests.support.records.stored import keep_evidence, modules_in, register
from tests.support.window.fakes_ui import EMPTY_PAGE
from tests.support.window.rig import Rig, on_fake_time
from tests.support.window.steps import find, press
from ui.acts.outcomes import open_conditions
from ui.pages.settings.controller import SettingsController
from ui.pages.tests.page import TestsPage as GuidedPage
from ui.services.module_field import ModuleField
from ui.services.module_name import ModuleName

NAME = "M-07"
SILENT = "The module does not answer. Check its power and cable; hold its switch for 2 s."
_BOOTED_S = 2 * BOOT_GAP_S
"""A heartbeat after the first answer would be another restart, and a decision about the module before it void."""


@dataclass
class Desk(Rig):
    """A window on a module whose stream is wanted."""

    @property
    def naming(self) -> ModuleName:
        return self.assembly.connector.current.module

    @property
    def changes(self) -> list[Request]:
        return [request for request in self.requests if not request.is_repeatable]

    @property
    def asked(self) -> str:
        notice = self.assembly.window.notice_bar.notice
        is_question = self.assembly.window.notice_bar.button("identity_same") is not None
        return notice.text if notice is not None and is_question else ""

    def know(self) -> None:
        """Named, read, and kept."""
        self.naming.choose(NAME)
        self.naming.remember_adapter()
        store = self.assembly.storage.store
        assert isinstance(store, Store)
        self.until(lambda: any(kept_evidence(store, module.name).is_complete for module in modules_in(store)))

    def answer(self, key: str) -> None:
        button = self.assembly.window.notice_bar.button(key)
        press(self.qtbot, button)

    def exchange(self, boots: int) -> None:
        """Another module is on the adapter from now on."""
        self.bench.module.memory.boot_count = boots - 1
        self.bench.restart()


@contextmanager
def connected(
    qtbot: QtBot, qapp: QApplication, folder: Path, *, boots: int = 37, threshold_deg: int = 60
) -> Iterator[Desk]:
    name = f"identity{folder.name}"
    with on_fake_time(Desk, qtbot, qapp, folder, name, EMPTY_PAGE, boots=boots, uptime=60) as one:
        one.bench.module.memory.attitude_threshold = threshold_deg
        one.assembly.connector.current.stream.is_wanted = True
        one.connect()
        yield one
        one.assembly.storage.close()


@pytest.fixture
def one(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> Iterator[Desk]:
    """On a module that is known by its name."""
    with connected(qtbot, qapp, tmp_path) as made:
        made.know()
        yield made


@pytest.mark.parametrize(("answer", "name"), [("identity_new", ""), ("identity_same", NAME)])
@pytest.mark.promise("a")
def test_another_module_that_comes_back_on_the_same_port_is_asked_about(one: Desk, answer: str, name: str) -> None:
    connector = one.assembly.connector
    whose = connector.current.adapter_key
    one.bench.unplug()
    one.until(lambda: not connector.current.is_open)
    one.exchange(12)
    one.wait(_BOOTED_S)
    one.requests.clear()
    one.bench.plug()
    one.until(lambda: "boot count 12, was 37" in one.asked)
    assert "may be another module" in one.asked
    assert one.naming.name == ""
    assert one.assembly.window.top_bar._module == ""
    assert one.changes == []
    one.answer(answer)
    one.until(lambda: one.asked == "" and connector.current.identity.is_settled)
    assert one.naming.name == name
    assert (connector.current.adapter_key == whose) is bool(name)
    one.until(lambda: one.changes == [SERIAL_OUTPUT.set(True)])


@pytest.mark.parametrize(
    ("before", "asked"), [(UNKNOWN, "M-12? Read its label."), (OF_ANOTHER, "boot count 12, was 90")]
)
def test_a_name_given_while_the_port_is_lost_is_of_the_one_that_is_plugged_in_next(
    one: Desk, before: IdentityEvidence, asked: str
) -> None:
    store, port = one.assembly.storage.store, one.assembly.connector.current
    assert isinstance(store, Store)
    register(store, "M-12")
    keep_evidence(store, "M-12", before)
    port.kept.as_found, run = Snapshot(settings={"light_threshold_v": 1.8}), port.kept.run
    one.bench.unplug()
    one.until(lambda: not port.is_open)
    one.naming.choose("M-12")
    one.exchange(12)
    one.wait(_BOOTED_S)
    one.bench.plug()
    one.until(lambda: asked in one.asked)
    assert "was 37" not in one.asked
    one.answer("identity_same")
    one.until(lambda: one.naming.name == "M-12")
    assert port.kept.as_found is None
    assert port.kept.run != run, "what it reports ends nothing that was left ACTIVE"


@pytest.mark.parametrize("answer", ["identity_new", "identity_same"])
def test_of_modules_without_names_behind_one_adapter_nothing_survives_an_absence(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path, answer: str
) -> None:
    """The usual batch: the adapter stays plugged in, and each module has been started more often than the last."""
    with connected(qtbot, qapp, tmp_path, boots=5) as one:
        port = one.assembly.connector.current
        one.until(lambda: evidence_of(port.device.values, is_fresh=True).is_complete)
        first = port.kept
        port.kept.as_found = Snapshot(settings={"light_threshold_v": 1.8})
        one.bench.change(mute=True)
        one.until(lambda: port.device.presence is Presence.OFFLINE)
        one.bench.module.memory.light_threshold = 24
        one.bench.module.memory.boot_count = 6
        one.bench.restart()
        one.wait(_BOOTED_S)
        end_faults(one.bench)
        one.until(lambda: "light threshold 2.4 V, was 1.8 V" in one.asked)
        assert first.watch.changed == {}
        one.until(lambda: port.device.fresh("light_threshold_v", one.clock()) == 2.4)
        one.answer(answer)
        one.until(lambda: port.identity.is_settled)
        is_new = answer == "identity_new"
        assert (port.kept is first, port.kept.as_found is None) == (not is_new, is_new)


def test_while_none_answers_it_is_said_what_helps_and_nobody_is_asked_which_one_it_is(one: Desk) -> None:
    port, bar = one.assembly.connector.current, one.assembly.window.notice_bar
    one.bench.power_off()
    one.until(lambda: port.device.presence is Presence.OFFLINE)
    one.wait(8.0)
    assert (one.asked, bar.notice and bar.notice.text) == ("", SILENT)
    assert not port.identity.is_settled
    one.bench.press_switch()
    one.until(lambda: one.asked.startswith("M-07? Read its label."))


@pytest.mark.promise("a")
def test_another_module_is_asked_about_at_connecting_and_the_same_takes_one_press(one: Desk) -> None:
    one.assembly.connector.current.disconnect_port()
    one.until(lambda: not one.assembly.connector.current.is_open)
    one.requests.clear()
    one.connect()
    one.until(lambda: one.asked.startswith("M-07? Read its label."))
    assert (one.naming.name, one.changes) == ("", [])
    page = GuidedPage(one.assembly.window._services)
    page.setParent(one.assembly.window)
    page.show()
    assert page.known_by.text() == "module not named"
    one.answer("identity_same")
    one.until(lambda: one.naming.name == NAME and one.asked == "")
    one.until(lambda: page.known_by.text() == "M-07, confirmed by a person on this connection")
    one.assembly.connector.current.disconnect_port()
    one.until(lambda: not one.assembly.connector.current.is_open)
    one.until(lambda: page.known_by.text() == "")
    one.exchange(12)
    one.requests.clear()
    one.connect()
    one.until(lambda: "boot count 12, was 37" in one.asked)
    assert (one.naming.name, one.naming.expected_name) == ("", NAME)
    services = one.assembly.window._services
    assert NOT_PROVEN in [refusal.sentence for refusal in open_conditions(services, Act.ACTIVATE)]
    settings = SettingsController(services)
    settings.form.fill({"attitude_threshold_deg": 70})
    settings.write(is_unlocked=True)
    notice = settings.notice()
    assert notice is not None
    assert notice.text == f"Nothing was written. {NOT_PROVEN}"
    assert one.changes == []


@pytest.mark.parametrize("is_named", [True, False])
@pytest.mark.promise("a")
def test_leaving_the_empty_field_of_the_name_answers_nothing(one: Desk, is_named: bool) -> None:
    """Whoever presses "Enable triggers and check" takes the focus from the field."""
    connector = one.assembly.connector
    if not is_named:
        one.naming.choose("")
        one.until(lambda: not connector.current.identity.is_named)
    one.bench.unplug()
    one.until(lambda: not connector.current.is_open)
    one.bench.plug()
    one.until(lambda: one.asked != "" and connector.current.identity.is_for_a_person)
    asked = connector.current.identity
    field = ModuleField("module", connector)
    one.qtbot.addWidget(field)
    edit = find(field, QLineEdit)
    assert edit.text() == ""
    edit.editingFinished.emit()
    one.requests.clear()
    one.until(lambda: len(one.requests) > 5)
    assert connector.current.identity == asked
    assert one.asked != ""


def test_a_name_typed_before_it_came_in_doubt_which_module_answers_names_no_other_one(one: Desk, qtbot: QtBot) -> None:
    field = ModuleField("module", one.assembly.connector)
    qtbot.addWidget(field)
    edit = find(field, QLineEdit)
    for boots in (12, 7):  # a third one comes before a person has said which the second is
        qtbot.keyClicks(edit, "9")
        one.exchange(boots)
        asked = f"boot count {boots}, was"
        one.until(lambda asked=asked: asked in one.asked)  # type: ignore[misc]
        edit.editingFinished.emit()  # the field is left
        one.wait(0.3)
        assert (one.naming.expected_name, edit.text()) == (NAME, "")


@pytest.mark.promise("a")
def test_a_name_that_is_being_typed_is_not_taken_when_another_program_comes_to_the_front(
    one: Desk, qtbot: QtBot
) -> None:
    connector = one.assembly.connector
    field, other = ModuleField("module", connector), QLineEdit()
    for widget in (field, other):
        qtbot.addWidget(widget)
        widget.show()
    field.activateWindow()
    one.until(field.isActiveWindow)
    edit = find(field, QLineEdit)
    edit.setFocus()
    edit.clear()
    qtbot.keyClicks(edit, "M-")
    other.activateWindow()
    one.until(other.isActiveWindow)
    assert (one.naming.name, edit.text()) == (NAME, "M-")
    field.activateWindow()
    one.until(field.isActiveWindow)
    qtbot.keyClicks(edit, "08")
    qtbot.keyClick(edit, Qt.Key.Key_Return)
    assert one.naming.name == "M-08"
    for port in ("/dev/another", "/dev/third"):  # from the second on without a name
        qtbot.keyClicks(edit, "9")
        connector.connect_to(Target(port, 115200))
        assert edit.text() == "", "it was typed for the former module"


@pytest.mark.parametrize(
    "before", [OF_ANOTHER, with_setting("freefall_time_s", 2.0), FOUND], ids=["count", "set", "fits"]
)
@pytest.mark.parametrize("was_asked", [False, True])
@pytest.mark.promise("a")
def test_a_name_that_the_readings_refute_is_asked_about(
    one: Desk, before: IdentityEvidence, *, was_asked: bool
) -> None:
    """Typed for a module without a name, or as the answer to the question; nothing of the other one is overwritten."""
    store = one.assembly.storage.store
    assert isinstance(store, Store)
    register(store, "M-90")
    keep_evidence(store, "M-90", before)
    if was_asked:
        one.bench.restart()
        one.bench.module.memory.boot_count = 37
        one.until(lambda: one.asked.startswith("M-07? Read"))
    one.naming.choose("M-90")
    if before is FOUND:
        one.until(lambda: one.naming.name == "M-90" and one.asked == "")
        return
    one.until(lambda: "another module" in one.asked)
    assert one.naming.name == ""
    one.wait(0.3)
    assert kept_evidence(store, "M-90") == before
    assert "It is M-90" in [button.text() for button in one.assembly.window.notice_bar.findChildren(QPushButton)]
    one.answer("identity_same")
    one.until(lambda: one.naming.name == "M-90" and one.asked == "")


@pytest.mark.parametrize("first", ["new module", "a name that fits", "a name that does not"])
@pytest.mark.parametrize("fits", [True, False])
@pytest.mark.promise("a")
def test_of_two_names_given_in_a_row_the_last_counts(one: Desk, first: str, *, fits: bool) -> None:
    """The engine has not told of the first yet when the second is typed."""
    store = one.assembly.storage.store
    assert isinstance(store, Store)
    for name, before in (("M-90", OF_ANOTHER), ("M-37", FOUND), ("M-38", FOUND)):
        register(store, name)
        keep_evidence(store, name, before)
    last = "M-37" if fits else "M-90"
    if first == "new module":
        one.naming.treat_as_new()
    else:
        one.naming.choose("M-38" if first == "a name that fits" else "M-90")
    one.naming.choose(last)
    if fits:
        one.until(lambda: one.naming.name == last and one.assembly.connector.current.identity.is_settled)
        one.wait(0.3)
        assert (one.naming.name, one.asked) == (last, "")
    else:
        one.until(lambda: "boot count 37, was 90" in one.asked)
        assert one.naming.expected_name == last
    assert kept_evidence(store, "M-90") == OF_ANOTHER


@pytest.mark.parametrize("is_kept", [True, False])
def test_a_name_that_was_a_mistake_expects_what_it_did_before(one: Desk, is_kept: bool) -> None:
    store, other = one.assembly.storage.store, "M-08"
    assert isinstance(store, Store)
    before = IdentityEvidence(5, kept_evidence(store, NAME).settings) if is_kept else UNKNOWN
    if is_kept:
        register(store, other)
        keep_evidence(store, other, before)
    one.naming.choose(other)
    one.wait(2.0)
    assert one.naming.name == other
    one.naming.choose(NAME)
    one.wait(2.0)
    assert (one.naming.name, one.naming._evidence_of(other), kept_evidence(store, other)) == (NAME, before, before)


def test_what_a_command_read_of_it_since_is_what_is_expected(one: Desk) -> None:
    """Its threshold was written and checked by dps-s meanwhile, and was asked about as another module's."""
    store, port = one.assembly.storage.store, one.assembly.connector.current
    assert isinstance(store, Store)
    one.until(lambda: one.naming._stored.get(NAME, UNKNOWN).is_complete)
    port.disconnect_port()
    one.until(lambda: not port.is_open)
    one.bench.module.memory.attitude_threshold = 65
    keep_evidence(store, NAME, with_setting("attitude_threshold_deg", 65))
    one.connect()
    one.until(lambda: one.asked != "")
    assert one.asked.startswith("M-07? Read its label.")


def test_it_is_known_again_in_the_next_session(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with connected(qtbot, qapp, tmp_path) as first:
        first.know()
    with connected(qtbot, qapp, tmp_path) as second:
        second.until(lambda: second.asked.startswith("M-07? Read its label."))
        assert second.naming.name == ""
        second.answer("identity_same")
        second.until(lambda: second.naming.name == NAME)
    with connected(qtbot, qapp, tmp_path, threshold_deg=85) as third:
        third.until(lambda: "attitude threshold 85°, was 60°" in third.asked)
        assert third.naming.name == ""
        third.naming.choose("M-08")
        third.until(lambda: third.naming.name == "M-08" and third.asked == "")
