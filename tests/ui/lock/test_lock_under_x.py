"""LOCK above everything, with the keys and clicks of an X server instead of events that a test makes."""

import os
import subprocess
import sys
from pathlib import Path

from tests.support.x_server import x_server
from tests.ui.lock.test_lock_above import DIALOGS

ROOT = Path(__file__).parents[3]
LIMIT_S = 240


def test_real_keys_and_clicks_lock_over_everything() -> None:
    with x_server() as display:
        run = subprocess.run(
            [sys.executable, "-m", "tests.ui.lock.under_x"],
            cwd=ROOT,
            env={**os.environ, "DISPLAY": display, "QT_QPA_PLATFORM": "xcb"},
            capture_output=True,
            text=True,
            timeout=LIMIT_S,
            check=False,
        )
    assert run.returncode == 0, run.stderr[-2000:]
    over = [f"{name} locked locked" for name in DIALOGS]
    assert run.stdout.splitlines() == [*over, "menu ctrl+l locked", "menu click locked", "ctrl+q held open"]
