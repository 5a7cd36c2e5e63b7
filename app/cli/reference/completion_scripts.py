"""Completion scripts for bash, zsh and fish, written from the tree of commands.

They are static: a Tab starts no program.
"""

from collections.abc import Callable, Iterable, Mapping

from app.cli.reference.command_tree import Argument, CommandNode, Kind

Values = Mapping[str, tuple[str, ...]]
"""Names of settings, with what can be typed as their value where that is a short list."""


def bash(root: CommandNode, settings: Values) -> str:
    """To be sourced, or put where bash-completion looks for `dps-s`."""
    return _BASH.format(
        paths=_paths(root),
        values=_value_cases(root, _BASH_VALUES),
        options="\n".join(f'        "{one.path}") words="{_joined(_flags(one))}" ;;' for one in root.all()),
        arguments="\n".join(f'        "{one.path}") {_positional(one, _BASH_VALUES)} ;;' for one in root.all()),
        names=_joined(f"{name}=" for name in settings),
        setting_values="\n".join(_setting_cases(settings)),
    )


def zsh(root: CommandNode, settings: Values) -> str:
    """To be put into a folder of `$fpath` as `_dps-s`."""
    described = "\n".join(
        f"        {_quoted(one.path)}) commands=({' '.join(_zsh_pair(below) for below in one.commands)}) ;;"
        for one in root.all()
        if one.commands
    )
    options = "\n".join(
        f"        {_quoted(one.path)}) options=({' '.join(_zsh_options(one))}) ;;" for one in root.all()
    )
    return _ZSH.format(
        paths=_paths(root),
        values=_value_cases(root, _ZSH_VALUES),
        commands=described,
        options=options,
        arguments="\n".join(
            f"        {_quoted(one.path)}) {_positional(one, _ZSH_VALUES)} ;;" for one in root.all() if not one.commands
        ),
        names=_joined(f"{name}=" for name in settings),
        setting_values="\n".join(_setting_cases(settings)),
    )


def fish(root: CommandNode, settings: Values) -> str:
    """To be put into fish's folder `completions` as `dps-s.fish`."""
    lines = ["complete -c dps-s -f", _FISH_PATH]
    for node in root.all():
        condition = f"-n '__dps_s_is \"{node.path}\"'"
        lines += [f"complete -c dps-s {condition} -a {one.name} -d {_quoted(one.help)}" for one in node.commands]
        for one in node.options:
            flags = " ".join(f"-l {name[2:]}" if name.startswith("--") else f"-s {name[1:]}" for name in one.names)
            lines.append(f"complete -c dps-s {condition} {flags}{_fish_value(one, settings)} -d {_quoted(one.help)}")
        for one in node.values:
            value = _fish_value(one, settings)
            if value:
                lines.append(f"complete -c dps-s {condition}{value.replace(' -r', '')}")
    return "\n".join(lines) + "\n"


def _joined(words: Iterable[str]) -> str:
    return " ".join(words)


def _quoted(text: str) -> str:
    """For any of the three shells."""
    return "'" + text.replace("\\", "").replace("'", "’") + "'"


def _flags(node: CommandNode) -> list[str]:
    return [name for one in node.options for name in one.names]


def _paths(root: CommandNode) -> str:
    return "|".join(f'"{one.path}"' for one in root.all() if one.path)


def _value_cases(root: CommandNode, values: Callable[[Argument], str]) -> str:
    """What follows an option that takes a value."""
    return "\n".join(
        f'        "{node.path} {name}") {values(one)}; return ;;'
        for node in root.all()
        for one in node.options
        if one.takes_value
        for name in one.names
    )


def _positional(node: CommandNode, values: Callable[[Argument], str]) -> str:
    if node.commands:
        return f'words="{_joined(one.name for one in node.commands)}"'
    return values(node.values[0]) if node.values else ":"


def _setting_cases(settings: Values) -> list[str]:
    return [f'        {name}) words="{_joined(values)}" ;;' for name, values in settings.items() if values]


def _values(files: str, words: str) -> Callable[[Argument], str]:
    """What completes the value of an option or argument, in one shell's functions."""

    def of(one: Argument) -> str:
        match one.kind:
            case Kind.FILES:
                return files
            case Kind.WORDS:
                return words.format(_joined(one.words))
            case Kind.SETTINGS:
                return "_dps_s_settings"
            case Kind.NOTHING_KNOWN:
                return ":"

    return of


_BASH_VALUES = _values("_dps_s_files", '_dps_s_words "{}"')
_ZSH_VALUES = _values("_files", "compadd -- {}")


def _zsh_pair(node: CommandNode) -> str:
    return _quoted(f"{node.name}:{node.help}")


def _zsh_options(node: CommandNode) -> list[str]:
    return [_quoted(f"{name}:{one.help}") for one in node.options for name in one.names]


def _fish_value(one: Argument, settings: Values) -> str:
    match one.kind:
        case Kind.FILES:
            return " -r -F"
        case Kind.WORDS:
            return f" -r -a {_quoted(_joined(one.words))}"
        case Kind.SETTINGS:
            words = [f"{name}={value}" for name, values in settings.items() for value in values or ("",)]
            return f" -r -a {_quoted(_joined(words))}"
        case Kind.NOTHING_KNOWN:
            return " -r" if one.takes_value and one.names else ""


_BASH = """\
# Completion of dps-s for bash; written by: dps-s completion bash
_dps_s_words() {{
    local one
    for one in $1; do
        if [[ $one == "$cur"* ]]; then COMPREPLY+=("$one"); fi
    done
}}
_dps_s_files() {{
    local IFS=$'\n'
    compopt -o filenames 2>/dev/null
    COMPREPLY=($(compgen -f -- "$cur"))
}}
_dps_s_settings() {{
    if [[ $cur == "=" ]]; then name=$prev cur=""
    elif [[ $prev == "=" ]]; then name=${{COMP_WORDS[COMP_CWORD-2]}}
    else
        compopt -o nospace 2>/dev/null
        _dps_s_words "{names}"
        return
    fi
    words=""
    case "$name" in
{setting_values}
    esac
    _dps_s_words "$words"
}}
_dps_s() {{
    local cur=${{COMP_WORDS[COMP_CWORD]}} prev=${{COMP_WORDS[COMP_CWORD-1]}} path="" words="" name="" word
    COMPREPLY=()
    for word in "${{COMP_WORDS[@]:1:COMP_CWORD-1}}"; do
        case "${{path:+$path }}$word" in
        {paths}) path="${{path:+$path }}$word" ;;
        esac
    done
    case "$path $prev" in
{values}
    esac
    if [[ $cur == -* ]]; then
        case "$path" in
{options}
        esac
    else
        case "$path" in
{arguments}
        esac
    fi
    if [[ -n $words && ${{#COMPREPLY[@]}} -eq 0 && -z $name ]]; then
        _dps_s_words "$words"
    fi
}}
complete -F _dps_s dps-s
"""

_ZSH = """\
#compdef dps-s
# Completion of dps-s for zsh; written by: dps-s completion zsh
_dps_s_settings() {{
    local words="" name=${{PREFIX%%=*}}
    if [[ $PREFIX != *=* ]]; then
        compadd -S '' -- {names}
        return
    fi
    case "$name" in
{setting_values}
    esac
    compset -P '*='
    compadd -- ${{=words}}
}}
_dps_s() {{
    local path_words="" word prev=${{words[CURRENT-1]}}
    local -a commands options
    for word in ${{words[2,CURRENT-1]}}; do
        case "${{path_words:+$path_words }}$word" in
        {paths}) path_words="${{path_words:+$path_words }}$word" ;;
        esac
    done
    case "$path_words $prev" in
{values}
    esac
    case "$path_words" in
{commands}
    esac
    case "$path_words" in
{options}
    esac
    if [[ $PREFIX == -* ]]; then
        _describe option options
        return
    fi
    if (( $#commands )); then
        _describe command commands
        return
    fi
    case "$path_words" in
{arguments}
    esac
}}
if [[ $funcstack[1] == _dps-s ]]; then _dps_s "$@"; else compdef _dps_s dps-s; fi
"""

_FISH_PATH = """\
function __dps_s_is
    set -l tokens (commandline -opc)
    set -l found ""
    for token in $tokens[2..-1]
        string match -q -- '-*' $token; or set found (string trim "$found $token")
    end
    if test -z "$argv[1]"
        test -z "$found"
    else
        string match -q -- "$argv[1]" $found; or string match -q -- "$argv[1] *" $found
    end
end"""
