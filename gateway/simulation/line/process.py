"""The line process: a serial cable between two ptys, with character time, damage, plug and adapters on command.

    python -m gateway.simulation.line.process --name NAME --baud 9600 [--bits 11] [--record FILE] [--plain A|B|AB]

Side A is runtime_dir()/NAME-a, side B NAME-b; ports open them as "pty:PATH".  Commands come as JSON lines through line-NAME.sock (client:
gateway.simulation.line.control); format of the record and of marks: drivers.ports.serial.line_format.  Marks and doubled FF are for ports
that ask for them (AX-1400); any other program reads characters as they are, and damage as a wrong character.  A --plain side offers no
marks.  Prints `ready`.  Exit codes: 0 stopped, 2 wrong arguments, 3 name taken or no pty to be had.
"""

import argparse
import contextlib
import os
import signal
import socket
import sys

from drivers.ports.base import PortError, runtime_dir
from gateway.simulation.line.cable import Line, Recorder
from gateway.simulation.line.commands import ControlSocket, carry_out

PRIORITY = 15  # SCHED_FIFO, below broker (30) and emulator (20)


def arguments(argv: list[str] | None) -> argparse.Namespace:
    """Command line."""
    parser = argparse.ArgumentParser(
        prog="python -m gateway.simulation.line.process", description="A simulated serial cable between two ptys."
    )
    parser.add_argument("--name", required=True, help="links are NAME-a and NAME-b in the runtime folder")
    parser.add_argument("--baud", type=int, default=9600, help="0: characters leave at once")
    parser.add_argument("--bits", type=int, default=11, help="bits of one character on the line (8E1: 11)")
    parser.add_argument("--record", help="file that gets every character of both directions with its stamp")
    parser.add_argument("--record-limit", type=int, default=1 << 29, metavar="BYTES", help="beyond it characters are only counted")
    parser.add_argument("--plain", default="", choices=("", "A", "B", "AB"), help="sides whose program does not read PARMRK marks")
    found = parser.parse_args(argv)
    if found.baud < 0 or not 7 <= found.bits <= 13:
        parser.error("--baud from 0, --bits 7..13")
    return found


def real_time(baud: int) -> str:
    """A paced line has priority over everything but a bus; an unpaced one would occupy a complete core."""
    if not baud:
        return "normal"
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(PRIORITY))
    except OSError:
        return "normal (real-time priority refused)"
    return f"fifo {PRIORITY}"


def main(argv: list[str] | None = None) -> int:
    """Runs until SIGTERM, SIGINT or the command `stop`."""
    wanted = arguments(argv)
    with contextlib.ExitStack() as stack:
        try:
            file = stack.enter_context(open(wanted.record, "w", encoding="ascii")) if wanted.record else None
            folder = runtime_dir()
            line = Line(folder, wanted.name, wanted.baud, wanted.bits, wanted.plain, Recorder(file, wanted.record_limit))
            control = ControlSocket(str(folder / f"line-{wanted.name}.sock"), line, carry_out)
            stack.callback(control.close)
            stack.callback(line.close)
            control.open()  # claims the name; PortError if it is in use
            line.open()
        except OSError as error:
            print(f"line {wanted.name}: {error.args[-1] if isinstance(error, PortError) else error}", file=sys.stderr)
            return 3
        _stop_on_signals(line)
        line.scheduling = real_time(wanted.baud)
        line.note(f"ready name={wanted.name} baud={wanted.baud} bits={wanted.bits} scheduling={line.scheduling.split()[0]}")
        line.recorder.flush()
        print("ready", flush=True)
        line.run()
    return 0


def _stop_on_signals(line: Line) -> None:
    woken, wake = socket.socketpair()
    for end in (woken, wake):
        end.setblocking(False)

    def stop(number: int, frame: object) -> None:
        line.stopping = True

    signal.set_wakeup_fd(wake.detach())
    for number in (signal.SIGTERM, signal.SIGINT):
        signal.signal(number, stop)
    line.watch(woken.detach(), lambda now: None)


if __name__ == "__main__":
    sys.exit(main())
