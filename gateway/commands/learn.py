"""Draft a cell from a recording, `axisgate learn line TRACE`, or from a live line, `--tap A,B` (same as `axisgate line learn`)."""

import sys

from gateway.commands import line

USAGE = """usage: axisgate learn line TRACE [-o FILE]
       axisgate learn line --tap A,B [--seconds S] [--save TRACE] [-o FILE]   (live)

examples:
  axisgate learn line week.trace -o draft.toml                       a draft from a recording
  axisgate learn line --tap /dev/ttyUSB0,/dev/ttyUSB1                live, until Ctrl-C; it cannot send
  axisgate learn line --tap COM3,COM4 --seconds 3600 --save h.trace  an hour, kept for later
exit code: 0 a draft, 1 nothing to learn from, 2 command line or file, 3 no such port"""


def main(argv: list[str]) -> int:
    if argv[:1] == ["line"]:
        return line.main(["learn", *argv[1:]])
    wanted = argv[:1] in (["-h"], ["--help"])
    print(
        USAGE if wanted or not argv else f"axisgate learn: {argv[0]!r} is not in this version\n{USAGE}",
        file=sys.stdout if wanted else sys.stderr,
    )
    return 0 if wanted else 2
