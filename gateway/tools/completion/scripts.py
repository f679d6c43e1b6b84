"""The tree of words as a script for bash, zsh or fish."""

from collections.abc import Sequence

from gateway.tools.completion.parsers import Node

ROOT = "axisgate"
HEAD = "# completion of axisgate for {shell}; made by: axisgate completion {shell}"

BASH = """{head}
_axisgate() {{
    local cur=${{COMP_WORDS[COMP_CWORD]}} prev=${{COMP_WORDS[COMP_CWORD-1]}} node={root} word i
    local subs= options= words= files=
    for ((i = 1; i < COMP_CWORD; i++)); do
        word=${{COMP_WORDS[i]}}
        case "$node $word" in
            {steps}) node="$node $word" ;;
        esac
    done
    case "$node $prev" in
{values}
    esac
    case "$node" in
{nodes}
    esac
    COMPREPLY=()
    if [[ $cur == -* ]]; then
        COMPREPLY=($(compgen -W "$options" -- "$cur"))
    else
        COMPREPLY=($(compgen -W "$subs $words" -- "$cur"))
        [[ -n $files ]] && COMPREPLY+=($(compgen -f -- "$cur"))
    fi
}}
complete -o filenames -F _axisgate axisgate
"""

ZSH = """#compdef axisgate
{head}
_axisgate() {{
    local node={root} word prev=${{words[CURRENT-1]}}
    local -a subs options choices
    local files=
    for word in ${{words[2,CURRENT-1]}}; do
        case "$node $word" in
            ({steps}) node="$node $word" ;;
        esac
    done
    case "$node $prev" in
{values}
    esac
    case "$node" in
{nodes}
    esac
    if [[ $PREFIX == -* ]]; then
        compadd -- $options
    else
        compadd -- $subs $choices
        [[ -n $files ]] && _files
    fi
}}
if [[ $zsh_eval_context[-1] == loadautofunc ]]; then _axisgate "$@"; else compdef _axisgate axisgate; fi
"""

FISH = """{head}
function __axisgate_node
    set -l node {root}
    set -l typed (commandline -opc)
    for word in $typed[2..-1]
        if contains -- "$node $word" {steps}
            set node "$node $word"
        end
    end
    test "$node" = "$argv"
end
complete -c axisgate -f
{lines}
"""


def script(shell: str, root: Node, cells: Sequence[str]) -> str:
    """For bash | zsh | fish; `cells`: names of shipped cells."""
    nodes = [(" ".join((ROOT, *path)), node) for path, node in root.walk()]
    head, steps = HEAD.format(shell=shell), [name for name, _ in nodes[1:]]
    if shell == "fish":
        lines = "\n".join(line for name, node in nodes for line in _fish(name, node, cells))
        return FISH.format(head=head, root=ROOT, steps=" ".join(f"'{step}'" for step in steps), lines=lines)
    zsh = shell == "zsh"
    return (ZSH if zsh else BASH).format(
        head=head,
        root=ROOT,
        steps="|".join(f'"{step}"' for step in steps),
        values="\n".join(line for name, node in nodes for line in _values(name, node, zsh=zsh)),
        nodes="\n".join(_node(name, node, cells, zsh=zsh) for name, node in nodes),
    )


def _values(name: str, node: Node, *, zsh: bool) -> list[str]:
    """Completion of a value after an option."""
    lines = []
    for option in node.options:
        if option.values is None:
            continue
        places = "|".join(f'"{name} {each}"' for each in option.names)
        if zsh:
            does = f"compadd -- {' '.join(map(quoted, option.values))}" if option.values else "_files"
        else:
            words = f'-W "{" ".join(option.values)}"' if option.values else "-f"
            does = f'COMPREPLY=($(compgen {words} -- "$cur"))'
        lines.append(f"        {'(' if zsh else ''}{places}) {does}; return ;;")
    return lines


def _node(name: str, node: Node, cells: Sequence[str], *, zsh: bool) -> str:
    """Candidates where no option waits for its value."""
    subs, words = list(node.subs), [*node.words, *(cells if node.cell else ())]
    options = [each for option in node.options for each in option.names] or ["-h", "--help"]
    files = "yes" if node.cell or node.file else ""
    if zsh:
        rows = (f"{key}=({' '.join(map(quoted, found))})" for key, found in (("subs", subs), ("options", options), ("choices", words)))
        return f'        ("{name}") {" ".join(rows)} files={files} ;;'
    rows = (f'{key}="{" ".join(found)}"' for key, found in (("subs", subs), ("options", options), ("words", words)))
    return f'        "{name}") {" ".join(rows)} files={files} ;;'


def _fish(name: str, node: Node, cells: Sequence[str]) -> list[str]:
    here = f"complete -c axisgate -n '__axisgate_node {name}'"
    lines = [f"{here} -a {quoted(word)} -d {quoted(sub.help)}" for word, sub in node.subs.items()]
    words = [*node.words, *(cells if node.cell else ())]
    if words:
        lines.append(f"{here} -a {quoted(' '.join(words))}")
    if node.cell or node.file:
        lines.append(f"{here} -F")
    for option in node.options:
        spelled = " ".join(f"-l {each[2:]}" if each.startswith("--") else f"-s {each[1:]}" for each in option.names)
        value = "" if option.values is None else f" -x -a {quoted(' '.join(option.values))}" if option.values else " -r"
        lines.append(f"{here} {spelled}{value} -d {quoted(option.help)}")
    return lines


def quoted(text: str) -> str:
    """In single quotes for zsh and fish."""
    return "'" + text.replace("\\", "\\\\").replace("'", "'\\''") + "'"
