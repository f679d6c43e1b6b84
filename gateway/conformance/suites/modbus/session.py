"""A Modbus server at a port: readable addresses are discovered, writable ones are stated by the bench."""

import struct
from collections.abc import Mapping

from gateway.conformance.framework.host import Host
from gateway.conformance.framework.peers import Peers
from gateway.conformance.suites.modbus.tester import TABLES, ModbusSetup, ModbusTester
from gateway.conformance.suites.opening import Opened
from gateway.conformance.suites.supply import modbus_supply
from gateway.links.serial.tool_wire import VirtualWire, Wire
from gateway.pure.conformance.verdict import Ended
from protocols.base.machine import Machine, Ns, ms

PLACES = (0, 1, 10, 16, 100, 256, 1000, 4096, 30000, 40000)  # where a table is looked for
PROBES = {7: b"\x07", 8: b"\x08\x00\x00\xa5\x37", 11: b"\x0b", 12: b"\x0c", 17: b"\x11", 43: b"\x2b\x0e\x01\x00"}
MOST = {1: 2000, 2: 2000, 3: 125, 4: 125}


class ModbusSession:
    """One run."""

    def __init__(self, opened: Opened, rtu: bool) -> None:
        self._opened, self._rtu = opened, rtu
        opened.pace = rtu  # a TCP stream has no characters
        bench = opened.bench
        self.assumed: list[str] = []
        self.pics: dict[str, object] = dict(opened.pics)
        known = {key: value for key, value in bench.known.items() if isinstance(value, int)}
        self.setup = ModbusSetup(holding=bench.touch.get("holding", ()), coils=bench.touch.get("coils", ()), known=known)
        for name in ("unit", "missing_unit"):
            if isinstance(value := bench.link.get(name), int):
                setattr(self.setup, name.removesuffix("_unit"), value)
        times = bench.link.get("times")
        wait = bench.link.get("answer_ms", times.get("answer_ms") if isinstance(times, dict) else None)
        if isinstance(wait, (int, float)):
            self.setup.wait = ms(wait)
        self._host = Host(opened.witness, Peers(bench.url) if opened.make is None else None)
        self._wire: Wire | None = None
        self._one_machine = False
        self.tester = ModbusTester(self._connect, self.setup, rtu, self._host)

    def _switched(self) -> None:
        """The supply: a machine is not recreated here, a port in real time is reopened."""
        self._one_machine = True
        if not self.tester.wire.simulated:
            self._wire = None

    def _connect(self) -> Wire:
        """A line is opened once; a TCP connection as often as needed.  A machine loses its port and keeps its values; one that has not
        answered since is recreated.
        """
        if self._rtu and self._wire is not None:
            return self._wire
        if isinstance(self._wire, VirtualWire) and (self._answered() or self._one_machine):
            wire, device = self._wire, self._wire.station
            while wire.hear(wire.now()) is not None:
                pass  # what was sent before arrives before the end
            wire.act(lambda now: _lost(device, now))
            return wire
        self._wire = self._opened.wire()
        return self._wire

    def _answered(self) -> bool:
        return self.tester.answered

    def discover(self) -> Mapping[str, object]:
        setup, pics = self.setup, self.pics
        setup.pics = pics
        self.tester.supply = modbus_supply(self._opened, self.tester, self._switched)
        pics["power"] = self.tester.supply is not None
        known = {"coil": 1, "discrete": 2, "holding": 3, "input": 4}
        named = {1: list(setup.coils[:1]), 2: [], 3: list(setup.holding[:1]), 4: []}
        for key in setup.known:
            named[known[key.partition(":")[0]]].append(int(key.partition(":")[2]))
        for function, table in TABLES.items():
            if pics.get(table) is not False:
                self._look(function, table, named[function])
        for function, request in PROBES.items():
            pics.setdefault(f"fc{function}", self._offered(request))
        pics["known"] = bool(setup.known)
        pics["write_holding"] = bool(setup.holding) and bool(pics.get("holding_registers"))
        pics["write_coils"] = bool(setup.coils) and bool(pics.get("coils"))
        self._writes()
        pics["tcp"], pics["several"] = not self._rtu, not self._rtu and not self.tester.wire.simulated
        pics["broadcast_stated"] = "broadcast" in self._opened.pics
        pics.setdefault("broadcast", True)
        return pics

    def _writes(self) -> None:
        """Whether writing functions are offered: the present values are written back."""
        setup, pics = self.setup, self.pics
        if pics["write_coils"]:
            at = setup.coils[0]
            bit = self._bit(at)
            pics.setdefault("fc5", self._offered(struct.pack(">BHH", 5, at, 0xFF00 if bit else 0)))
            pics.setdefault("fc15", self._offered(struct.pack(">BHHBB", 15, at, 1, 1, bit)))
        if pics["write_holding"]:
            at = setup.holding[0]
            value = self._word(at)
            pics.setdefault("fc6", self._offered(struct.pack(">BHH", 6, at, value)))
            pics.setdefault("fc16", self._offered(struct.pack(">BHHBH", 16, at, 1, 2, value)))
            pics.setdefault("fc22", self._offered(struct.pack(">BHHH", 22, at, 0xFFFF, 0)))
            pics.setdefault("fc23", self._offered(struct.pack(">BHHHHBH", 23, at, 1, at, 1, 2, value)))

    def _bit(self, at: int) -> int:
        try:
            return self.tester.bits(1, at, 1)[0]
        except Ended:
            return 0

    def _word(self, at: int) -> int:
        try:
            return self.tester.registers(3, at, 1)[0]
        except Ended:
            return 0

    def _look(self, function: int, table: str, named: list[int]) -> None:
        """A place that can be read, and how many from there."""
        silent = 0
        for place in (*named, *PLACES):
            got = self._asked(struct.pack(">BHH", function, place, 1))
            silent += not got
            if got and not got[0] & 0x80:
                self.setup.base[function] = place
                self.setup.span[function] = self._span(function, place)
                self.pics.setdefault(table, True)
                return
            if silent > 1 or got[1:] == b"\x01":
                break
        self.pics.setdefault(table, False)
        self.assumed.append(f"no {table.replace('_', ' ')}: none can be read")

    def _span(self, function: int, place: int) -> int:
        low, high = 1, MOST[function] + 1
        while high - low > 1:
            middle = (low + high) // 2
            got = self._asked(struct.pack(">BHH", function, place, middle))
            if got and not got[0] & 0x80:
                low = middle
            else:
                high = middle
        return low

    def _asked(self, pdu: bytes) -> bytes:
        try:
            return self.tester.steady(pdu)
        except Ended:
            return b""

    def _offered(self, request: bytes) -> bool:
        """Answered, and not with 01: an own fault of the function is judged by its purposes."""
        got = self._asked(request)
        return bool(got) and not (got[0] & 0x80 and got[1:] == b"\x01")

    # ---- for the runner
    def self_check(self) -> Mapping[str, object]:
        wire = self.tester.wire
        jitter = self._opened.witness.late() if self._opened.witness is not None else 0
        start = self.tester.now()
        got = self._asked(b"\x03\x00\x00\x00\x01")
        took = self.tester.now() - start
        return {
            "clock": "virtual" if wire.simulated else "monotonic clock of this host, at the port",
            "echo": False,
            "latency_ms": round(took / 1e6, 3) if got else None,
            "jitter_ms": round(jitter / 1e6, 3),
        }

    def begin(self, clean: bool) -> None:
        self.tester.quiet()
        self._host.begin()
        self.tester.begin()

    def alive(self) -> None:
        self.tester.alive()

    def now(self) -> Ns:
        return self.tester.now()

    def close(self) -> None:
        self.tester.drop()


def _lost(device: Machine[object], now: Ns) -> None:
    device.lost(now)
