"""Emulated CiA 401 couplers of one bus; started by a simulated run beside the emulated drives.

    python -m gateway.simulation.drives.couplers --bus broker:NAME --name NAME --nodes 20,21

Commands on runtime_dir()/emulator-NAME.sock, as those of the emulated drives:

    {"do": "state"}                                          terminals of every node
    {"do": "wire", "node": 20, "channel": 0, "on": true}     a level at an input; "on": null: it follows its output again
"""

import argparse
import select
import signal
import time

from drivers.emulator.io.coupler_401 import OCTETS, Couplers
from drivers.ports.base import CanPort, PortError
from drivers.ports.can.open import open_can
from gateway.files.find import find_config
from gateway.runtime.realtime import die_with_parent, go_realtime
from gateway.simulation.control_requests import Answer, BadCommandError, Command
from gateway.simulation.drives.control import ControlServer
from protocols.canopen import eds

SHEET = "axisgate_401.eds"
PRIORITY = 20  # as the emulated drives
RETRY_NS = 200_000_000


class CouplerLoop:
    """One port, all couplers on it."""

    def __init__(self, bus: str, name: str, nodes: list[int]) -> None:
        sheet, _ = eds.parse(find_config(SHEET, "drives").read_text())
        self.couplers = Couplers(dict.fromkeys(nodes, sheet))
        self._bus = bus
        self._port: CanPort | None = None
        self._retry = 0
        self._said = ""
        self._epoll = select.epoll()
        self._control = ControlServer(name, self._epoll, self._carry)
        self._stop = False
        signal.signal(signal.SIGTERM, self._on_signal)

    def _on_signal(self, number: int, frame: object) -> None:
        self._stop = True

    def run(self) -> None:
        """Until SIGTERM; a lost bus is reopened."""
        ready = False
        while not self._stop:
            now = time.monotonic_ns()
            if self._port is None and now >= self._retry and self._open(now) and not ready:
                ready = True
                print("ready", flush=True)
            due = self.couplers.deadline()
            wait = 0.05 if due is None else min(0.05, max(0.0, (due - now) / 1e9))
            events = self._epoll.poll(wait)
            self._turn()
            for fd, _ in events:
                self._control.ready(fd)
            self._turn()
        self._control.close()

    def _open(self, now: int) -> bool:
        self._retry = now + RETRY_NS
        try:
            self._port = open_can(self._bus)
        except PortError as error:
            self._say(str(error))
            return False
        self._epoll.register(self._port.fileno(), select.EPOLLIN)
        return True

    def _turn(self) -> None:
        now = time.monotonic_ns()
        if self._port is None:
            return
        try:
            self.couplers.receive(self._port.receive(), now)
            self.couplers.wake(now)
            frames = self.couplers.take_output()
            if frames:
                self._port.send(frames)
        except PortError as error:
            self._epoll.unregister(self._port.fileno())
            self._port.close()
            self._port = None
            self._say(str(error))

    def _say(self, words: str) -> None:
        if words != self._said:
            self._said = words
            print(words, flush=True)

    def _carry(self, command: Command) -> Answer:
        match command.get("do"):
            case "state":
                nodes = {
                    str(number): {"state": node.state.name, "outputs": self.couplers.terminals[number].outputs.hex()}
                    for number, node in self.couplers.nodes.items()
                }
                return {"nodes": nodes}
            case "wire":
                node, channel, level = command.get("node"), command.get("channel"), command.get("on")
                if node not in self.couplers.nodes or not isinstance(node, int):
                    raise BadCommandError(f"node {node}: there is {', '.join(map(str, self.couplers.nodes))}")
                if not isinstance(channel, int) or not 0 <= channel < 8 * OCTETS or not (level is None or isinstance(level, bool)):
                    raise BadCommandError(f"channel {channel!r}, on {level!r}: 0..{8 * OCTETS - 1}, true, false or null")
                self.couplers.wire(node, channel, level, time.monotonic_ns())
                return {}
        raise BadCommandError(f"{command.get('do')!r} is not a command; known: state, wire")


def main(argv: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="axisgate couplers", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bus", required=True, help="broker:NAME or socketcan:IFACE")
    parser.add_argument("--name", required=True)
    parser.add_argument("--nodes", required=True, help="20,21")
    options = parser.parse_args(argv)
    die_with_parent(number=signal.SIGKILL)
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the supervisor's business
    loop = CouplerLoop(options.bus, options.name, [int(node) for node in options.nodes.split(",")])
    for warning in go_realtime(PRIORITY):
        print(warning, flush=True)
    loop.run()
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
