"""What a message tells a user to type exists: the command, and each of its options."""

import ast
import contextlib
import io
import pathlib
import re
import tomllib
from functools import cache
from importlib import import_module

ROOT = pathlib.Path(__file__).resolve().parents[3]
TYPED = re.compile(r"axisgate ([a-z][a-z0-9-]*)((?: (?!axisgate)[^\s;,:`'\"()]+)*? )(--[a-z][a-z0-9-]+)")


@cache
def commands() -> dict[str, str]:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())
    found: dict[str, str] = project["project"]["entry-points"]["axisgate.commands"]
    return found


@cache
def helped(command: str, *sub: str) -> str:
    """What `axisgate COMMAND SUB --help` prints; without a subcommand of that name, what the command prints."""
    module, _, name = commands()[command].partition(":")
    told = io.StringIO()
    with contextlib.redirect_stdout(told), contextlib.redirect_stderr(told), contextlib.suppress(SystemExit):
        getattr(import_module(module), name)([*sub, "--help"])
    return told.getvalue()


def typed() -> list[tuple[str, str, str, str]]:
    """Command, what stands before the option, option, place; of all string literals of the program."""
    found = []
    for folder in ("gateway", "drivers"):
        for path in sorted((ROOT / folder).rglob("*.py")):
            source = path.read_text()
            for literal in literals(source) if TYPED.search(source) else ():
                found += [(match[1], match[2], match[3], f"{path.relative_to(ROOT)}: {literal[:90]}") for match in TYPED.finditer(literal)]
    return found


def literals(source: str) -> list[str]:
    """Strings a program uses; docstrings are for developers."""
    tree = ast.parse(source)
    notes = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
    return [
        node.value for node in ast.walk(tree) if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in notes
    ]


def test_every_option_of_a_command_that_a_message_names_exists() -> None:
    wrong = []
    for command, between, option, place in typed():
        words = [word for word in between.split() if re.fullmatch(r"[a-z][a-z0-9-]*", word)]
        if command not in commands():
            wrong.append(f"no command {command}: {place}")
        elif not any(re.search(rf"{option}\b", page) for page in (helped(command), *(helped(command, word) for word in words[:1]))):
            wrong.append(f"axisgate {command} knows no {option}: {place}")
    assert len(typed()) > 5
    assert wrong == []
