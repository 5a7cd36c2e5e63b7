"""`dps-s save FILE.toml`: saves the settings as read, as a profile that `dps-s set --profile` and the window open.

Comments say when and from which module they were read, and what could not be read. Sends queries only. Exit code 0; 2
if the file exists and --force is missing; 3 without a link; 4 if some were not read, or the file cannot be written.
"""

import argparse
from datetime import datetime
from pathlib import Path
from typing import NamedTuple

from app.engine.target import is_simulated
from app.procedures.read import NO_REPLY, SETTING_KEYS, read_settings
from app.settings.profile_file import MAX_NAME_LENGTH, profile_text
from app.settings.profiles import Profile
from app.settings.values import fingerprint
from app.system.files import write_whole
from app.terminal import console
from app.terminal.connection import adapter_of, connected
from app.terminal.results import Result, SettingName, Value
from app.text.i18n import tr
from app.text.messages import clean, join_names
from protocol.catalogue import BAUD_RATE
from protocol.fields import Value as SettingValue


class SaveJson(Result):
    """`written`: whether the file could be written; `errors`: why a setting is not in it."""

    file: str
    written: bool
    settings: dict[SettingName, Value]
    errors: dict[str, str]


class ModuleSettings(NamedTuple):
    """The settings of a module by key. `missing`: those that were not read, and why, in English."""

    boot_count: int | None
    values: dict[str, SettingValue]
    missing: dict[str, str]

    def notify_missing(self) -> int:
        """Say which settings were not answered; returns the exit code."""
        names = [key for key, why in self.missing.items() if why == NO_REPLY]
        if names:
            console.notify(tr("Could not read: {names}. Read again or check the wiring.", names=join_names(names)))
        return console.PARTIAL if names else console.SUCCESS


def read_module(args: argparse.Namespace) -> ModuleSettings:
    """Read the settings of the module. Raises `Interrupted` where the conversation ended meanwhile."""
    with connected(args.port, args.baud) as opened:
        reading = opened.run(read_settings())
    values = {key: value for key, value in reading.values.items() if key in SETTING_KEYS}
    values[BAUD_RATE.key] = opened.connection.baud_rate
    unread = [key for key in SETTING_KEYS if key not in values]
    missing = {key: NO_REPLY if key in reading.errors else "cannot be read" for key in unread}
    return ModuleSettings(reading.boot_count, values, missing)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    console.add_file(parser, "file", metavar="FILE.toml", help="profile")
    console.add_flags(parser, "--force")


def run(args: argparse.Namespace) -> int:
    path: Path = args.file
    console.refuse_existing(path, is_forced=args.force)
    module = read_module(args)
    # A file says for itself where its values come from: it is carried to other computers.
    code, adapter = fingerprint(module.values), adapter_of(args.port)
    origin = [
        f"Settings as read by dps-s save, {datetime.now().astimezone().isoformat(' ', 'seconds')}",
        f"Port: {clean(args.port)}, {module.values[BAUD_RATE.key]} baud",
        f"Adapter: {clean(adapter)}" if adapter else "",
        "SIMULATED MODULE" if is_simulated(args.port) else "",
        f"Boot count: {'unknown' if module.boot_count is None else module.boot_count}",
        f"Settings code: {code}" if code else "",
        *(f"{key}: {why}" for key, why in module.missing.items()),
    ]
    text = "".join(f"# {line}\n" for line in origin if line)
    text += profile_text(Profile(name=clean(path.stem, longest=MAX_NAME_LENGTH), settings=module.values))
    is_written = console.wrote(path, lambda: write_whole(path, text.encode()))
    answer = SaveJson(str(path), is_written, dict(module.values), module.missing)
    console.emit(args, answer, [tr("Saved to {path}.", path=path)] if is_written else [])
    return module.notify_missing() if is_written else console.PARTIAL
