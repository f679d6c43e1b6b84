"""The portal on the line of the S5: its PLC selects positions and programs by one number (AX-406)."""

from gateway.files.find import find_config, read_text

OWNER = 'owner = { "3" = "plc" }\n'
ASSUMED = 'assume = ["EMSTOP_OK_RCI", "CTRL_ALLOW_RCI", "FEED_HOLD_N_RCI", "TRAVEL_ALLOW_RCI"]\n'
NUMBER = '  { at = "DW 6",   type = "KF",  to = "move.number" },\n'
SELECTS = """
[handshake.move]
pattern = "number-select"
done    = "DB11.D0.9"
refused = "DB11.D0.15"

[[position]]
number = 7
at     = { X = 100.0, Z = 40.0 }
speed  = 50.0

"""


def numbered_cell(program: str = "portal-u-cycle", number: int = 1) -> str:
    """Text of the cell; `program`: file of the only [[program]], with that number."""
    portal, s5 = (read_text(find_config(name, "cells")) for name in ("portal", "s5-rk512"))
    line = s5[s5.index("[[line]]") : s5.index("# ---- how the old program starts a move")]
    line = line.replace('"/dev/serial/by-id/usb-isolated-converter-if00"', '"sim"')
    line = line.replace('  { at = "D 0.8",  type = "bit", to = "move.start" },\n', NUMBER)
    for old, near in (("60.0", "14.0"), ("55.0", "14.0"), ("40.0", "7.5"), ("12.0", "4.0")):  # beside the switches: a short search
        portal = portal.replace(f"start                = {old}", f"start                = {near}")
    head, rest = portal[: portal.index("[[modbus]]")], portal[portal.index("# ---- the robot and its programs") :]
    rest = rest.replace('number = 1\nfile   = "portal-u-cycle"', f'number = {number}\nfile   = "{program}"')
    return head.replace(OWNER, OWNER + ASSUMED) + line + SELECTS + rest
