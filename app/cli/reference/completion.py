"""`dps-s completion bash|zsh|fish|powershell`: prints a completion script, which shtab writes from the parsers.

The script is static: pressing Tab starts no program.

`dps-s schema NAME`: prints the JSON Schema of what a command prints with --json, or of a pre-flight record.
"""

import argparse
import json

from app.cli.commands import complete_parser
from app.terminal import console
from app.terminal.arguments import AUTO, RATES, Parser

_FILE_METAVARS = ("FILE", "DIR", "PATH", "LOG", "P", "HEX")
"""Of arguments that name a file, a folder or a port."""
_SETTINGS_FUNCTION = "_dps_s_settings"
_PREAMBLES = {
    # bash splits NAME=VALUE at "=", so only what follows it is completed.
    "bash": """\
_dps_s_settings() {
    local one word=${COMP_LINE:0:COMP_POINT}
    word=${word##* }
    for one in WORDS; do
        if [[ $one == "$word"* ]]; then
            if [[ $word == *=* ]]; then echo "${one#*=}"; else echo "${one%%=*}="; fi
        fi
    done | uniq
}
_dps_s() {
    _shtab_dps_s
    if [[ ${COMPREPLY[0]} == *= ]]; then compopt -o nospace; fi
}""",
    "zsh": """\
_dps_s_settings() {
    local -a words=(WORDS)
    compadd -S '' -- ${(M)words:#*=}
    compadd -- ${words:#*=}
}""",
    "fish": "",
    "powershell": """\
function _dps_s_settings {
    param([string]$WordToComplete)
    'WORDS' -split ' ' | Where-Object { $_ -like "$WordToComplete*" }
}""",
}
_INSTALL = """\
bash   dps-s completion bash > ~/.local/share/bash-completion/completions/dps-s
zsh    dps-s completion zsh > ~/.zfunc/_dps-s    (~/.zfunc in $fpath before compinit)
fish   dps-s completion fish > ~/.config/fish/completions/dps-s.fish
powershell   dps-s completion powershell >> $PROFILE"""


def add_arguments(parser: Parser) -> None:
    parser.epilog, parser.formatter_class = _INSTALL, argparse.RawDescriptionHelpFormatter
    parser.add_argument("shell", choices=("bash", "zsh", "fish", "powershell"))


def run(args: argparse.Namespace) -> int:
    import shtab

    parser, settings = complete_parser(), _setting_arguments()
    _add_choices(parser, settings)
    preamble = _PREAMBLES[args.shell].replace("WORDS", " ".join(settings))
    script = shtab.complete(parser, args.shell, preamble=preamble)
    console.write(script.replace("-F _shtab_dps_s dps-s", "-F _dps_s dps-s") + "\n")
    return console.SUCCESS


def run_schema(args: argparse.Namespace) -> int:
    from app.cli.results import schema_of

    console.write(json.dumps(schema_of(args.name), indent=2, ensure_ascii=False) + "\n")
    return console.SUCCESS


def _setting_arguments() -> list[str]:
    """NAME=VALUE where the values are a short list, else NAME=."""
    from protocol.catalogue import SETTINGS
    from protocol.fields import Choice, Flag

    words: list[str] = []
    for command in SETTINGS:
        match command.write:
            case Flag():
                values: tuple[object, ...] = ("true", "false")
            case Choice(values=rates):
                values = tuple(rates.values())
            case _:
                values = ("",)
        words += [f"{command.key}={value}" for value in values]
    return words


def _add_choices(parser: argparse.ArgumentParser, settings: list[str]) -> None:
    """What shtab cannot know from the parser: the help of commands, and what arguments of our own types take."""
    import shtab

    for action in parser._actions:
        metavar = action.metavar if isinstance(action.metavar, str) else ""
        if isinstance(action, argparse._SubParsersAction):
            described = {choice.dest for choice in action._choices_actions}
            for name, child in action.choices.items():
                if name not in described:
                    action._choices_actions.append(action._ChoicesPseudoAction(name, (), child.description))
                _add_choices(child, settings)
        elif "--baud" in action.option_strings:
            action.choices = (*map(str, RATES), AUTO)
        elif metavar == "yes|no" or metavar.startswith("{"):
            action.choices = metavar.strip("{}").replace("|", ",").split(",")
        elif metavar == "NAME=VALUE":
            function = _SETTINGS_FUNCTION
            action.complete = {"bash": function, "zsh": function, "powershell": function, "fish": " ".join(settings)}  # type: ignore[attr-defined]
        elif metavar.partition(".")[0] in _FILE_METAVARS:
            action.complete = shtab.FILE  # type: ignore[attr-defined]
