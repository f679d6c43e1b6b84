"""docs/guide/trace.md: its commands print what stands there."""

import pathlib
import re
import shlex
import shutil
import subprocess
import sys

import pytest

from gateway.files.find import find_config
from hil_tests.rig.telegrams.test_telegram_guide import examples
from protocols.base.dialogue import parse, write

GUIDE = (pathlib.Path(__file__).parents[3] / "docs" / "guide" / "trace.md").read_text(encoding="utf-8")
RECORD = """# 999000000 ready baud=9600
1000000000 A 02
1000100000 B 10
1005000000 A 00004544050a0007ffff10031a
1005100000 B 10
"""


def told(words: list[str], folder: pathlib.Path) -> str:
    """What a person reads; `axisgate` without an installed script."""
    if words[0] == "axisgate":
        name = "gateway.commands.line_export" if words[1:3] == ["line", "export"] else ""
        call = f"import sys; from {name} import main; sys.exit(main(sys.argv[1:]))"
        words = [sys.executable, "-c", call, *words[3:]]
    done = subprocess.run(words, cwd=folder, capture_output=True, text=True, timeout=60, check=True)
    return done.stdout


@pytest.mark.tshark
def test_the_commands_print_what_the_guide_shows(tmp_path: pathlib.Path) -> None:
    (tmp_path / "line-plc1.rec").write_text(RECORD, encoding="ascii")
    shutil.copy(find_config("axisgate_3964r.lua", "wireshark"), tmp_path)
    commands = [each for block in re.findall(r"```console\n(.*?)```", GUIDE, re.DOTALL) for each in examples(block)]
    assert [shlex.join(words).split()[0] for words, _ in commands] == ["axisgate", "cat", "axisgate", "tshark"]
    for words, wanted in commands:
        assert told(words, tmp_path) == wanted


def test_the_journal_of_the_guide_is_one() -> None:
    (text,) = re.findall(r"```text\n(.*?)```", GUIDE, re.DOTALL)
    (dialogue,) = parse(text)
    assert len(dialogue.entries) == 5 and write([dialogue]) == text
