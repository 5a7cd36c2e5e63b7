"""Each kind of address against what may stand at its other end, with the command line in a process of its own."""

import json
import sys

import pytest

from tests.module.line import Line, now
from tests.module.module import Module
from tests.support.processes import PROGRAM, ran
from tests.unit.engine import tcp_peers

pytestmark = [
    pytest.mark.skipif(sys.platform == "win32", reason="the peers have pseudo-terminals"),
    pytest.mark.filterwarnings("ignore:set(Daemon|Name):DeprecationWarning"),  # pyserial's
]


@pytest.mark.parametrize("scheme", ["socket", "rfc2217"])
def test_a_module_behind_a_serial_server_is_read_set_and_locked(scheme: str) -> None:
    module = Module(now=now())
    module.settings[0x10] = 1
    with Line(module) as line, tcp_peers.serial_server(line.port, is_rfc2217=scheme == "rfc2217") as address:
        port = f"{scheme}://{address}"
        locked = ran(*PROGRAM, "lock", "--port", port)
        assert locked.returncode == 0, locked.stderr
        written = ran(*PROGRAM, "set", "freefall_time_s=0.90", "--port", port)
        assert written.returncode == 0, written.stderr
        read = ran(*PROGRAM, "read", "--json", "--port", port)
    assert read.returncode == 0, read.stderr
    assert json.loads(read.stdout)["settings"]["freefall_time_s"] == 0.9
    assert module.settings[0x10] == 0


def test_behind_a_plain_socket_the_rate_is_neither_found_nor_changed() -> None:
    """Whatever rate the port is opened with, the module answers; changing it would cut the link for good."""
    module = Module(now=now())
    with Line(module) as line, tcp_peers.serial_server(line.port) as address:
        port = f"socket://{address}"
        found = ran(*PROGRAM, "find", "--json", "--port", port)
        read = ran(*PROGRAM, "read", "--json", "--port", port)
        changed = ran(*PROGRAM, "set", "baud_rate=9600", "--accept-risk", "--port", port)
    assert found.returncode == 2
    assert read.returncode == 0
    assert json.loads(read.stdout)["settings"]["baud_rate"] is None
    assert "other end" in found.stderr
    assert changed.returncode == 1
    assert "other end" in changed.stdout + changed.stderr
    assert module.log.sets(0x24) == []


@pytest.mark.parametrize("scheme", ["socket", "rfc2217"])
def test_what_is_no_serial_server_is_said_of_the_address(scheme: str) -> None:
    with tcp_peers.serving(tcp_peers.closing) as address:
        port = f"{scheme}://{address}"
        ended = ran(*PROGRAM, "read", "--port", port)
    assert ended.returncode == 3, ended.stderr
    assert ended.stderr.count("\n") == 1, ended.stderr
    assert port in ended.stderr
