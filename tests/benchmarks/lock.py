"""Time from pressing LOCK in the window to its frame at the module in another process, while it streams; with a free
store and with one that is repeatedly blocked for 3 s.

    python -m tests.benchmarks.lock PRESSES

measures PRESSES presses of each and prints JSON.
"""

import json
import sys
import tempfile
import threading
import time
from contextlib import ExitStack
from pathlib import Path
from typing import Final

from PySide6.QtCore import Qt
from PySide6.QtTest import QTest

from app.store.store import Store
from tests.benchmarks.figures import Figure, quantile
from tests.benchmarks.module import streaming_module
from tests.benchmarks.runs import measured
from tests.benchmarks.window import LIMIT_S, WARM_UP_S, turn_for, turn_until, window_apart
from ui.main import WindowOptions, start

AIM_S: Final = 0.050
BLOCKED_S: Final = 3.0
PRESSES: Final = 200
BETWEEN_S: Final = 0.06


def _block(store: Store, is_over: threading.Event) -> None:
    """Holds the writing connection, like a disk that takes 3 s per commit."""
    while not is_over.is_set():
        with store.database.transaction():
            is_over.wait(BLOCKED_S)


def measure(presses: int) -> dict[str, list[float]]:
    """Seconds of each press, for the free and the blocked store."""
    found: dict[str, list[float]] = {"free": [], "blocked": []}
    with tempfile.TemporaryDirectory() as folder, ExitStack() as stack:
        module = stack.enter_context(streaming_module(Path(folder) / "module", "rate=100"))
        options = WindowOptions(port=module.port, language="en")
        _app, assembly = stack.enter_context(window_apart(options))
        start(assembly, options)
        button = assembly.window.top_bar.lock
        if not turn_until(lambda: button.isEnabled() and assembly.connector.current.is_open, LIMIT_S):
            raise RuntimeError("the port did not open")
        turn_for(WARM_UP_S)
        store = assembly.storage.store
        if not isinstance(store, Store):
            raise RuntimeError("there is no store")
        for name, took_s in found.items():
            is_over = threading.Event()
            blocker = threading.Thread(target=_block, args=(store, is_over), daemon=True)
            if name == "blocked":
                blocker.start()
            for _ in range(presses):
                pressed_at = time.monotonic()
                QTest.mouseClick(button, Qt.MouseButton.LeftButton)
                turn_for(BETWEEN_S)
                arrived_at = module.locked_at
                took_s.append(arrived_at - pressed_at if arrived_at >= pressed_at else LIMIT_S)
            is_over.set()
    return found


def figures(presses: int = PRESSES) -> list[Figure]:
    """A press whose frame had not arrived after 60 ms counts as 15 s."""
    found = measured("tests.benchmarks.lock", str(presses))
    words = {"free": "the store free", "blocked": f"the store blocked for {BLOCKED_S:.0f} s, over and over"}
    figures = []
    for name, word in words.items():
        median, p99, longest = (quantile(found[name], share) * 1000 for share in (0.5, 0.99, 1.0))
        figures.append(
            Figure(
                f"press of LOCK to its frame at the module, {word} ({presses} presses)",
                f"median {median:.1f} ms, 99 % {p99:.1f} ms, longest {longest:.1f} ms",
                f"99 % <= {AIM_S * 1000:.0f} ms",
                p99 <= AIM_S * 1000,
            )
        )
    return figures


if __name__ == "__main__":
    print(json.dumps(measure(int(sys.argv[1]))))
