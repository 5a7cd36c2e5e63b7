"""What happens at the frames that a host sends to a simulated module: what it loses, refuses and repeats."""

from collections.abc import Callable
from functools import partial

from app.simulator.bench import SimulatedBench
from protocol.catalogue import INVERTED, Request
from protocol.messages import HOST_FRAME_LENGTH, decode_request, encode_reply


def at_each_frame(bench: SimulatedBench, act: Callable[[Request], object]) -> Callable[[], None]:
    """Call `act` before each frame is delivered; one of which it says False is lost. Return what ends it."""
    wire, write = bench.wire, bench.wire.write

    def written(data: bytes, now_s: float) -> None:
        for at in range(0, len(data), HOST_FRAME_LENGTH):
            frame = data[at : at + HOST_FRAME_LENGTH]
            if act(decode_request(frame)) is not False:
                write(frame, now_s)

    wire.write = written  # type: ignore[method-assign]
    return partial(setattr, wire, "write", write)


def at_frame(
    bench: SimulatedBench, number: int, act: Callable[[], object], *, code: int | None = None, is_lost: bool = False
) -> Callable[[], None]:
    """Call `act` before the `number`-th frame, of those of this code, is delivered or lost. Return what ends it."""
    seen = 0

    def counted(request: Request) -> bool:
        nonlocal seen
        seen += code in (None, request.command.code)
        is_it = seen == number and code in (None, request.command.code)
        if is_it:
            act()
        return not (is_it and is_lost)

    return at_each_frame(bench, counted)


def lose(bench: SimulatedBench, *codes: int) -> Callable[[], None]:
    """Frames of these codes are neither carried out nor answered. Return what ends it."""
    return at_each_frame(bench, lambda request: request.command.code not in codes)


def refuse(bench: SimulatedBench) -> Callable[[], None]:
    """No setting changes: each set is answered with the value that stands. Return what ends it."""

    def answered(request: Request) -> bool:
        command, module = request.command, bench.module
        if not (request.is_set and command.is_setting):
            return True
        if command.name in ("attitude_trigger", "freefall_trigger"):
            held = INVERTED.encode(getattr(module.state, command.name.replace("trigger", "is_enabled")))
        else:
            held = getattr(module.memory, command.name)
        bench.module.send(encode_reply(command.code, held), bench.clock())
        return False

    return at_each_frame(bench, answered)


def echo(bench: SimulatedBench) -> Callable[[], None]:
    """What the host sends comes back to it. Return what ends it."""
    return at_each_frame(bench, lambda request: bench.module.send(request.encode(), bench.clock()))


def restart_silently(bench: SimulatedBench) -> None:
    """Restart it without its two heartbeats."""
    bench.module.power_on(bench.clock())
    bench.module.out.pop()
    bench.module._plans.clear()
