"""`dps-s diff FILE [FILE | --port P]`: compares the settings of two profiles, or of a profile and a module.

Of a module only the settings of the profile are compared; what it cannot tell is unknown. Sends queries only. Exit code
0 if all are equal; 1 if one differs; 3 without a link; 4 if none differs and one is unknown.
"""

import argparse
from collections.abc import Mapping

from app.cli.save import read_module
from app.terminal import console
from app.terminal.results import Result, SettingName, Value
from app.terminal.setting_words import settings_of_profile, typed
from app.text.i18n import tr
from protocol.fields import Value as SettingValue


class DiffJson(Result):
    """Settings that differ, each with both values; null where one of them has none."""

    differences: dict[SettingName, tuple[Value, Value]]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    console.add_file(parser, "file", metavar="FILE", help="profile")
    console.add_file(parser, "other", metavar="FILE", help="profile; without it the module", nargs="?")


def run(args: argparse.Namespace) -> int:
    if args.other is not None and args.port is not None:
        raise console.Refused(tr("expected {expected}", expected="FILE [FILE | --port P]"))
    first = settings_of_profile(args.file)
    if args.other is not None:
        second, head, missing = settings_of_profile(args.other), str(args.other), "–"
        names = list({**first, **second})
    else:
        second, head, missing = read_module(args).values, args.port, tr("unknown")
        # What the profile leaves open is no difference.
        names = list(first)
    unequal = [name for name in names if first.get(name) != second.get(name)]

    def shown(values: Mapping[str, SettingValue], name: str) -> str:
        return typed(values[name]) if name in values else missing

    rows = [("", str(args.file), head), *((name, shown(first, name), shown(second, name)) for name in unequal)]
    page = console.columns(rows) if unequal else [tr("The settings are equal.")]
    console.emit(args, DiffJson({name: (first.get(name), second.get(name)) for name in unequal}), page)
    if not unequal:
        return console.SUCCESS
    is_only_unknown = args.other is None and all(name not in second for name in unequal)
    return console.PARTIAL if is_only_unknown else console.ANSWER_NO
