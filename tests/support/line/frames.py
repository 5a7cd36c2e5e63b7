"""What happens at the frames that a host sends to a simulated module."""

from collections.abc import Callable
from functools import partial

from app.simulator.bench import SimulatedBench
from protocol.catalogue import Request
from protocol.messages import HOST_FRAME_LENGTH, decode_request


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
