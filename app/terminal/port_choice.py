"""The value of --port: by default `DPS_S_PORT`, or the only USB adapter; an address of an unknown kind is refused."""

import os

from app.terminal.console import NO_LINK, Refused, note
from app.text.i18n import tr
from app.text.sentences import join_names
from app.text.user_error import UserError

PORT = "DPS_S_PORT"
"""Environment variable: the port if --port is missing."""


def choose_port() -> str:
    """Choose and print the port. Raises `Refused`."""
    from app.engine.ports import list_ports

    named = os.environ.get(PORT, "").strip()
    if named:
        note(tr("Port {port} ({name})", port=named, name=PORT))
        return named
    try:
        adapters = [port for port in list_ports() if port.vid is not None]
    except UserError as error:
        raise Refused(error.message, NO_LINK) from error
    if not adapters:
        raise Refused(tr("There is no USB adapter. Plug it in, or give --port."), NO_LINK)
    if len(adapters) > 1:
        names = join_names(port.device for port in adapters)
        raise Refused(tr("There are several adapters: {names}. Give --port.", names=names))
    adapter = adapters[0]
    note(tr("Port {port} ({name})", port=adapter.device, name=adapter.description or adapter.identity))
    return adapter.device


def refuse_unknown_address(port: str) -> None:
    """Raises `Refused` for a URL that no port is opened by, such as that of a file."""
    if "://" not in port:
        return
    from app.diagnosis.causes import explain
    from app.engine.transport import PortError, refuse_unsupported

    try:
        refuse_unsupported(port)
    except PortError as error:
        raise Refused(explain(error).terminal_sentence) from error
