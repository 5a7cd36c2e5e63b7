"""Long work beside the main thread lets the window have its turn."""

import threading
import time

import pytest

from app.system import gil_yield as pace


@pytest.mark.parametrize("is_beside", [False, True])
def test_only_work_beside_the_main_thread_rests(monkeypatch: pytest.MonkeyPatch, is_beside: bool) -> None:
    now_s = [0.0]
    rests: list[float] = []
    monkeypatch.setattr(time, "sleep", rests.append)
    monkeypatch.setattr(time, "perf_counter", lambda: now_s[0])

    def work() -> None:
        keeper = pace.GilYield()
        for _ in range(30):
            now_s[0] += pace.WORK_S / 10
            keeper.checkpoint()

    if is_beside:
        thread = threading.Thread(target=work)
        thread.start()
        thread.join()
    else:
        work()
    assert bool(rests) is is_beside
