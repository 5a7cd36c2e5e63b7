"""`dps-s completion bash|zsh`: prints a completion script, which shtab writes from the parsers.

The script is static: pressing Tab starts no program.
"""

import argparse

from app.cli.commands import complete_parser
from app.terminal import console
from app.terminal.arguments import AUTO, RATES
from protocol.catalogue import SETTINGS
from protocol.fields import Choice, Flag

_PREAMBLES = {
    # bash splits NAME=VALUE at "=", so only what follows it is completed.
    "bash": """\
_dps_s_settings() {
    local one word=${COMP_LINE:0:COMP_POINT}
    word=${word##* }
    for one in SETTINGS; do
        if [[ $one == "$word"* ]]; then
            if [[ $word == *=* ]]; then echo "${one#*=}"; else echo "${one%%=*}="; fi
        fi
    done | uniq
}
_dps_s_rates() {
    compgen -W "RATES" -- "$1"
}
_dps_s() {
    _shtab_dps_s
    if [[ ${COMPREPLY[0]} == *= ]]; then compopt -o nospace; fi
}""",
    "zsh": """\
_dps_s_settings() {
    local -a words=(SETTINGS)
    compadd -S '' -- ${(M)words:#*=}
    compadd -- ${words:#*=}
}
_dps_s_rates() {
    compadd -- RATES
}""",
}
_INSTALL = """\
bash   dps-s completion bash > ~/.local/share/bash-completion/completions/dps-s
zsh    dps-s completion zsh > ~/.zfunc/_dps-s    (~/.zfunc in $fpath before compinit)"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.epilog = f"{_INSTALL}\n\n{parser.epilog}"
    parser.add_argument("shell", choices=tuple(_PREAMBLES))


def run(args: argparse.Namespace) -> int:
    import shtab

    preamble = _PREAMBLES[args.shell]
    preamble = preamble.replace("SETTINGS", " ".join(_setting_arguments()))
    preamble = preamble.replace("RATES", " ".join([*map(str, RATES), AUTO]))
    script = shtab.complete(complete_parser(), args.shell, preamble=preamble)
    console.write(script.replace("-F _shtab_dps_s dps-s", "-F _dps_s dps-s") + "\n")
    return console.SUCCESS


def _setting_arguments() -> list[str]:
    """NAME=VALUE where the values are a short list, else NAME=."""
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
