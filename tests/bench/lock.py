"""From the press of LOCK in the window to its frame at the module, a process of its own, while the module streams: with
a store that takes everything at once, and with one that is blocked for 3 s, over and over."""

import json
import statistics
import tempfile
import threading
import time
from concurrent.futures import wait
from pathlib import Path
from typing import Final

from PySide6.QtCore import Qt
from PySide6.QtTest import QTest

from app.store.fact_store import Store
from tests.bench.figures import Figure, measured
from tests.bench.module import streaming_module
from tests.bench.window import LIMIT_S, WARM_UP_S, turn_for, turn_until, window_apart
from ui.main import WindowOptions, start

AIM_S: Final = 0.050
BLOCKED_S: Final = 3.0
PRESSES: Final = 200
BETWEEN_S: Final = 0.06
_STORES: Final = {"free": "the store free", "blocked": f"the store blocked for {BLOCKED_S:.0f} s, over and over"}


def _block(store: Store, is_over: threading.Event) -> None:
    """Holds the writing connection, like a disk that takes 3 s per commit."""
    while not is_over.is_set():
        wait([store.write(lambda _facts: is_over.wait(BLOCKED_S))])


def measure() -> dict[str, list[float]]:
    """Seconds of each press, for the free and the blocked store."""
    found: dict[str, list[float]] = {name: [] for name in _STORES}
    with tempfile.TemporaryDirectory() as folder, streaming_module(Path(folder) / "module", "rate=100") as module:
        options = WindowOptions(port=module.port, language="en")
        with window_apart(options) as (_app, assembly):
            start(assembly, options)
            button, store = assembly.window.top_bar.lock, assembly.storage.store
            opened = turn_until(lambda: button.isEnabled() and assembly.ports.current.is_open, LIMIT_S)
            assert opened, "the port did not open"
            assert isinstance(store, Store)
            turn_for(WARM_UP_S)
            for name, took_s in found.items():
                is_over = threading.Event()
                if name == "blocked":
                    threading.Thread(target=_block, args=(store, is_over), daemon=True).start()
                for _ in range(PRESSES):
                    pressed_at = time.monotonic()
                    QTest.mouseClick(button, Qt.MouseButton.LeftButton)
                    turn_for(BETWEEN_S)
                    arrived_at = module.locked_at
                    took_s.append(arrived_at - pressed_at if arrived_at >= pressed_at else LIMIT_S)
                is_over.set()
    return found


def figures() -> list[Figure]:
    """A press whose frame had not arrived after 60 ms counts as 15 s."""
    found, figures = measured("lock"), []
    for name, word in _STORES.items():
        took_s = sorted(found[name])
        median, p99, longest = (
            one * 1000 for one in (statistics.median(took_s), took_s[int(0.99 * PRESSES)], took_s[-1])
        )
        figures.append(
            Figure(
                f"press of LOCK to its frame at the module, {word} ({PRESSES} presses)",
                f"median {median:.1f} ms, 99 % {p99:.1f} ms, longest {longest:.1f} ms",
                f"99 % <= {AIM_S * 1000:.0f} ms",
                p99 <= AIM_S * 1000,
            )
        )
    return figures


if __name__ == "__main__":
    print(json.dumps(measure()))
