"""LOCK above everything, with the keys and clicks of an X server instead of events that a test makes."""

import sys

from tests.support.processes import ran
from tests.support.x_server import needs_x_server, x_server
from tests.ui.lock.test_lock_above import DIALOGS


@needs_x_server
def test_real_keys_and_clicks_lock_over_everything() -> None:
    with x_server() as display:
        command = sys.executable, "-m", "tests.ui.lock.under_x"
        run = ran(*command, DISPLAY=display, QT_QPA_PLATFORM="xcb")
    assert run.returncode == 0, run.stderr[-2000:]
    over = [f"{name} locked locked" for name in DIALOGS]
    assert run.stdout.splitlines() == [*over, "menu ctrl+l locked", "menu click locked", "ctrl+q held open"]
