"""The storage of the pages: opened once, and closed for good."""

import threading
from pathlib import Path

import pytest

from app.engine.snapshots import Snapshot
from app.store.database import StoreTrouble
from app.store.store import Store, open_store
from ui.services import storage as storage_module
from ui.services.storage import Storage

SNAPSHOT = Snapshot(settings={"attitude_threshold_deg": 60})


def test_a_closed_storage_opens_no_store_again(tmp_path: Path) -> None:
    """Work that is under way while the window closes would open it, and nobody would close it."""
    storage = Storage(tmp_path)
    store = storage.store
    assert isinstance(store, Store)
    kept = storage.store_snapshot(SNAPSHOT, "/dev/ttyUSB0")
    assert kept is not None
    storage.close()
    assert kept.result(0) > 0
    assert isinstance(storage.store, StoreTrouble)
    assert storage.store_snapshot(SNAPSHOT, "/dev/ttyUSB0") is None
    assert not isinstance(storage.store, Store)
    storage.close()


def test_a_store_that_is_opened_while_the_storage_closes_is_closed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    is_opening, may_open = threading.Event(), threading.Event()
    opened: list[Store] = []

    def slowly(folder: Path | None) -> Store:
        is_opening.set()
        assert may_open.wait(10)
        opened.append(open_store(folder))
        return opened[-1]

    monkeypatch.setattr(storage_module, "open_store", slowly)
    storage = Storage(tmp_path)
    found: list[Store | StoreTrouble] = []
    thread = threading.Thread(target=lambda: found.append(storage.open_store()))
    thread.start()
    assert is_opening.wait(10)
    storage.close()
    may_open.set()
    thread.join(10)
    (trouble,) = found
    assert isinstance(trouble, StoreTrouble)
    with pytest.raises(StoreTrouble):
        opened[0].modules()
