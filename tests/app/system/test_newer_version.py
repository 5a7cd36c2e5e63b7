"""A newer version is looked up only where that is safe, and within limits."""

import threading
from collections.abc import Iterator
from http.server import BaseHTTPRequestHandler, HTTPServer
from pathlib import Path

import pytest

from app.system import newer_version
from app.system.newer_version import find_newer, is_usable
from app.text.user_error import UserError


@pytest.mark.parametrize(
    ("address", "is_so"),
    [
        ("https://example.org/v", True), ("http://localhost:8000/v", True), ("http://127.0.0.1/v", True),
        ("http://[::1]:9/v", True), ("file:///srv/v.txt", True),
        ("http://example.org/v", False), ("http://127.0.0.1.example.org/v", False), ("ftp://example.org/v", False),
        ("file://server/v", False), ("https://", False), ("http://[::1/v", False), ("example.org", False), ("", False),
    ],
)  # fmt: skip
def test_only_what_cannot_be_altered_on_the_way_is_asked(address: str, is_so: bool) -> None:
    assert is_usable(address) is is_so
    if not is_so:
        with pytest.raises(UserError):
            find_newer(address, "1.0")


@pytest.mark.parametrize(
    ("said", "own", "newer"),
    [
        ("1.2.0\nwhat changed", "1.1.9", "1.2.0"), ("v1.10", "1.9", "v1.10"), ('{"tag_name": "v2.0"}', "1.9", "v2.0"),
        ('{"version": "1.0"}', "1.0rc1", "1.0"), ("1.0", "1.0.0", None), ("1.0rc1", "1.0", None), ("0.9", "1.0", None),
        ("1.0.post1", "1.0", None),
    ],
)  # fmt: skip
def test_versions_are_compared_by_their_numbers(tmp_path: Path, said: str, own: str, newer: str | None) -> None:
    file = tmp_path / "v.txt"
    file.write_text(said, encoding="utf-8")
    assert find_newer(file.as_uri(), own) == newer


@pytest.mark.parametrize(
    "said", [b"", b"<html>1.2</html>", b"{}", b"[1]", b"{", b"\xff", b"1.2; rm", b"9" * 8, b"1.2" + b" " * 70_000]
)
def test_what_is_no_version_is_none(tmp_path: Path, said: bytes) -> None:
    file = tmp_path / "v.txt"
    file.write_bytes(said)
    with pytest.raises((ValueError, OSError)):
        find_newer(file.as_uri(), "1.0")


class _Server(BaseHTTPRequestHandler):
    def do_GET(self) -> None:
        if self.path == "/away":
            self.send_response(302)
            self.send_header("Location", "http://example.invalid/v")
            self.end_headers()
        elif self.path == "/slow":
            self.send_response(200)
            self.end_headers()
            for _ in range(100):
                self.wfile.write(b" ")
                self.wfile.flush()
                if _stop.wait(0.05):
                    return
        elif self.path == "/none":
            self.send_error(404)
        else:
            self.send_response(200)
            self.end_headers()
            self.wfile.write(b"2.0\n")

    def log_message(self, *_: object) -> None: ...


_stop = threading.Event()


@pytest.fixture
def server() -> Iterator[str]:
    one = HTTPServer(("127.0.0.1", 0), _Server)
    serving = threading.Thread(target=one.serve_forever, daemon=True)
    serving.start()
    _stop.clear()
    yield f"http://127.0.0.1:{one.server_port}"
    _stop.set()
    one.shutdown()
    serving.join()
    one.server_close()


def test_an_answer_has_limits(server: str, monkeypatch: pytest.MonkeyPatch) -> None:
    assert find_newer(f"{server}/v", "1.0") == "2.0"
    with pytest.raises(UserError):  # it leads to where nobody may be asked
        find_newer(f"{server}/away", "1.0")
    with pytest.raises(OSError, match="404"):
        find_newer(f"{server}/none", "1.0")
    monkeypatch.setattr(newer_version, "LIMIT_S", 0.3)
    with pytest.raises(ValueError, match=r"0\.3 s"):
        find_newer(f"{server}/slow", "1.0")
