"""Emulated digital I/O modules on a bus; started by a simulated run for a bus with protocol "rho3-io"."""

import argparse
import select
import signal
import time

from drivers.emulator.io.modules import IoModules
from drivers.ports.base import CanPort, PortError
from drivers.ports.can.open import open_can
from gateway.runtime.realtime import die_with_parent, go_realtime

RETRY_S = 0.2
PRIORITY = 20  # as the emulated drives


def main(argv: list[str] | None = None) -> int:
    """Run until SIGTERM; a lost bus is reopened."""
    parser = argparse.ArgumentParser(prog="axisgate io_modules", description=__doc__)
    parser.add_argument("--bus", required=True, help="broker:NAME or socketcan:IFACE")
    parser.add_argument("--inputs", default="", help="identifier:bytes,... in the order of P31")
    parser.add_argument("--outputs", default="", help="identifier,... in the order of P32")
    options = parser.parse_args(argv)
    die_with_parent(number=signal.SIGKILL)
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the supervisor's business
    pairs = [pair.split(":") for pair in options.inputs.split(",") if pair]
    inputs = {int(identifier): int(length) for identifier, length in pairs}
    modules = IoModules(inputs, [int(each) for each in options.outputs.split(",") if each])
    for warning in go_realtime(PRIORITY):
        print(warning, flush=True)
    ready = False
    while True:
        try:
            port = open_can(options.bus)
            if not ready:
                print("ready", flush=True)
                ready = True
            _serve(port, modules)
        except PortError as error:
            print(error, flush=True)
            time.sleep(RETRY_S)


def _serve(port: CanPort, modules: IoModules) -> None:
    """Until the bus is lost."""
    try:
        while True:
            select.select([port], (), ())
            answers = modules.receive(port.receive())
            if answers:
                port.send(answers)
    finally:
        port.close()


if __name__ == "__main__":
    raise SystemExit(main())
