"""The window: leaving an ACTIVE module, languages, preferences, its place on the screen; what withdraws a question;
names that a scanner types.
"""

import json
from functools import partial
from pathlib import Path

import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QApplication, QFileDialog, QLabel
from pytestqt.qtbot import QtBot

from app.diagnosis.link_state import Phase
from app.engine.procedure import Job
from app.modules.names import remember
from app.safety.journal import Act
from app.store.fact_store import FILE_NAME
from app.system.files import data_folder
from app.trigger_records.history import TriggersReading, read_triggers
from tests.support.processes import ran_code
from tests.support.window.desk import name_module
from tests.support.window.fakes_ui import store_of, window
from tests.support.window.rig import Rig
from tests.support.window.steps import find, given, notice_text
from ui.acts.confirm import Confirm
from ui.core.preferences import Preferences
from ui.files.file_dialogs import ask_path
from ui.main import WindowOptions
from ui.session.module_field import ModuleField


@pytest.mark.promise("l")
@pytest.mark.module(active=True)
def test_leaving_an_active_module_asks_and_locks(one: Rig) -> None:
    main, bar = one.window, one.window.notice_bar
    assert not main.close()
    assert not main.close()  # the second half of a double click, or a key that is held, is no answer
    one.qtbot.keyClick(given(bar.button("lock_and_leave")), Qt.Key.Key_Escape)
    assert bar.notice is None
    assert not main.close()
    one.click(bar.button("stay"))
    assert bar.notice is None
    assert one.port.is_open
    assert not main.close()
    given(bar.notice).choices[0].act()  # LOCK first; no event is processed before it is cancelled
    main.leaving.stay()
    one.until(lambda: main.top_bar.activation.word == "LOCKED")
    one.until(lambda: not one.port.lock.is_unproven)
    assert main.isVisible()
    one.bench.module.activate(is_active=True)
    one.until(lambda: one.port.is_active)
    assert not main.close()
    given(bar.notice).choices[0].act()
    assert not main.close()  # LOCK is on its way
    one.until(lambda: not main.isVisible())
    assert not one.bench.module.state.is_active


@pytest.mark.parametrize("is_closing", [True, False])
@pytest.mark.module(active=True)
def test_an_active_module_may_be_left_as_it_is(one: Rig, is_closing: bool) -> None:
    key = Qt.Key.Key_Q if is_closing else Qt.Key.Key_D
    one.qtbot.keyClick(one.window, key, Qt.KeyboardModifier.ControlModifier)
    assert one.port.is_open
    one.click(one.window.notice_bar.button("leave_active"))
    one.until(lambda: one.port.state.phase is Phase.CLOSED or not one.window.isVisible())
    assert one.bench.module.state.is_active
    assert one.window.isVisible() is not is_closing


def test_the_title_and_qts_own_texts_are_translated(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with window(qapp, tmp_path, options=WindowOptions(language="zh_CN")) as assembly:
        assert assembly.window.windowTitle() == qapp.applicationDisplayName() == "DPS-S 上位机"
        assert qapp.translate("QPlatformTheme", "Cancel") == "取消"
        ask_path(assembly.window, "x", tmp_path / "x.csv", "x (*.csv)", bool)
        dialog = find(assembly.window, QFileDialog)
        assert {label.text() for label in dialog.findChildren(QLabel)} >= {"文件夹", "文件"}
        dialog.reject()
    with window(qapp, tmp_path, options=WindowOptions(language="en")):
        assert qapp.translate("QPlatformTheme", "Cancel") == "Cancel"


def test_a_damaged_preferences_file_is_ignored(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    (tmp_path / "window.ini").write_bytes(b"[port]\nbaud_rate=many\ndevice=@Point(1 2)\n[window]\n=\x00\xff")
    with window(qapp, tmp_path) as assembly:
        qtbot.waitUntil(assembly.window.isVisible)
    assert Preferences(tmp_path / "window.ini").theme is None


@pytest.mark.promise("f")
def test_a_damaged_store_that_was_set_aside_is_said(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    data_folder().mkdir(parents=True, exist_ok=True)
    (data_folder() / FILE_NAME).write_bytes(b"no database" * 1000)
    with window(qapp, tmp_path) as assembly:
        qtbot.waitUntil(lambda: "kept as" in notice_text(assembly.window.notice_bar))


def test_an_unattended_run_saves_a_picture(tmp_path: Path) -> None:
    code = (
        "import sys; from pathlib import Path; from ui.main import WindowOptions, run;"
        "raise SystemExit(run(WindowOptions(demo=True, offscreen_seconds=5.0, evidence=Path(sys.argv[1]))))"
    )
    assert ran_code(code, tmp_path / "e").returncode == 0
    assert (tmp_path / "e" / "live.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize("is_chosen", [False, True], ids=["the computer slept", "another module was chosen"])
def test_with_its_conversation_a_question_is_withdrawn_and_what_runs_is_cancelled(one: Rig, is_chosen: bool) -> None:
    question, armed, module = Confirm("night", ask="Zero", go="Zero now"), one.assembly.armed, one.port.module
    question.setParent(one.window)
    question.is_asking = True  # it is in no page, so a click would only bring it into sight
    armed.act = Act.DEPLOY
    ended = list[Job[TriggersReading]]()
    module.job("night").run(read_triggers(), ended.append)
    if is_chosen:
        one.assembly.ports.choose(one.assembly.ports.add())
    else:
        one.clock.now_s += 60.0
        one.until(lambda: armed.act is None)
        assert "The computer slept." in given(one.port.interruptions.last).translated()
    one.wait(1.0)
    assert (question.is_asking, armed.act, ended[0].error is not None) == (False, None, True)


@pytest.mark.promise("h")
def test_beyond_a_second_of_lag_nothing_is_shown_as_current(one: Rig) -> None:
    one.bench.change(lag_ms=600.0)
    one.until(lambda: one.port.state.phase is Phase.LATE)
    one.until(lambda: "Late" in one.window.top_bar.port.word.text())
    one.bench.change(lag_ms=0.0)
    one.until(lambda: one.port.state.phase is Phase.ONLINE)


SHOWN = """
import sys
from pathlib import Path
from PySide6.QtCore import QPoint, QRect, QSize
from PySide6.QtWidgets import QApplication
from ui.core.preferences import Preferences
from ui.main import WindowOptions, assemble
from ui.services.storage import Storage
from ui.style.theme import Choice
app = QApplication([])
folder = Path(sys.argv[1])
screen = app.primaryScreen()
for theme in ("light", "sunlight"):
    for kind in ("larger", "remembered", "first"):
        preferences = Preferences(folder / f"{kind}.ini")
        preferences.theme = theme
        assembly = assemble(app, WindowOptions(language="en"), preferences=preferences, storage=Storage(folder))
        window = assembly.window
        if kind == "larger":
            window.setMinimumSize(0, 0)
            window.setGeometry(0, 0, 3000, 2000)  # as on the large screen of the day before
            preferences = Preferences(folder / "remembered.ini")
            preferences.geometry = window.saveGeometry()
            preferences.save()
            continue
        window.show()
        app.processEvents()
        lock = window.top_bar.lock
        place = QRect(lock.mapToGlobal(QPoint()), lock.size())
        free = screen.availableGeometry()
        almost = free.adjusted(-2, -2, 2, 2)  # Qt rounds what it restores
        assert almost.contains(window.geometry()) and free.contains(place), (theme, kind, window.geometry())
        assert window.top_bar.rect().contains(lock.geometry())
        window.hide()
import os
os._exit(0)
"""


@pytest.mark.parametrize(("width", "height", "scale"), [(1024, 600, 1.0), (1920, 1080, 2.0)])
@pytest.mark.promise("l")
def test_lock_is_on_the_screen_at_every_scale(width: int, height: int, scale: float, tmp_path: Path) -> None:
    """At the first start, and where the window was larger when it was last closed."""
    screen = {"name": "test", "x": 0, "y": 0, "width": width, "height": height,
              "logicalDpi": 96, "logicalBaseDpi": 96, "dpr": 1}  # fmt: skip
    path = tmp_path / "screen.json"
    path.write_text(json.dumps({"screens": [screen]}), encoding="utf-8")
    platform = f"offscreen:configfile={path}"
    ended = ran_code(SHOWN, tmp_path, QT_QPA_PLATFORM=platform, QT_SCALE_FACTOR=f"{scale}")
    assert ended.returncode == 0, ended.stdout + ended.stderr


@pytest.mark.parametrize("known", [("M-070", "m-07"), ("M-07", "M-070")])
@pytest.mark.module("preflight")
def test_a_scanned_name_is_taken_as_it_was_typed(one: Rig, known: tuple[str, ...]) -> None:
    one.go_to("preflight")
    for number in range(len(known) + 1):
        for name in known[:number]:
            store_of(one.assembly.storage).write(partial(remember, name=name)).result()
        field = given(one.window.stack.currentWidget()).findChildren(ModuleField)[0]
        field.show_name()
        name_module(one, "M-07")
        assert (one.port.module.name, given(field.lineEdit()).text()) == ("M-07", "M-07")
        one.port.module.say_name("")
