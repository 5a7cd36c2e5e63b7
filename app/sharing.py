"""Shares an open port over TCP with readers that may only ask, for `dps-s serve` and for the window.

    a question    asked in its turn, and answered to whoever asked
    LOCK          sent at once by the owner of the port, as its own, whatever else is asked
    all else      refused: it never reaches the port

What the module says unasked goes to every reader. When the conversation with the module ends nothing is passed on for
`QUIET_S`, longer than a link waits: so it ends for each reader, too, and none takes another module for the same one.

What is kept of a reader is bounded by the catalogue: its questions, each once, and a frame that is not whole. One that
does not read is dropped.
"""

import socket
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import partial
from ipaddress import ip_address
from select import select
from typing import Any, Literal, NamedTuple

from app.engine.conversation import ConversationView, reason_message
from app.engine.procedure import SHARED, Ask, Job, Procedure
from app.engine.worker import Batch
from app.procedures.lock import Locked
from app.system.clock import steady_time
from app.text.i18n import tr
from app.text.messages import join_names, labelled
from protocol.catalogue import HEARTBEAT_REPLY, LOCK, Request
from protocol.events import Answered, Ended, EndReason, Received, Role
from protocol.messages import (
    Direction,
    EmptySlot,
    Frame,
    Heartbeat,
    Message,
    Reading,
    Status,
    TriggerRecord,
    decode_request,
    encode_reply,
)
from protocol.stream import StreamParser
from protocol.timing import LONGEST_SILENCE_S

MOST_READERS = 16
QUIET_S = LONGEST_SILENCE_S + 0.3
CHUNK = 4096

# What happened: "lock" where a reader's LOCK is being sent, "ended" the conversation with the module.
Event = Literal["joined", "left", "dropped", "refused", "lock", "locked", "not_locked", "ended"]


class Reader(NamedTuple):
    """One reader: its connection, and what is kept of it."""

    client: socket.socket
    name: str
    parser: StreamParser
    refused: set[int]  # codes, each told once

    def fileno(self) -> int:
        return self.client.fileno()


def listen_at(host: str, port: int) -> tuple[socket.socket, str, str]:
    """Listen at an address (port 0 is a free one). Returns the listener, the address that readers open, and what a
    person must know of it where others than this computer reach it, else "". Raises OSError."""
    listener = socket.create_server((host, port), family=socket.AF_INET6 if ":" in host else socket.AF_INET)
    host, port = listener.getsockname()[:2]
    address = f"shared://[{host}]:{port}" if ":" in host else f"shared://{host}:{port}"
    if ip_address(host).is_loopback:
        return listener, address, ""
    warning = tr("TCP has no authentication: whoever reaches {address} reads, and may LOCK.", address=address)
    return listener, address, warning


class Sharing:
    """See the module's docstring. Belongs to one thread, which calls `turn` again and again and `take_in` with each
    batch of the port; a batch with a job that ended follows what that job is given."""

    def __init__(
        self,
        listener: socket.socket,
        submit: Callable[[Job[Any], Callable[[Job[Any]], None]], object],
        lock: Callable[[Callable[[Locked], None]], object],
        tell: Callable[[Event, str, str], None],
    ) -> None:
        """`submit` runs a job on the port and calls back when it has ended; `lock` sends LOCK, unless it is
        being sent, and calls back when that has come to an end; `tell` is given what happened, a reader's address or
        "", and a sentence or ""."""
        self._submit = submit
        self._lock = lock
        self._tell = tell
        self.readers: list[Reader] = []
        # What they wait for, each once.
        self._questions: list[tuple[Reader, Request]] = []
        self._is_asking = False
        self._conversation = ConversationView()
        self._quiet_until = 0.0
        # The readers whose LOCK is being sent.
        self._lockers: list[Reader] = []
        self._listener = listener
        listener.setblocking(False)

    def turn(self, longest_s: float) -> None:
        """Do what is due, and wait at most `longest_s` for readers."""
        self._ask_next()
        watched: list[socket.socket | Reader] = [self._listener, *self.readers]
        ready, _, _ = select(watched, [], [], longest_s)
        for one in ready:
            if isinstance(one, Reader):
                self._hear(one)
            else:
                self._accept()

    def take_in(self, batch: Batch) -> None:
        self._conversation = batch.conversation
        for event in batch.events:
            if isinstance(event, Ended) and event.reason not in (EndReason.CLOSED, EndReason.PORT_LOST):
                self._quiet_until = steady_time() + QUIET_S
                self._tell("ended", "", reason_message(event.reason, event.contradiction).translated())
            elif isinstance(event, Received) and event.role in (Role.STREAMED, Role.UNSOLICITED, Role.DUPLICATE):
                is_quiet = steady_time() < self._quiet_until
                is_restart = isinstance(event.message, Heartbeat)  # told at once, also while it is quiet
                if is_restart and is_quiet:
                    self._quiet_until = steady_time() + QUIET_S
                if is_restart or not is_quiet:
                    self._send(self.readers, event.frame.raw)

    def close(self) -> None:
        """Hang up."""
        for reader in self.readers:
            reader.client.close()
        self.readers.clear()
        self._listener.close()

    # Readers

    def _accept(self) -> None:
        with suppress(OSError):  # it has gone again
            client, address = self._listener.accept()
            client.setblocking(False)
            client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            reader = Reader(client, f"{address[0]}:{address[1]}", StreamParser(), set())
            self.readers.append(reader)
            self._tell("joined", reader.name, "")
            if len(self.readers) > MOST_READERS:
                self._drop(reader, tr("Dropped: too many readers."))

    def _hear(self, reader: Reader) -> None:
        data = b""
        with suppress(OSError):
            data = reader.client.recv(CHUNK)
        if not data:
            self._drop(reader)
        for piece in reader.parser.feed(data):
            if isinstance(piece, Frame) and piece.direction is Direction.HOST_TO_MODULE:
                self._take_request(reader, decode_request(piece.raw))

    def _take_request(self, reader: Reader, request: Request) -> None:
        if request == LOCK:
            if reader not in self._lockers:
                self._lockers.append(reader)
                self._tell("lock", reader.name, "LOCK")
            self._lock(self._on_locked)
        elif not request.command.can_be_asked or request.is_set:
            if request.command.code not in reader.refused:
                reader.refused.add(request.command.code)
                why = labelled(request.encode().hex(" ").upper(), tr(SHARED))
                self._tell("refused", reader.name, why)
        elif (reader, request) not in self._questions:
            self._questions.append((reader, request))

    def _drop(self, reader: Reader, why: str = "") -> None:
        if reader in self.readers:
            self.readers.remove(reader)
            self._questions = [(one, asked) for one, asked in self._questions if one is not reader]
            reader.client.close()
            self._tell("dropped" if why else "left", reader.name, why)

    def _send(self, readers: Sequence[Reader], data: bytes) -> None:
        for reader in tuple(readers):
            try:
                # What the system keeps for a reader is bounded, and a part of a frame is of no use.
                is_taken = reader.client.send(data) == len(data)
            except BlockingIOError:
                is_taken = False
            except OSError:  # it has left, which receiving finds out
                continue
            if not is_taken:
                self._drop(reader, tr("Dropped: it does not read."))

    # The module

    def _ask_next(self) -> None:
        conversation = self._conversation
        if not conversation.is_going or steady_time() < self._quiet_until:
            self._questions.clear()
        if self._is_asking or not self._questions:
            return
        reader, question = self._questions.pop(0)
        self._is_asking = True
        self._submit(Job(_ask(question), conversation=conversation.number), partial(self._on_answered, reader))

    def _on_answered(self, reader: Reader, job: Job[tuple[Message, ...]]) -> None:
        self._is_asking = False
        if job.error is None:
            self._send([reader], b"".join(map(frame_of, job.outcome())))

    def _on_locked(self, done: Locked) -> None:
        names = join_names(reader.name for reader in self._lockers)
        self._tell("locked" if done.is_locked else "not_locked", names, done.sentence)
        if done.is_acknowledged:
            self._send(self._lockers, encode_reply(LOCK.command.code, LOCK.data))
        self._lockers = []


def _ask(request: Request) -> Procedure[tuple[Message, ...]]:
    outcome = yield Ask(request)
    return outcome.messages if isinstance(outcome, Answered) else ()


def frame_of(answer: Message) -> bytes:
    """The module's frame with this meaning, as the answer to a question."""
    match answer:
        case Reading():
            return encode_reply(answer.command.code, answer.raw)
        case Status():
            return answer.encode()
        case TriggerRecord() | EmptySlot():
            return answer.raw
        case _:
            return HEARTBEAT_REPLY
