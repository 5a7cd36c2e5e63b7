"""What every test gets: no screen, no files of the user's, English, and no thread left behind."""

import gc
import os
import signal
import sys
import threading
from collections.abc import Generator, Iterator
from itertools import count
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING, Final

# Qt reads these once, when it is loaded or when the application object is made.
os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
if os.environ.get("LC_ALL") in ("C", "POSIX"):
    os.environ["LC_ALL"] = "C.UTF-8"  # else Qt warns, and Qt's warnings are failures

import pytest
from hypothesis import HealthCheck, settings
from hypothesis.database import DirectoryBasedExampleDatabase
from pytestqt.qtbot import QtBot

from app.text import i18n
from tests.support.patience import PATIENCE_S

if TYPE_CHECKING:
    from PySide6.QtWidgets import QApplication

LEAK_GRACE_S = PATIENCE_S
_CHINESE_FONTS = (
    "/usr/share/fonts/truetype/wqy/wqy-microhei.ttc",
    "/System/Library/Fonts/PingFang.ttc",
    "C:/Windows/Fonts/msyh.ttc",
    "C:/Windows/Fonts/simsun.ttc",
)

if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    # A run that was begun in the background ignores Ctrl-C, and so would what a test starts and interrupts.
    signal.signal(signal.SIGINT, signal.default_int_handler)

# What a test waits for comes late on a busy machine.
for wait in QtBot.waitUntil, QtBot.waitSignal:
    (wait.__kwdefaults__ or {})["timeout"] = round(PATIENCE_S * 1000)

# New examples each time, and first those that failed once. How long one takes depends on what else the machine does;
# each example may write into the same folder as the one before.
KEPT = DirectoryBasedExampleDatabase(Path(__file__).parent.parent / "build" / "hypothesis")
UNCHECKED = (HealthCheck.too_slow, HealthCheck.function_scoped_fixture)
settings.register_profile(
    "quick", max_examples=50, deadline=None, database=KEPT, suppress_health_check=UNCHECKED, print_blob=True
)
settings.register_profile("thorough", settings.get_profile("quick"), max_examples=2000)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "quick"))


def leaked_threads(before: set[threading.Thread], grace_s: float) -> list[threading.Thread]:
    """The threads that were not there before and are still running after they had ``grace_s`` to end.

    Threads that Python did not start (Qt's own) are left out: Python can neither join nor watch them.
    """
    deadline = monotonic() + grace_s
    leaked = []
    for thread in set(threading.enumerate()) - before:
        if not isinstance(thread, threading._DummyThread):
            thread.join(max(0.0, deadline - monotonic()))
            if thread.is_alive():
                leaked.append(thread)
    return leaked


SLOW: Final = ("campaigns", "cli", "documents", "files/archive", "files/recordings", "module", "system", "window")
"""Folders below tests/ whose tests open windows, start processes or install."""


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    for item in items:
        if item.path.relative_to(Path(__file__).parent).as_posix().startswith(SLOW):
            item.add_marker("slow")


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Generator[None, object, object]:
    """Without looking for garbage, which there is little of: it took an eighth of the time. What is loaded stays."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.freeze()
        gc.enable()


@pytest.fixture(autouse=True)
def nothing_is_left_behind(request: pytest.FixtureRequest) -> Iterator[None]:
    """Each test begins in English and leaves no thread, daemon or not, and nothing of a window to the next: no key or
    button down, the pointer elsewhere, another clock of gestures, a style, a theme or a size of text.

    Qt's objects may only be freed in the thread where they live: not in that of a later test's worker. What is there
    when a test begins is passed over from then on, since going through all that is loaded takes 0.1 s.

    One fixture, since each that every test has takes a second of the run.
    """
    threads = set(threading.enumerate())
    i18n.set_language(i18n.ENGLISH)
    gc.disable()
    if has_window := "qapp" in request.fixturenames:
        application: QApplication = request.getfixturevalue("qapp")
        font, palette = application.font(), application.palette()
        gc.collect()  # pytest has let go of the fixtures of the test before
        gc.freeze()
    yield
    i18n.set_language(i18n.ENGLISH)
    if has_window:
        from PySide6.QtCore import QCoreApplication, QEvent

        from tests.support.window.steps import release_input
        from ui.style.theme import LIGHT, use, zoom

        release_input()
        use(LIGHT)
        zoom(100)
        application.setStyleSheet("")
        request.node.funcargs.clear()  # frozen since the collection, and so would be what it holds
        if application.font() != font:
            application.setFont(font)
            application.setPalette(palette)
        # Otherwise a closed window lives until an event loop runs, and each new style sheet is applied to it, too.
        QCoreApplication.sendPostedEvents(None, QEvent.Type.DeferredDelete)
        gc.collect()
    gc.enable()
    if leaked := leaked_threads(threads, LEAK_GRACE_S):
        names = ", ".join(f"{one.name}{' (daemon)' if one.daemon else ''}" for one in leaked)
        pytest.fail(f"threads still running after the test: {names}", pytrace=False)


@pytest.fixture
def spoken(request: pytest.FixtureRequest) -> str:
    """The language of all that is made after it: to be asked for before a window, and parametrised."""
    i18n.set_language(request.param)
    return str(request.param)


@pytest.fixture(scope="session")
def _homes(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """One folder per test is taken from here; none is made before a test writes into it."""
    return (tmp_path_factory.getbasetemp() / "homes" / str(number) for number in count(1))


@pytest.fixture(autouse=True)
def user_files(_homes: Iterator[Path], monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder that stands for the user's home; settings, data and caches of the test go below it."""
    home = next(_homes)
    monkeypatch.setenv("HOME", str(home))
    for variable in ("CONFIG", "DATA", "STATE", "CACHE"):
        monkeypatch.setenv(f"XDG_{variable}_HOME", str(home / variable.lower()))
    for variable in ("APPDATA", "LOCAL_APPDATA", "COMMON_APPDATA", "PERSONAL") if sys.platform == "win32" else ():
        monkeypatch.setenv(f"WIN_PD_OVERRIDE_{variable}", str(home / variable.lower()))
    return home


@pytest.fixture(scope="session", autouse=True)
def _runtime_folder(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """A private runtime folder, because Qt warns about a missing or shared one."""
    with pytest.MonkeyPatch.context() as patch:
        folder = tmp_path_factory.mktemp("runtime")
        folder.chmod(0o700)
        patch.setenv("XDG_RUNTIME_DIR", str(folder))
        yield


@pytest.fixture(scope="session")
def qapp(qapp: "QApplication") -> "QApplication":
    """pytest-qt's application object, away from the user's files, with a font for Chinese where there is one."""
    from PySide6.QtCore import QStandardPaths
    from PySide6.QtGui import QFontDatabase

    QStandardPaths.setTestModeEnabled(True)
    if not QFontDatabase.families(QFontDatabase.WritingSystem.SimplifiedChinese):
        for font in _CHINESE_FONTS:
            if Path(font).exists() and QFontDatabase.addApplicationFont(font) >= 0:
                break
    return qapp


@pytest.fixture(scope="session")
def qapp_args() -> list[str]:
    return [sys.argv[0]]
