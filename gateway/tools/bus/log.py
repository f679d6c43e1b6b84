"""axisgate bus log: a live bus into a file; the ending decides the form."""

import argparse
import pathlib

from gateway.tools.bus.logs import WRITABLE, BadLog, FdFrame, LogWriter
from gateway.tools.bus.monitor import Summary, live
from gateway.tools.bus.ports import FORM, NoBus, open_bus
from gateway.tools.command_support import DONE, ENVIRONMENT, USAGE
from gateway.tools.usage_language import complain

EXAMPLES = f"""examples:
  axisgate bus log socketcan:can0 -o living.blf                 until Ctrl-C
  axisgate bus log broker:demo-drives -o demo.pcapng --seconds 10
  axisgate bus log pcan:PCAN_USBBUS1 -o axis3.trc --bitrate 500000
forms: {", ".join(WRITABLE)}; a bus is {FORM}
exit code: 0 done, 2 command line, 3 the bus or the file cannot be opened"""


def main(argv: list[str]) -> int:
    parser = argparse.ArgumentParser(
        prog="axisgate bus log", description=__doc__, epilog=EXAMPLES, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("bus", help=FORM)
    parser.add_argument("-o", "--output", type=pathlib.Path, required=True, help="file")
    parser.add_argument("--bitrate", type=int, default=1_000_000, help="bit/s (default %(default)s)")
    parser.add_argument("--seconds", type=float, help="end after this time")
    arguments = parser.parse_args(argv)
    try:
        writer = LogWriter(arguments.output, arguments.bus)
    except BadLog as error:
        complain("bus log", error)
        return USAGE
    except OSError as error:
        complain("bus log", f"{arguments.output}: {error.strerror}")
        return ENVIRONMENT
    count = fd = 0
    summary = Summary()
    try:
        with open_bus(arguments.bus, arguments.bitrate, fd=True) as bus:
            for frame in live(bus, arguments.seconds, summary):
                if isinstance(frame, FdFrame):
                    fd += 1
                    continue
                writer.put(frame)
                count += 1
    except NoBus as error:
        complain("bus log", error)
        return ENVIRONMENT
    finally:
        writer.close()
    passed_over = f", {fd} frames of CAN FD passed over" if fd else ""
    print(f"{count} frames in {arguments.output}, {summary.errors} error frames{passed_over}")
    print(f"next: axisgate bus monitor --from {arguments.output} --summary")
    return DONE
