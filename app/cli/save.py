"""`dps-s save FILE.toml`: saves the settings as read, as a profile that `dps-s set --profile` and the window open.

Comments say when and from which module they were read, and what could not be read. Sends queries only. Exit code 0; 2
if the file exists and --force is missing; 3 without a link; 4 if some were not read, or the file cannot be written.
"""

import argparse
from collections.abc import Mapping
from datetime import datetime
from pathlib import Path
from typing import NamedTuple

from app.engine.target import is_simulated
from app.preflight.reading_object import SETTING_KEYS
from app.procedures.read import NO_REPLY, read_settings
from app.settings.fingerprint import fingerprint
from app.settings.profile_file import profile_text
from app.settings.profiles import MAX_NAME_LENGTH, Profile
from app.system.files import write_whole
from app.terminal import console
from app.terminal.arguments import STANDARD_OUTPUT, add_file, add_json, add_module, add_port
from app.terminal.connection import connected
from app.terminal.records import adapter_of
from app.terminal.results import Result, SettingName, Value
from app.text.i18n import tr
from app.text.messages import clean
from app.text.sentences import join_names, not_written
from protocol.catalogue import READABLE_SETTINGS
from protocol.fields import Value as SettingValue


class SaveJson(Result):
    """`written`: whether the file could be written; `errors`: why a setting is not in it."""

    file: str
    written: bool
    settings: dict[SettingName, Value]
    errors: dict[str, str]


class ModuleSettings(NamedTuple):
    """The settings of a module by key. `missing`: those that were not read, and why, in English."""

    port: str
    baud_rate: int
    boot_count: int | None
    values: Mapping[str, SettingValue]
    missing: Mapping[str, str]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_file(parser, "file", type=Path, metavar="FILE.toml", help="profile, or - for standard output")
    add_module(parser, "name of the profile")
    parser.add_argument("--force", action="store_true", help="replace the file")
    add_port(parser)
    add_json(parser)


def run(args: argparse.Namespace) -> int:
    path: Path = args.file
    is_file = path != STANDARD_OUTPUT
    if not is_file and args.json:
        raise console.Refused(tr("expected {expected}", expected="FILE.toml --json | -"))
    if is_file and path.exists() and not args.force:
        raise console.Refused(tr("{file} exists: use {options}.", file=path, options="--force"))
    module = read_module(args.port, args.baud)
    text = text_of(module, args.module or (path.stem if is_file else module.port))
    if not is_file:
        console.write(text)
        return notify_missing(module)
    trouble = ""
    try:
        write_whole(path, text.encode())
    except (OSError, ValueError) as error:
        trouble = not_written(path, error)
    if args.json:
        answer = SaveJson(str(path), not trouble, dict(module.values), dict(module.missing))
        console.write_lines([console.as_json(answer)])
    if trouble:
        console.notify(trouble)
        return console.PARTIAL
    console.note(tr("Saved to {path}.", path=path))
    return notify_missing(module)


def notify_missing(module: ModuleSettings) -> int:
    """Print the readable settings that were not read; returns the exit code."""
    missing = [command.key for command in READABLE_SETTINGS if command.key in module.missing]
    if not missing:
        return console.SUCCESS
    console.notify(tr("Could not read: {names}. Read again or check the wiring.", names=join_names(missing)))
    return console.PARTIAL


def read_module(port: str, baud_rate: int | None) -> ModuleSettings:
    """Raises `Interrupted` where the conversation ended meanwhile."""
    with connected(port, baud_rate) as opened:
        reading = opened.run(read_settings())
        rate = opened.connection.baud_rate
    values = {**reading.values, "baud_rate": rate}
    unread = {command.key for command in reading.unread}
    missing = {key: NO_REPLY if key in unread else "cannot be read" for key in SETTING_KEYS if key not in values}
    return ModuleSettings(port, rate, reading.boot_count, values, missing)


def text_of(module: ModuleSettings, name: str) -> str:
    """The profile, in English, with its origin as comments."""
    code, adapter = fingerprint(module.values), adapter_of(module.port)
    origin = [
        f"Settings as read by dps-s save, {datetime.now().astimezone().isoformat(' ', 'seconds')}",
        f"Port: {clean(module.port)}, {module.baud_rate} baud",
        f"Adapter: {clean(adapter)}" if adapter else "",
        "SIMULATED MODULE" if is_simulated(module.port) else "",
        f"Boot count: {'unknown' if module.boot_count is None else module.boot_count}",
        f"Settings code: {code}" if code else "",
        *(f"{key}: {why}" for key, why in module.missing.items()),
    ]
    profile = Profile(name=clean(name, longest=MAX_NAME_LENGTH), settings=module.values)
    return "".join(f"# {line}\n" for line in origin if line) + profile_text(profile)
