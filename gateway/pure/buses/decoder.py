"""One line for a CANopen frame: type, sender, contents.  Source: CiA 301 (4.2) 7.2, 7.3.5; codes: protocols.canopen."""

from protocols.base.errors import ProtocolError
from protocols.base.machine import Frame
from protocols.canopen import cob_id as cobid
from protocols.canopen import emcy, sdo
from protocols.canopen.nmt import command_of, heartbeat_of

SIGNED_COMMANDS = {0x2F: 1, 0x2B: 2, 0x27: 3, 0x23: 4}  # expedited downloads: bytes of data
ABORT = 0x80
UPLOADS = {0x4F: 1, 0x4B: 2, 0x47: 3, 0x43: 4}


def canopen_text(frame: Frame) -> str:
    """ "TPDO1 of node 3: 37 06 10 27 00 00"; never raises on what a frame carries."""
    who = cobid.describe(frame.identifier)
    order = command_of(frame)
    if order is not None:
        return f"NMT {order[0].name.lower().replace('_', ' ')} {'all nodes' if order[1] == 0 else f'node {order[1]}'}"
    alive = heartbeat_of(frame)
    if alive is not None:
        return f"{who}: {alive[1].name.lower().replace('_', ' ')}"
    if who.startswith("EMCY"):
        return f"{who}: {_emergency(frame.data)}"
    if who.startswith("SDO"):
        return f"{who}: {_sdo(frame.data)}"
    return who + (f": {frame.data.hex(' ')}" if frame.data else "")


def _emergency(data: bytes) -> str:
    try:
        one = emcy.decode(data)
    except ProtocolError as error:
        return str(error)
    return f"{one.code:04X}h {emcy.meaning(one.code)}, register {int(one.register):02X}h, {one.detail.hex(' ')}"


def _sdo(data: bytes) -> str:
    """Object and value of what starts a transfer; segments and blocks by their command byte."""
    if len(data) != 8:
        return f"{data.hex(' ')} (an SDO has 8 bytes)"
    command, place = data[0], f"{int.from_bytes(data[1:3], 'little'):04X}h:{data[3]:02X}"
    if command in SIGNED_COMMANDS or command in UPLOADS:
        size = SIGNED_COMMANDS.get(command) or UPLOADS[command]
        verb = "write" if command in SIGNED_COMMANDS else "is"
        value = int.from_bytes(data[4 : 4 + size], "little")
        return f"{verb} {place} = {value} ({value:0{2 * size}X}h)"
    if command == ABORT:
        code = int.from_bytes(data[4:8], "little")
        return f"abort {place}: {code:08X}h {_abort(code)}"
    named = {0x40: f"read {place}", 0x60: f"written {place}", 0x21: f"write {place}, {int.from_bytes(data[4:8], 'little')} bytes",
             0x41: f"is {place}, {int.from_bytes(data[4:8], 'little')} bytes"}  # fmt: skip
    return named.get(command, f"segment {data.hex(' ')}")


def _abort(code: int) -> str:
    try:
        return sdo.Abort(code).name.lower().replace("_", " ")
    except ValueError:
        return "code unknown to CiA 301"
