"""What every command has: three examples in -h, exit codes, no colour, --json where it prints data; new commands are judged by the same."""

import contextlib
import io
import re
from importlib.metadata import EntryPoint, entry_points

import pytest

from gateway.commands.catalogue import GROUP, first_line
from gateway.tools.completion.parsers import Node, tree

ENTRIES = {entry.name: entry for entry in entry_points(group=GROUP)}
NO_DATA = {  # commands that print no data, and what they do instead
    "completion": "prints a script",
    "conformance new": "prints a case to edit",
    "conformance new-pics": "prints a file to edit",
    "emulate": "runs until it is ended",
    "fault": "gives one order to an emulator",
    "mapping": "reads and writes files of tables",
    "bus log": "writes a file of frames",
    "bus replay": "sends a file of frames",
    "bus send": "sends frames",
    "bus plan": "prints a cell to edit",
    "learn line": "prints a cell to edit",
    "line learn": "prints a cell to edit",
    "line export": "writes a file for another program",
    "scope export": "writes a file for another program",
    "lsp": "speaks with an editor",
    "dap": "speaks with an editor",
    "stop": "gives one order to a run",
    "release": "gives one order to a run",
}


def said(entry: EntryPoint, *words: str) -> tuple[object, str, str]:
    """Exit code, standard output, standard error of a command line in this process."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            code: object = entry.load()(list(words))
        except SystemExit as ended:
            code = ended.code
    return code, out.getvalue(), err.getvalue()


@pytest.mark.parametrize("name", sorted(ENTRIES))
def test_help_has_three_examples_and_no_colour(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("FORCE_COLOR", "1")
    code, told, _ = said(ENTRIES[name], "-h")
    assert code == 0 and "\033" not in told
    examples = told.partition("examples")[2]
    assert len(re.findall(rf"\baxisgate {name}\b", examples)) >= 3, told


@pytest.mark.parametrize("name", sorted(ENTRIES))
def test_a_command_line_that_is_none_is_exit_2_and_names_the_command(name: str) -> None:
    code, told, complaint = said(ENTRIES[name], "--no-such-option")
    assert (code, told) == (2, "")
    assert f"axisgate {name}" in complaint and ("usage:" in complaint or "there are" in complaint)


def test_data_is_printed_as_json_too() -> None:
    root: Node = tree(ENTRIES, first_line)
    ends = {" ".join(path): node for path, node in root.walk() if path and not node.subs and path != ("help",)}
    without = {name for name, node in ends.items() if not any("--json" in option.names for option in node.options)}
    assert without <= NO_DATA.keys(), "a new command that prints data has --json"
    assert NO_DATA.keys() <= ends.keys()
