"""`axisgate line export TRACE -o FILE`: a line record or journal as pcapng for Wireshark, or as a journal (form of the test vectors)."""

import argparse
import datetime
import pathlib
import time

from drivers.ports.serial.line_format import parse_record
from gateway.pure.lines.pcapng import pcapng
from gateway.pure.lines.trace import Item, of_dialogue, of_runs, to_dialogue
from gateway.pure.lines.turns import turns
from gateway.tools.command_support import DONE, ENVIRONMENT, USAGE, of_file
from gateway.tools.usage_language import complain
from protocols.base.dialogue import parse, write
from protocols.base.errors import DecodeError
from protocols.base.machine import ms

EXAMPLES = """examples:
  axisgate line export line-plc1.rec -o plc1.pcapng             a line that `axisgate run CELL --sim --record FOLDER` recorded
  axisgate line export line-plc1.rec -o plc1.txt                as a journal: what the station at side B received and sent
  tshark -X lua_script:axisgate_3964r.lua -r plc1.pcapng        the dissector is in configs/wireshark
"""
BETWEEN_NS = ms(10_000)  # between the dialogues of one file: longer than any answer is waited for


def main(argv: list[str]) -> int:
    parser = argparse.ArgumentParser(
        prog="axisgate line export", description=__doc__, epilog=EXAMPLES, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("trace", type=pathlib.Path, help="record of a line (.rec), or a journal (dialogue file)")
    parser.add_argument("-o", "--output", type=pathlib.Path, required=True, help="FILE.pcapng, or FILE.txt for a journal")
    parser.add_argument(
        "--side",
        choices=("A", "B"),
        default="B",
        help="journal: the side whose received and sent bytes are written (default B: axisgate's end)",
    )
    parser.add_argument("--start", type=datetime.datetime.fromisoformat, help="wall-clock time of the first character, 2026-11-20T08:00:00")
    parser.add_argument("--no-check", action="store_true", help="procedure 3964: blocks have no check character")
    arguments = parser.parse_args(argv)
    try:
        items = read_trace(arguments.trace)
        if arguments.output.suffix == ".pcapng":
            packets = turns(items, block_check=not arguments.no_check)
            first = packets[0].first_ns if packets else 0
            comment = f"{arguments.trace.name}; written by axisgate line export"
            data = pcapng(packets, arguments.trace.stem, comment, offset_ns(arguments.start, first))
            arguments.output.write_bytes(data)
            print(f"{arguments.output}: {len(packets)} packets, {sum(len(packet.data) for packet in packets)} characters")
        else:
            dialogue = to_dialogue(items, arguments.trace.stem, arguments.side)
            arguments.output.write_text(
                f"# {arguments.trace.name}, written by axisgate line export\n\n{write([dialogue])}", encoding="utf-8"
            )
            print(f"{arguments.output}: {len(dialogue.entries)} entries")
    except OSError as error:
        complain("line export", of_file(error))
        return ENVIRONMENT
    except (DecodeError, KeyError) as error:
        complain("line export", error)
        return USAGE
    return DONE


def read_trace(path: pathlib.Path) -> list[Item]:
    """A line record or a journal, distinguished by the first word.  DecodeError: neither; OSError."""
    text = path.read_text(encoding="utf-8", errors="replace")
    words = next((line.split() for line in text.splitlines() if line.strip() and not line.startswith("#")), [])
    if words[:1] == ["dialogue"]:
        items: list[Item] = []
        for dialogue in parse(text):  # a dialogue without a start of its own begins at 0: put them in sequence
            items += of_dialogue(dialogue, items[-1].stamp_ns + BETWEEN_NS if items else 0)
        return items
    if words and not words[0].isdigit():
        raise DecodeError(f"{path}: neither a line record (<ns> <A|B> <hex>) nor a journal (dialogue NAME): {' '.join(words)[:60]!r}")
    return of_runs(parse_record(text.splitlines(keepends=True)).runs)


def offset_ns(start: datetime.datetime | None, first_ns: int) -> int:
    """Offset from monotonic stamps to Unix time: the given one, or by this computer's clocks now (valid until it restarts)."""
    if start is not None:
        return round(start.timestamp() * 1e9) - first_ns
    return time.time_ns() - time.monotonic_ns()
