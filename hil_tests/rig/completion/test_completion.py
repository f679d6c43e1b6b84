"""Completion as a real bash does it, and what the other shells are given: made of the installed commands' own parsers."""

import argparse
import pathlib
import re
import shutil
import subprocess
from importlib.metadata import entry_points

import pytest

from gateway.commands.catalogue import GROUP, first_line
from gateway.commands.completion import main
from gateway.tools.completion.parsers import Node, fill, parser_of, tree
from gateway.tools.completion.scripts import quoted, script

BASH = shutil.which("bash") or "/bin/bash"


@pytest.fixture(scope="module")
def root() -> Node:
    return tree({entry.name: entry for entry in entry_points(group=GROUP)}, first_line)


@pytest.fixture(scope="module")
def bash(root: Node, tmp_path_factory: pytest.TempPathFactory) -> pathlib.Path:
    path = tmp_path_factory.mktemp("bash") / "axisgate"
    path.write_text(script("bash", root, ["demo", "scara"]))
    return path


def completed(bash: pathlib.Path, *words: str) -> list[str]:
    """What bash offers for the last word, in a folder with one file `mine.toml`."""
    (bash.parent / "mine.toml").touch()
    asked = " ".join(quoted(word) for word in ("axisgate", *words))
    text = f'source {bash}; COMP_WORDS=({asked}); COMP_CWORD={len(words)}; _axisgate; printf "%s\\n" "${{COMPREPLY[@]}}"'
    done = subprocess.run([BASH, "--norc", "-c", text], capture_output=True, text=True, check=True, cwd=bash.parent, timeout=60)
    assert done.stderr == ""
    return [line for line in done.stdout.splitlines() if line]


def test_commands_tools_options_and_their_values(bash: pathlib.Path) -> None:
    assert completed(bash, "che") == ["check"]
    assert {"axis", "bus", "completion", "doctor", "run", "var"} <= set(completed(bash, ""))
    assert completed(bash, "bus", "inf") == ["infer"]
    assert completed(bash, "learn", "line", "--ta") == completed(bash, "line", "learn", "--ta") == ["--tap"]
    assert completed(bash, "scope", "rec") == ["record"]
    assert completed(bash, "run", "demo", "--sh") == ["--shadow"]
    assert {"--pendant", "--once", "--json"} <= set(completed(bash, "monitor", "--"))
    assert completed(bash, "monitor", "--tab", "s") == ["signals"]
    assert completed(bash, "drive", "loss") == ["loss-test"]
    assert completed(bash, "completion", "") == ["bash", "zsh", "fish"]
    assert completed(bash, "nosuch", "--js") == []


def test_cells_and_files(bash: pathlib.Path) -> None:
    assert completed(bash, "check", "s") == ["scara"]
    assert "mine.toml" in completed(bash, "check", "m")
    assert completed(bash, "scope", "plot", "x.scope", "-o", "mi") == ["mine.toml"]


def test_every_long_option_in_every_help_is_completed(root: Node) -> None:
    """The parser's own help is the judge: what -h prints is in the tree."""
    nodes = dict(root.walk())
    assert len(nodes) > 40
    for entry in entry_points(group=GROUP):
        parser = parser_of(entry.load())
        if parser is None:  # bus, learn: each tool has a parser of its own
            assert nodes[(entry.name,)].subs
            continue
        usage = set(re.findall(r"(?<![\w-])--[a-z][a-z0-9-]*", parser.format_usage()))
        assert usage <= {name for option in nodes[(entry.name,)].options for name in option.names}, entry.name


def test_zsh_and_fish_get_every_node(root: Node) -> None:
    zsh, fish = script("zsh", root, ["demo"]), script("fish", root, ["demo"])
    assert zsh.startswith("#compdef axisgate\n")
    for path, node in root.walk():
        name = " ".join(("axisgate", *path))
        assert f'        ("{name}") subs=(' in zsh
        for word in node.subs:
            assert f"complete -c axisgate -n '__axisgate_node {name}' -a '{word}'" in fish
    assert "compadd -- 'axes' 'signals' 'lines' 'errors'" in zsh and "-l tab -x -a 'axes signals lines errors" in fish


def test_quotes_and_percent_signs_of_a_help_survive() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--share", type=float, default=50.0, help="the axis' share, %% of all (default %(default)s)")
    node = fill(Node(), parser)
    assert node.options[1].help == "the axis' share, % of all (default 50.0)"
    text = script("fish", Node(subs={"x": node}), [])
    assert "-l share -r -d 'the axis'\\''s share" not in text and "-l share -r -d 'the axis'\\'' share, % of all (default 50.0)'" in text


def test_the_parser_is_itself_again_afterwards() -> None:
    kept = argparse.ArgumentParser.parse_args
    assert parser_of(main) is not None and argparse.ArgumentParser.parse_args is kept
    with pytest.raises(SystemExit):
        main(["tcsh"])
