"""A stream of the command line: its span, what is undone behind it, and whether it is the module of before."""

from contextlib import suppress
from pathlib import Path

import pytest

from app.engine.procedure import Cancelled, Pause, Procedure
from app.engine.setting_changes import READABLE_SETTINGS
from app.engine.worker import CLOSING_LIMIT_S
from app.terminal import streaming
from app.terminal.connection import connected
from app.terminal.interruption import Interrupted
from app.terminal.streaming import SameModule, StreamSpan
from tests.support.records.recordings_made import device

pytest_plugins = ["tests.support.cli_fixtures"]
pytestmark = pytest.mark.usefixtures("speaks_english")


def test_what_runs_in_the_background_has_time_to_undo_what_it_changed(port: str) -> None:
    """The line may lag, and a question may be open: longer than closing a port may take."""
    undone = []

    def background() -> Procedure[None]:
        try:
            while True:
                yield Pause(1.0)
        except Cancelled:
            yield Pause(2 * CLOSING_LIMIT_S)
            undone.append(True)
            raise

    with connected(port, 115200) as conversation:
        conversation.start_background(background())
    assert undone


def test_the_time_counts_from_the_first_report_also_of_a_stream_that_was_on() -> None:
    span = StreamSpan(1.0)
    assert span.holds(10.0)
    span.switch.began_at = 9.5  # noticed behind its first reports
    assert [span.holds(at) for at in (10.5, 11.0, 11.1)] == [True, True, False]


def test_the_doubt_after_a_break_ends_with_what_is_read_since() -> None:
    same, last = SameModule(), {command.key: command.reply.decode(0) for command in READABLE_SETTINGS if command.reply}
    assert same.contradiction(device(1.0, boot_count=37, **last)) is None
    for breaks, boots in enumerate((38, 39), start=1):
        restarted = device(2.0, boot_count=boots, **last)._replace(breaks=breaks)
        assert same.contradiction(restarted._replace(values={})) is None
        assert same.is_in_doubt
        assert same.contradiction(restarted) is None
        assert not same.is_in_doubt


def test_the_first_heartbeat_of_a_restart_takes_nothing_back_of_what_was_read() -> None:
    """It puts the boot count in doubt before the conversation breaks."""
    same, read = SameModule(), device(1.0, boot_count=37)
    assert same.contradiction(read) is None
    assert same.contradiction(read._replace(values={})) is None
    assert same.contradiction(device(2.0, boot_count=12)._replace(breaks=1)) is not None


def test_that_a_stream_was_left_on_is_said_also_where_a_signal_ends_the_command(
    user_files: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("app.terminal.console._Verbosity.level", 0)
    with suppress(Interrupted), streaming._stream_memory("/dev/ttyUSB0") as memory:
        memory.is_taken_over = True
        raise Interrupted(2)
    assert capsys.readouterr().err == f"{streaming.LEFT_ON}\n"
