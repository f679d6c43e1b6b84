"""axisgate bus replay: a recorded bus again, at its own pace or faster.  Never on a bus that moves a machine."""

import argparse
import pathlib
import time

import can

from gateway.tools.bus.logs import READABLE, BadLog, message_of, read_log
from gateway.tools.bus.ports import FORM, NoBus, open_bus
from gateway.tools.command_support import DONE, ENVIRONMENT, FINDING, USAGE
from gateway.tools.usage_language import complain
from protocols.base.machine import Frame

EXAMPLES = f"""examples:
  axisgate bus replay living.blf socketcan:vcan0
  axisgate bus replay living.blf broker:lab --only 100,210,220       the old controller's side only
  axisgate bus replay living.log broker:lab --speed 10
readable: {", ".join(READABLE)}; a bus is {FORM}
exit code: 0 done, 1 frames were refused, 2 command line or file, 3 no such bus"""
FULL_S = 0.1  # how long one frame may wait for room on the way out


def main(argv: list[str]) -> int:
    parser = argparse.ArgumentParser(
        prog="axisgate bus replay", description=__doc__, epilog=EXAMPLES, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("file", type=pathlib.Path, help="recording")
    parser.add_argument("bus", help=FORM)
    parser.add_argument("--only", default="", help="identifiers, comma between (decimal, or hexadecimal as 0x64)")
    parser.add_argument("--speed", type=float, default=1.0, help="factor on the recorded pace; 0: as fast as the bus accepts it")
    parser.add_argument("--bitrate", type=int, default=1_000_000, help="bit/s (default %(default)s)")
    arguments = parser.parse_args(argv)
    try:
        only = {int(text, 0) for text in arguments.only.split(",") if text}
        frames = [frame for frame in read_log(arguments.file) if not only or frame.identifier in only]
        with open_bus(arguments.bus, arguments.bitrate) as bus:
            sent, refused, late = play(frames, bus, arguments.speed)
    except (BadLog, ValueError) as error:
        complain("bus replay", error)
        return USAGE
    except NoBus as error:
        complain("bus replay", error)
        return ENVIRONMENT
    except OSError as error:
        complain("bus replay", f"{arguments.file}: {error.strerror or error}")
        return USAGE
    print(f"{sent} of {len(frames)} frames sent, {refused} refused, worst {late * 1e3:.2f} ms late")
    return FINDING if refused else DONE


def play(frames: list[Frame], bus: can.BusABC, speed: float) -> tuple[int, int, float]:
    """(sent, refused, worst lateness in s)."""
    if not frames:
        return 0, 0, 0.0
    start, first, refused, late = time.monotonic(), frames[0].stamp_ns, 0, 0.0
    for frame in frames:
        if speed:
            due = start + (frame.stamp_ns - first) / 1e9 / speed
            left = due - time.monotonic()
            if left > 0:
                time.sleep(left)
            late = max(late, time.monotonic() - due)
        try:
            bus.send(message_of(frame), FULL_S)
        except can.CanOperationError:
            refused += 1
    return len(frames) - refused, refused, late
