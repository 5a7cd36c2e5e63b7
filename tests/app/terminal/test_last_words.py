"""What is printed after a signal takes a second at most, though nobody reads the pipe."""

import errno
import io
import os
import signal
import sys
import threading

import pytest

from app.terminal import interruption
from app.terminal.console import OutputLost, write
from app.terminal.interruption import print_after_signal

MORE_THAN_A_PIPE_HOLDS = "x" * 2_000_000


@pytest.mark.skipif(not hasattr(signal, "SIGALRM"), reason="Windows has no alarm")
def test_a_pipe_that_nobody_reads_is_given_up(monkeypatch: pytest.MonkeyPatch) -> None:
    assert threading.current_thread() is threading.main_thread()
    monkeypatch.setattr(interruption, "PATIENCE_S", 0.1)
    reading, writing = os.pipe()
    before = signal.getsignal(signal.SIGALRM)
    with open(writing, "w", encoding="utf-8") as out:  # noqa: PTH123
        monkeypatch.setattr(sys, "stdout", out)
        with print_after_signal():
            write(MORE_THAN_A_PIPE_HOLDS)
        monkeypatch.undo()
    assert signal.getsignal(signal.SIGALRM) is before
    assert signal.getitimer(signal.ITIMER_REAL)[0] == 0
    os.close(reading)


class _ClosedPipe(io.StringIO):
    def flush(self) -> None:
        raise OSError(errno.EINVAL, "Invalid argument")


@pytest.mark.parametrize(("platform", "raised"), [("win32", BrokenPipeError), ("linux", OutputLost)])
def test_windows_calls_a_closed_pipe_an_invalid_argument(
    monkeypatch: pytest.MonkeyPatch, platform: str, raised: type[Exception]
) -> None:
    monkeypatch.setattr(sys, "platform", platform)
    monkeypatch.setattr(sys, "stdout", _ClosedPipe())
    with pytest.raises(raised):
        write("the end\n")


def test_what_is_read_arrives_whole(capfd: pytest.CaptureFixture[str]) -> None:
    with print_after_signal():
        write("the end\n")
    assert capfd.readouterr().out == "the end\n"
