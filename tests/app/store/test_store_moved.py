"""A store that is removed, moved or replaced while the program has it open: nothing that was noted is lost."""

import shutil
import sys
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import pytest
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from app.safety.acts import Act
from app.safety.journal import Outcome
from app.store.copies import copies_of, copy_store
from app.store.database import FILE_NAME, StoreFault, StoreTrouble, utc_now
from app.store.store import Store, open_store
from tests.support.window.fakes_ui import window

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="Windows keeps a file in its place while it is open")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return tmp_path / "data"


def names(store: Store) -> set[str]:
    return {module.name for module in store.modules()}


def kept(folder: Path) -> set[str]:
    with closing(open_store(folder)) as store:
        assert store.database.notice is None
        assert store.facts.faults() == []
        return names(store)


def remove(path: Path) -> None:
    path.unlink()


def remove_all(path: Path) -> None:
    for file in path.parent.glob(f"{path.name}*"):
        file.unlink()


def remove_log(path: Path) -> None:
    path.with_name(f"{path.name}-wal").unlink()


def remove_index(path: Path) -> None:
    path.with_name(f"{path.name}-shm").unlink()


def move_folder(path: Path) -> None:
    path.parent.rename(path.parent.with_name("elsewhere"))


def put_copy(path: Path) -> None:
    draft = path.with_name("draft")
    shutil.copy(copies_of(path, utc_now())[0], draft)
    draft.replace(path)


def put_half(path: Path) -> None:
    put_copy(path)
    path.write_bytes(path.read_bytes()[:9000])


def put_nothing(path: Path) -> None:
    path.unlink()
    path.touch()


MOVES = (remove, remove_all, remove_log, remove_index, move_folder, put_copy, put_half, put_nothing)


@pytest.mark.parametrize("move", MOVES)
def test_what_was_noted_before_and_after_is_there_at_the_end(folder: Path, move: Callable[[Path], None]) -> None:
    store = open_store(folder)
    store.register_module("first")
    copy_store(folder / FILE_NAME, utc_now())
    entry = store.begin(Act.LOCK, b"", {}, port="p", origin="window")
    store.register_module("before")
    move(folder / FILE_NAME)
    store.register_module("after")
    store.settle(entry, Outcome.CONFIRMED, {})
    try:
        assert kept(folder) == {"first", "before", "after"}
        assert [(entry.act, entry.outcome) for entry in store.audit()] == [(Act.LOCK, Outcome.CONFIRMED)]
    finally:
        store.close()
    assert kept(folder) == {"first", "before", "after"}


@pytest.mark.parametrize("move", MOVES)
@pytest.mark.parametrize("use", [Store.close, lambda store: store.database.keep_in_place()])
def test_it_is_there_again_although_nothing_more_is_noted(
    folder: Path, move: Callable[[Path], None], use: Callable[[Store], object]
) -> None:
    with closing(open_store(folder)) as store:
        store.register_module("first")
        copy_store(folder / FILE_NAME, utc_now())
        store.register_module("before")
        move(folder / FILE_NAME)
        use(store)
        assert kept(folder) == {"first", "before"}


def test_two_programs_go_on_in_one_file(folder: Path) -> None:
    with closing(open_store(folder)) as one, closing(open_store(folder)) as two:
        one.register_module("before")
        remove_all(folder / FILE_NAME)
        one.register_module("one")
        two.register_module("two")
        one.register_module("one again")
        assert names(one) == names(two) == {"before", "one", "two", "one again"}
    assert kept(folder) == {"before", "one", "two", "one again"}
    assert [file.name for file in folder.iterdir() if file.is_file()] == [FILE_NAME]


def test_where_another_one_went_on_elsewhere_both_are_kept_and_the_first_says_so(folder: Path) -> None:
    path = folder / FILE_NAME
    with closing(open_store(folder)) as store:
        store.register_module("first")
        copy_store(path, utc_now())
        entry = store.begin(Act.ZERO, b"", {}, port="p", origin="window")
        remove_all(path)
        put_copy(path)
        with closing(open_store(folder)) as other_store:
            other_store.begin(Act.LOCK, b"", {}, port="p", origin="command line")
            for write in (lambda: store.register_module("after"), lambda: store.settle(entry, Outcome.CONFIRMED, {})):
                with pytest.raises(StoreTrouble) as caught:
                    write()
                assert caught.value.fault is StoreFault.FAILED
                (aside,) = folder.glob("*.aside-*.sqlite")
                assert str(aside) in caught.value.sentence
    with closing(open_store(folder)) as store:
        assert [(entry.act, entry.outcome) for entry in store.audit()] == [(Act.LOCK, Outcome.UNKNOWN)]
    (folder / "aside").mkdir()
    with closing(open_store(aside.rename(folder / "aside" / FILE_NAME).parent)) as store:
        assert [entry.act for entry in store.audit()] == [Act.ZERO]


def test_a_damaged_one_that_is_open_takes_the_place_of_no_good_one(folder: Path) -> None:
    path = folder / FILE_NAME
    with closing(open_store(folder)) as store:
        store.register_module("first")
        copy_store(path, utc_now())
        for number in range(300):
            store.begin(Act.LOCK, b"", {"n": number}, port="p" * 50, origin="window")
    with closing(open_store(folder)) as store:
        with path.open("r+b") as file:
            file.seek(4096 * 3)
            file.write(b"\xa5" * 4096 * 3)
        for connection in (store.database._connection, store.database._reading):
            connection.execute("PRAGMA shrink_memory")
        remove_all(path)
        put_copy(path)
        with closing(open_store(folder)) as other:
            other.register_module("good")
        with pytest.raises(StoreTrouble):
            store.register_module("after")
    assert kept(folder) == {"first", "good"}


def test_an_idle_window_puts_it_back(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("ui.main.PLACE_EVERY_MS", 20)
    with window(qapp, tmp_path) as assembly:
        store = assembly.storage.store
        assert isinstance(store, Store)
        store.register_module("before")
        path = store.database.path
        remove_all(path)
        qtbot.waitUntil(path.exists)
        assert kept(path.parent) == {"before"}
