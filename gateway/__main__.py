"""`axisgate NAME ...`: finds the command in the entry-point group `axisgate.commands` and calls it; no logic here."""

import difflib
import importlib
import importlib.util
import os
import sys
from collections.abc import Callable, Mapping, Sequence
from importlib.metadata import EntryPoint, entry_points
from typing import cast

from gateway.commands.catalogue import GROUP, first_line
from gateway.tools.usage_language import complain, help_text, usage_text, users_language

Command = Callable[[list[str]], int]
INVALID, ENVIRONMENT, INTERRUPTED = 2, 3, 130  # exit codes: command line, cell or file invalid; environment; Ctrl-C


def main(argv: Sequence[str] | None = None) -> int:
    arguments = list(sys.argv[1:] if argv is None else argv)
    known = {entry.name: entry for entry in entry_points(group=GROUP)}
    if not arguments or arguments[0] in ("-h", "--help", "help"):
        print(overview(known))
        return 0 if arguments else INVALID
    if arguments[0] in ("--version", "-V", "version"):
        print(version_line())
        return 0
    name, rest = arguments[0], arguments[1:]
    if name not in known:
        said = usage_text(f"unknown command '{name}'{nearest(name, known)} axisgate -h lists the commands")
        print(f"axisgate: {said}", file=sys.stderr)
        return INVALID
    try:
        command = load(known[name])
    except ModuleNotFoundError as missing:
        complain(name, reason(known[name], missing))
        return ENVIRONMENT
    except KeyboardInterrupt:  # Ctrl-C while it is loaded
        return INTERRUPTED
    try:
        with users_language():
            return command(rest)
    except KeyboardInterrupt:  # Ctrl-C that the command does not handle itself
        return INTERRUPTED
    except BrokenPipeError:  # `| head` has seen enough
        sys.stdout = open(os.devnull, "w")  # noqa: SIM115  nothing is flushed into the closed pipe at the end
        return 0


def version_line() -> str:
    """Version of everything that runs here, for a fault report."""
    import platform
    from importlib.metadata import version

    return f"axisgate {version('axisgate')}, Python {platform.python_version()}, {platform.system()} {platform.machine()}"


def load(entry: EntryPoint) -> Command:
    """The function of an entry point; ModuleNotFoundError names what is missing."""
    return cast(Command, getattr(importlib.import_module(entry.module), entry.attr))


def nearest(name: str, known: Mapping[str, EntryPoint]) -> str:
    close = difflib.get_close_matches(name, known, n=1, cutoff=0.4)
    return f", did you mean '{close[0]}'?" if close else ";"


def reason(entry: EntryPoint, missing: ModuleNotFoundError) -> str:
    if missing.name and f"{entry.module}.".startswith(f"{missing.name}."):
        return f"not in this version (module {missing.name} does not exist yet)"
    return f"needs the Python module '{missing.name}', which is not installed (make installs requirements.lock)"


def overview(known: Mapping[str, EntryPoint]) -> str:
    width = max((len(name) for name in known), default=0)
    lines = [f"  {name:<{width}}  {help_text(first_line(entry))}" for name, entry in sorted(known.items())]
    head = help_text("usage: axisgate COMMAND ...   (help for a command: axisgate COMMAND -h; axisgate --version)")
    return "\n".join([head, "", *lines])


if __name__ == "__main__":
    sys.exit(main())
