"""Tools for CAN buses: compute the load, monitor, log, replay, send, analyse recordings of an old controller."""

import importlib
import sys

TOOLS = {  # name: module with main(argv) -> exit code, purpose
    "load": ("gateway.tools.bus.load", "compute the load of a cell, or of a recorded bus"),
    "monitor": ("gateway.tools.bus.monitor", "show frames of a live bus, decoded"),
    "log": ("gateway.tools.bus.log", "write a live bus to a file: candump, ASC, BLF, TRC, pcapng"),
    "replay": ("gateway.tools.bus.replay", "send a recorded bus again, at its original pace"),
    "send": ("gateway.tools.bus.send", "send one frame, NMT command, PDO or SDO"),
    "infer": ("gateway.tools.bus.infer", "infer the layout of an unknown drive bus from a recording"),
}
EXAMPLES = """examples:
  axisgate bus load demo.toml                       before running: us of the cycle, per cent, shortest cycle
  axisgate bus monitor socketcan:can0 --dbc servodyn_gc.dbc
  axisgate bus log socketcan:can0 -o living.blf     then: axisgate bus infer living.blf"""


def main(argv: list[str]) -> int:
    """Exit code of the tool; 2 for an unknown one."""
    if argv and argv[0] in TOOLS:
        return int(importlib.import_module(TOOLS[argv[0]][0]).main(argv[1:]))
    width = max(map(len, TOOLS))
    text = "\n".join(
        ["usage: axisgate bus TOOL ...", "", __doc__ or "", "", *(f"  {name:{width}}  {does}" for name, (_, does) in TOOLS.items()), ""]
    )
    asked = bool(argv) and argv[0] in ("-h", "--help")
    if not asked and argv:
        text = f"axisgate bus: no tool {argv[0]!r}; there are {', '.join(TOOLS)}\n"
        print(text, end="", file=sys.stderr)
        return 2
    print(text + "\n" + EXAMPLES, file=sys.stdout if asked else sys.stderr)
    return 0 if asked else 2
