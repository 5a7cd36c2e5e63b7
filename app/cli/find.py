"""`dps-s find`: finds the baud rate at which a module answers. Sends queries only."""

import argparse

from app.engine.target import is_socket
from app.procedures.find import find_rate
from app.safety.permit import RATE_SET_ELSEWHERE
from app.terminal import console
from app.terminal.connection import connected, no_module_found
from app.terminal.results import Count, Result
from app.text.i18n import tr
from app.text.messages import message


class FindJson(Result):
    """`baud_rate` is null where nothing answers at any of the rates that were tried."""

    baud_rate: Count | None
    tried: list[Count]


def run(args: argparse.Namespace) -> int:
    if is_socket(args.port):
        # Whatever rate the port is opened with, the module would answer: the result would be a lie.
        raise console.Refused(message(RATE_SET_ELSEWHERE))
    # A rate that is given is only where the search begins.
    first = args.baud or console.USUAL_RATE
    with connected(args.port, first, is_greeted=False) as opened:
        search = opened.run(find_rate(first), outlives=True)
    if search.baud_rate is not None:
        page = [tr("{port}, {rate} baud", port=args.port, rate=search.baud_rate)]
        return console.emit(args, FindJson.of(search), page)
    console.emit(args, FindJson.of(search), [])
    console.notify(no_module_found(args.port))
    return console.NO_LINK
