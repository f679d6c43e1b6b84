"""Print a completion script for bash, zsh or fish: commands, options and cells."""

import argparse
from importlib.metadata import entry_points

from gateway.files.find import names_in
from gateway.tools.command_support import DONE
from gateway.tools.completion.parsers import tree
from gateway.tools.completion.scripts import script

EXAMPLES = """examples:
  source <(axisgate completion bash)                                          this bash only
  axisgate completion bash > ~/.local/share/bash-completion/completions/axisgate
  axisgate completion zsh > "${fpath[1]}/_axisgate"                           then a new zsh
  axisgate completion fish > ~/.config/fish/completions/axisgate.fish
The words are those of the installed commands: print it again after an update.
exit code: 0 done, 2 command line"""


def main(argv: list[str]) -> int:
    parser = argparse.ArgumentParser(
        "axisgate completion", description=__doc__, epilog=EXAMPLES, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("shell", choices=("bash", "zsh", "fish"))
    arguments = parser.parse_args(argv)
    from gateway.commands.catalogue import GROUP, first_line

    known = {entry.name: entry for entry in entry_points(group=GROUP)}
    print(script(arguments.shell, tree(known, first_line), names_in("cells")), end="")
    return DONE
