"""Starts each measurement in its own process, so that runs do not influence each other."""

import json
import os
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final

from tests.benchmarks.module import StreamingModule, streaming_module
from tests.support.processes import ran

NAMES: Final = ("parser", "link", "reading", "lock", "startup", "plots", "cpu", "memory")
"""The benchmarks, each a module of this folder with its `figures`."""
_OFFSCREEN: Final = "propagateSizeHints"
"""A warning of the offscreen platform, which has no window manager."""
_LIVELY: Final = ("lifelike=yes", "noise=1")


def measured(program: str, *words: str) -> dict[str, Any]:
    """Run `python -m program words…` offscreen; return its JSON. Raises RuntimeError if it fails."""
    done = ran(sys.executable, "-m", program, *words, QT_QPA_PLATFORM=os.environ.get("QT_QPA_PLATFORM", "offscreen"))
    if done.returncode or not done.stdout:
        raise RuntimeError(f"{program} {' '.join(words)} failed:\n{done.stderr[-2000:]}")
    found: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    for line in done.stderr.splitlines():
        if _OFFSCREEN not in line:
            print(line, file=sys.stderr)
    return found


@contextmanager
def lively_module(rate_hz: int) -> Iterator[StreamingModule]:
    """A moving simulated module in another process that streams at this rate on request."""
    with (
        tempfile.TemporaryDirectory() as folder,
        streaming_module(Path(folder) / "module", f"rate={rate_hz}", *_LIVELY) as module,
    ):
        yield module


def cores() -> int:
    """CPU cores available to this process."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
