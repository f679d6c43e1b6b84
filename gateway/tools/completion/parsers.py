"""Every command's argparse parser as a tree of words; nothing of a command runs beyond the making of its parser."""

import argparse
import contextlib
import importlib
import io
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from importlib.metadata import EntryPoint

Command = Callable[[list[str]], int]
CELLS = ("cell", "CELL")
BEFORE_ARGPARSE: Mapping[str, tuple[str, ...]] = {  # tools a command calls before its own parser, each with a parser of its own
    "bus": ("monitor", "log", "replay", "send", "load", "plan", "infer"),
    "doctor": ("serial", "can"),
    "line": ("export",),
    "learn": ("line",),
    "motion": ("run",),
}


@dataclass(frozen=True, slots=True)
class Option:
    """One option: its spellings, its help text, its values (None: none; (): anything)."""

    names: tuple[str, ...]
    help: str
    values: tuple[str, ...] | None


@dataclass(slots=True)
class Node:
    """What may follow some words."""

    help: str = ""
    subs: "dict[str, Node]" = field(default_factory=dict)
    options: list[Option] = field(default_factory=list)
    words: tuple[str, ...] = ()  # choices of positional arguments
    cell: bool = False  # a cell is expected
    file: bool = False  # any other argument may be a file

    def walk(self, path: tuple[str, ...] = ()) -> "Iterator[tuple[tuple[str, ...], Node]]":
        """Every node with the words that lead to it."""
        yield path, self
        for word, sub in self.subs.items():
            yield from sub.walk((*path, word))


class _Captured(Exception):
    """A command was about to read its command line."""

    def __init__(self, parser: argparse.ArgumentParser, words: Sequence[str]) -> None:
        self.parser, self.words = parser, words


def parser_of(command: Command, words: Sequence[str] = ()) -> argparse.ArgumentParser | None:
    """The parser a command would read `words` with; None where it ends before it has one."""

    def capture(self: argparse.ArgumentParser, args: Sequence[str] | None = None, namespace: object = None) -> object:
        raise _Captured(self, args or ())

    kept = argparse.ArgumentParser.parse_args
    try:
        setattr(argparse.ArgumentParser, "parse_args", capture)  # noqa: B010  mypy knows it as a method
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
            command(list(words))
    except _Captured as found:
        return _descended(found.parser, found.words)
    finally:
        setattr(argparse.ArgumentParser, "parse_args", kept)  # noqa: B010
    return None


def tree(entries: Mapping[str, EntryPoint], says: Callable[[EntryPoint], str]) -> Node:
    """All commands; one with missing dependencies completes only its name."""
    root = Node(subs={"help": Node("the list of commands")})
    for name, entry in sorted(entries.items()):
        node = root.subs[name] = Node(says(entry))
        try:
            command: Command = getattr(importlib.import_module(entry.module), entry.attr)
        except ImportError:
            continue
        own = parser_of(command)
        if own is not None:
            fill(node, own)
        for tool in BEFORE_ARGPARSE.get(name, ()):
            parser = parser_of(command, (tool,))
            node.subs[tool] = fill(Node(), parser) if parser is not None else Node()
    return root


def fill(node: Node, parser: argparse.ArgumentParser) -> Node:
    """Options, arguments and sub-commands of a parser."""
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            helps = {choice.dest: choice.help or "" for choice in action._choices_actions}
            for name, sub in action.choices.items():
                node.subs[name] = fill(Node(helps.get(name, "")), sub)
        elif action.option_strings:
            node.options.append(Option(tuple(action.option_strings), _words(action), _values(action)))
        elif action.choices is not None:
            node.words += tuple(map(str, action.choices))
        elif action.dest in CELLS or action.metavar in CELLS:
            node.cell = True
        else:
            node.file = True
    return node


def _descended(parser: argparse.ArgumentParser, words: Sequence[str]) -> argparse.ArgumentParser:
    """`learn line` reads with the parser of `line learn`."""
    for word in words:
        for action in parser._actions:
            if isinstance(action, argparse._SubParsersAction) and word in action.choices:
                parser = action.choices[word]
                break
    return parser


def _words(action: argparse.Action) -> str:
    text = action.help or ""
    return "" if text == argparse.SUPPRESS else text.replace("%(default)s", str(action.default)).replace("%%", "%")


def _values(action: argparse.Action) -> tuple[str, ...] | None:
    if action.nargs == 0:
        return None
    return tuple(map(str, action.choices)) if action.choices is not None else ()
