"""axisgate bus send: one frame, an NMT command, an SDO from the shell; --echo measures the adapter.  Beside a running cycle never."""

import argparse
import sys
import time

import can
import canopen
from canopen.sdo.exceptions import SdoError

from drivers.drives.masters import masters_in
from drivers.ports.can.wire import EFF_FLAG
from gateway.links.canopen.listen_first import END_IT, LISTEN_S
from gateway.links.canopen.sdo_client import bounded_upload
from gateway.tools.bus.logs import message_of
from gateway.tools.bus.ports import FORM, NoBus, open_bus
from gateway.tools.command_support import DONE, ENVIRONMENT, FINDING, USAGE
from gateway.tools.usage_language import complain
from protocols.base.machine import Frame
from protocols.canopen.nmt import Command, command

NMT = {"start": Command.START, "stop": Command.STOP, "pre-operational": Command.PRE_OPERATIONAL, "reset-node": Command.RESET_NODE,
       "reset-communication": Command.RESET_COMMUNICATION}  # fmt: skip
TYPES = {"u8": (1, False), "u16": (2, False), "u32": (4, False), "i8": (1, True), "i16": (2, True), "i32": (4, True)}
EXAMPLES = f"""examples:
  axisgate bus send socketcan:can0 --frame 201#0600            cansend's form: identifier in hexadecimals # data
  axisgate bus send socketcan:can0 --nmt start --node 3
  axisgate bus send socketcan:can0 --node 3 --read 1018:1      and: --node 3 --write 6060:0 i8 8
  axisgate bus send socketcan:can0 --echo 1000                 round trip of own frames through the adapter
a bus is {FORM}
exit code: 0 done, 1 refused or no answer, 2 command line, 3 no such bus"""


def main(argv: list[str]) -> int:
    parser = argparse.ArgumentParser(
        prog="axisgate bus send", description=__doc__, epilog=EXAMPLES, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("bus", help=FORM)
    what = parser.add_mutually_exclusive_group(required=True)
    what.add_argument("--frame", metavar="ID#DATA", help="one frame")
    what.add_argument("--nmt", choices=sorted(NMT), help="NMT command")
    what.add_argument("--read", metavar="INDEX:SUB", help="SDO read, hexadecimals")
    what.add_argument("--write", nargs=3, metavar=("INDEX:SUB", "TYPE", "VALUE"), help=f"SDO write; types {', '.join(TYPES)}")
    what.add_argument("--echo", type=int, metavar="N", help="N frames (identifier 7FFh) and back")
    parser.add_argument("--node", type=int, default=0, help="0: all (NMT only)")
    parser.add_argument("--beside", action="store_true", help="--nmt also where another master is heard on the bus")
    parser.add_argument("--bitrate", type=int, default=1_000_000, help="bit/s (default %(default)s)")
    arguments = parser.parse_args(argv)
    try:
        with open_bus(arguments.bus, arguments.bitrate, own=arguments.echo is not None) as bus:
            return act(bus, arguments)
    except NoBus as error:
        complain("bus send", error)
        return ENVIRONMENT
    except ValueError as error:
        complain("bus send", error)
        return USAGE
    except (SdoError, can.CanError) as error:
        complain("bus send", error)
        return FINDING


def act(bus: can.BusABC, arguments: argparse.Namespace) -> int:
    if arguments.echo is not None:
        return echo(bus, arguments.echo)
    if arguments.frame:
        bus.send(message_of(frame_of_text(arguments.frame)), 1.0)
        return DONE
    if arguments.nmt:
        if not arguments.beside:
            look_first(bus, arguments.bus)
        bus.send(message_of(command(NMT[arguments.nmt], arguments.node)), 1.0)
        return DONE
    if not 1 <= arguments.node <= 127:
        raise ValueError(f"--node {arguments.node}: an SDO is sent to a node 1..127")
    return sdo(bus, arguments)


def look_first(bus: can.BusABC, url: str) -> None:
    """Raises NoBus if a master is active: an NMT command of a second one would take its drives away."""
    heard: list[Frame] = []
    end = time.monotonic() + LISTEN_S
    while (left := end - time.monotonic()) > 0:
        message = bus.recv(left)
        if message is not None and not message.is_extended_id and not message.is_error_frame:
            heard.append(Frame(message.arbitration_id, bytes(message.data)))
    if words := masters_in(heard, "canopen"):
        raise NoBus(f"{url}: another master is active on this bus: {words}; {END_IT}, or send it anyway with --beside")


def frame_of_text(text: str) -> Frame:
    """ "201#0600" as in cansend; eight digits of identifier: an extended frame.  Raises ValueError."""
    identifier, mark, data = text.partition("#")
    try:
        number, payload = int(identifier, 16), bytes.fromhex(data.replace(".", ""))
    except ValueError as error:
        raise ValueError(f"{text!r}: a frame is ID#DATA in hexadecimals, e.g. 201#0600") from error
    most = 0x1FFFFFFF if len(identifier) == 8 else 0x7FF
    if not mark or number > most or len(payload) > 8:
        raise ValueError(f"{text!r}: identifier 0..{most:X}h and at most 8 bytes")
    return Frame(number | (EFF_FLAG if len(identifier) == 8 else 0), payload)


def sdo(bus: can.BusABC, arguments: argparse.Namespace) -> int:
    place = arguments.read or arguments.write[0]
    try:
        index, sub = (int(part, 16) for part in place.split(":"))
    except ValueError as error:
        raise ValueError(f"{place!r}: an object is INDEX:SUB in hexadecimals, e.g. 1018:1") from error
    network = canopen.Network(bus)
    network.connect()
    try:
        client = network.add_node(arguments.node).sdo
        if arguments.read:
            data = bounded_upload(client, index, sub)
            print(f"{index:04X}h:{sub:02X} = {value_text(data)}")
        else:
            client.download(index, sub, encoded(arguments.write[1], arguments.write[2]))
            print(f"{index:04X}h:{sub:02X} written")
    finally:
        if network.notifier is not None:
            network.notifier.stop()
    return DONE


def encoded(kind: str, value: str) -> bytes:
    """Raises ValueError with the range."""
    if kind not in TYPES:
        raise ValueError(f"type {kind!r}: {', '.join(TYPES)}")
    size, signed = TYPES[kind]
    low, high = (-(1 << 8 * size - 1), (1 << 8 * size - 1) - 1) if signed else (0, (1 << 8 * size) - 1)
    number = int(value, 0)
    if not low <= number <= high:
        raise ValueError(f"{value} does not fit {kind}: {low}..{high}")
    return number.to_bytes(size, "little", signed=signed)


def value_text(data: bytes) -> str:
    if len(data) in (1, 2, 4):
        return f"{int.from_bytes(data, 'little')} ({int.from_bytes(data, 'little'):0{2 * len(data)}X}h)"
    return f"{data.decode(errors='replace')!r} ({data.hex(' ')})"


def echo(bus: can.BusABC, count: int) -> int:
    """Round trip of own frames: the latency a cycle on this adapter must expect."""
    trips = []
    for number in range(count):
        start = time.perf_counter()
        bus.send(can.Message(arbitration_id=0x7FF, is_extended_id=False, data=number.to_bytes(8, "little")), 1.0)
        while (heard := bus.recv(1.0)) is not None:
            if heard.arbitration_id == 0x7FF and bytes(heard.data) == number.to_bytes(8, "little"):
                trips.append(time.perf_counter() - start)
                break
        else:
            print(f"no echo of frame {number + 1}: this adapter does not give own frames back", file=sys.stderr)
            return FINDING
    trips.sort()
    p50, p99, worst = (1e6 * trips[min(len(trips) - 1, int(share * len(trips)))] for share in (0.5, 0.99, 1.0))
    print(f"echo of {count} frames: p50 {p50:.0f} us, p99 {p99:.0f} us, worst {worst:.0f} us")
    return DONE
