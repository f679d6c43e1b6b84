"""Help of the commands (-h) in the user's language (AX-1796): `configs/texts/help.toml` has the German of the texts of the parsers."""

import argparse
import re
from collections.abc import Callable, Iterator

from gateway.files.texts import spoken

USAGE, AUFRUF = "usage: ", "Aufruf: "
EXAMPLE = re.compile(
    r"(\s*(?:axisgate|tshark) .*?\S\s{2,}|\s+)(\S.*)"
)  # a command with its explanation after two spaces, or an indented line
COMMAND = re.compile(r"\s*(axisgate|tshark|source|--)\b")  # typed text has no language

FormatHelp = Callable[[argparse.ArgumentParser], str]


def german_help(format_help: FormatHelp) -> FormatHelp:
    """Return format_help in German.  It replaces the texts in the parser: the command ends after its help."""

    def formatted(parser: argparse.ArgumentParser) -> str:
        german = spoken("help").german
        for group in parser._action_groups:
            group.title = german(group.title or "")
            group.description = german(group.description) if group.description else None
        for action in actions(parser):
            if action.help and action.help != argparse.SUPPRESS:
                action.help = german(action.help)
        if parser.description:
            parser.description = "\n\n".join(german(paragraph) for paragraph in paragraphs(parser.description))
        if parser.epilog:
            parser.epilog = "\n".join(_german_line(line) for line in parser.epilog.splitlines())
        return in_german_usage(format_help(parser))

    return formatted


def actions(parser: argparse.ArgumentParser) -> Iterator[argparse.Action]:
    """Entries of a parser's help: its options and arguments, and the tools below them."""
    for action in parser._actions:
        yield action
        if isinstance(action, argparse._SubParsersAction):
            yield from action._choices_actions


def paragraphs(description: str) -> list[str]:
    """A description without its line breaks."""
    return [" ".join(paragraph.split()) for paragraph in description.strip().split("\n\n")]


def explained(line: str) -> str:
    """The explanation in a line of the examples; empty if the line is only typed text."""
    found = EXAMPLE.fullmatch(line)
    words = found[2] if found else line
    return "" if COMMAND.match(words) or not words.strip() else words


def in_german_usage(text: str) -> str:
    """`usage: ` of the first lines; the lines below move with it."""
    head, blank, rest = text.partition("\n\n")
    if not head.startswith(USAGE):
        return text
    return AUFRUF + head.removeprefix(USAGE).replace("\n ", "\n  ") + blank + rest


def _german_line(line: str) -> str:
    words = explained(line)
    return line.removesuffix(words) + spoken("help").german(words) if words else line
