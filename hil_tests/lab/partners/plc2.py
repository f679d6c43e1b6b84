"""PLC 2 of the demo: a newer program on Modbus TCP with the command block.  Its client is pymodbus, not ours."""

import logging
import struct
import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

from pymodbus.client import ModbusTcpClient
from pymodbus.exceptions import ConnectionException, ModbusIOException

COMMAND_AT, STATUS_AT, STATUS_WORDS = 1000, 1000, 58
CHAIN, CONTROL, FEED, RUN, TRAVEL = 24, 25, 26, 27, 28
ENABLE, DISABLE, REFERENCE, PTP, PTP_RELATIVE, STOP, RESUME, ABANDON, RESET, OVERRIDE, REQUEST, RELEASE = range(1, 13)
ACCEPTED, RUNNING, DONE, REFUSED, ABORTED = range(1, 6)
AXES = 12


@dataclass(frozen=True, slots=True)
class Status:
    """The status block as this PLC reads it."""

    toggle: bool
    state: int
    reason: int
    enabled: int
    in_position: int
    referenced: int
    fault: int
    override: float
    life: int
    owner: int
    actual: tuple[float, ...]
    lag: tuple[float, ...]

    @classmethod
    def of(cls, words: Sequence[int]) -> "Status":
        reals = struct.unpack(f">{2 * AXES}f", struct.pack(f">{4 * AXES}H", *words[10 : 10 + 4 * AXES]))
        head = [int(word) for word in words[:9]]
        return cls(
            toggle=bool(head[0] & 0x8000),
            state=head[0] & 0xFF,
            reason=head[1],
            enabled=head[2],
            in_position=head[3],
            referenced=head[4],
            fault=head[5],
            override=head[6] / 10_000,
            life=head[7],
            owner=head[8],
            actual=reals[0::2],
            lag=reals[1::2],
        )


@dataclass
class ModbusPlc:
    """Cyclic like a PLC: every 25 ms it writes its enabling coils and reads the status; commands are given between two cycles."""

    host: str
    port: int
    coils: dict[int, bool] = field(default_factory=lambda: dict.fromkeys((CHAIN, CONTROL, FEED, RUN, TRAVEL), True))
    status: Status | None = None
    cycles: int = 0
    reconnects: int = 0

    def __post_init__(self) -> None:
        logging.getLogger("pymodbus").setLevel(logging.CRITICAL)  # it would report every refused connection of a restart
        self._client: Any = ModbusTcpClient(self.host, port=self.port, timeout=1.0, retries=0)  # its annotations are not whole
        self._lock = threading.Lock()
        self._toggle = False
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="plc2", daemon=True)

    def start(self) -> None:
        self._thread.start()

    def stop(self) -> None:
        self._stop.set()
        self._thread.join(3)
        self._client.close()

    def _run(self) -> None:
        while not self._stop.wait(0.025):
            try:
                with self._lock:
                    self._cycle()
            except (ConnectionException, ModbusIOException, OSError):
                with self._lock:  # a command may be on its way
                    self._client.close()
                self.status = None
                self._stop.wait(0.1)

    def _cycle(self) -> None:
        if not self._client.connected:
            if not self._client.connect():
                raise ConnectionException("not there")
            self.reconnects += 1
        self._client.write_coils(CHAIN, [self.coils[n] for n in range(CHAIN, TRAVEL + 1)])
        answer = self._client.read_input_registers(STATUS_AT, count=STATUS_WORDS)
        if answer.isError():
            raise ModbusIOException(str(answer))
        self.status = Status.of(answer.registers)
        self.cycles += 1

    # ---- what its program does ---------------------------------------------------------------------------------------
    def send(
        self, code: int, mask: int = 0, velocity: float = 1.0, targets: Sequence[float] | bytes = (), acceleration: float = 1.0
    ) -> None:
        """Write the command block in one FC16, toggle changed.  `targets` as bytes: raw words, for numbers in a wrong format."""
        raw = targets if isinstance(targets, bytes) else struct.pack(f">{len(targets)}f", *targets)
        raw = raw.ljust(4 * AXES, b"\0")
        with self._lock:
            self._toggle = not self._toggle
            head = [(0x8000 if self._toggle else 0) | code, mask, round(velocity * 10_000), round(acceleration * 10_000)]
            answer = self._client.write_registers(COMMAND_AT, [*head, *struct.unpack(f">{2 * AXES}H", raw)])
            if answer.isError():
                raise ModbusIOException(str(answer))
            self.status = None

    def command(
        self, code: int, mask: int = 0, velocity: float = 1.0, targets: Sequence[float] | bytes = (), timeout_s: float = 20.0
    ) -> Status:
        """send, then wait for the outcome of that very command."""
        self.send(code, mask, velocity, targets)
        return self.wait(lambda s: s.toggle == self._toggle and s.state in (DONE, REFUSED, ABORTED), timeout_s)

    def synchronise(self) -> None:
        """After a start the first block is only adopted; this one asks for nothing."""
        self.send(0)
        self.wait(lambda s: s.toggle == self._toggle, 5.0)

    def wait(self, holds: Callable[[Status], bool], timeout_s: float) -> Status:
        """The first status for which it holds; TimeoutError with the last one otherwise."""
        until = time.monotonic() + timeout_s
        last = None
        while time.monotonic() < until:
            last = self.status or last
            if self.status is not None and holds(self.status):
                return self.status
            time.sleep(0.005)
        raise TimeoutError(f"PLC 2 waited {timeout_s:g} s in vain; last status {last}")
