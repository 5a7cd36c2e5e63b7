"""Programs that hold a port: a second instance, one that is killed, one that is terminated."""

import signal
import subprocess
import sys
import time

import pytest

from app.engine.transport import open_line
from tests.support.patience import PATIENCE_S, in_time
from tests.support.processes import ENVIRONMENT, PROGRAM, ROOT, RunningModule
from tests.support.terminals import STATUS_FRAME

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="pseudo-terminals are POSIX")
pytest_plugins = ["tests.support.port_fixtures"]


def test_sigterm_ends_in_time_and_switches_the_stream_off(module: RunningModule) -> None:
    command = [*PROGRAM, "monitor", "--port", module.port, "--seconds", "30"]
    with subprocess.Popen(
        command, cwd=ROOT, env=ENVIRONMENT, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE
    ) as first:
        assert first.stdout is not None
        assert first.stdout.readline()
        with in_time(2.0):
            first.send_signal(signal.SIGTERM)
            _, said = first.communicate(timeout=PATIENCE_S)
    assert "Traceback" not in said
    line = open_line(module.port, 115200)
    try:
        end_s = time.monotonic() + 0.3
        came = b""
        while time.monotonic() < end_s:
            came += line.read(0.01, 0.0)
        assert len(came) <= 2 * len(STATUS_FRAME)  # the stream is off; at most what was on its way
    finally:
        line.close()
