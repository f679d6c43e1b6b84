"""[power]: the device's supply is switched by commands, a relay, an operator, or by the machine under test itself."""

import socket
import struct
import subprocess
import sys
import threading
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import cast

from drivers.ports.open import tcp_address
from gateway.conformance.framework.bench_file import Bench
from gateway.pure.conformance.verdict import BenchFault
from protocols.base.machine import Ns, ms

Turn = Callable[[bool], None]  # INCONC where it cannot
Say = Callable[[str], None]
COMMAND_LIMIT_MS, OPERATOR_LIMIT_MS, RELAY_LIMIT_S = 20_000, 60_000, 3.0
OFF_TIME: Ns = ms(1000)  # capacitors of the device
BACK: Ns = ms(30_000)  # longest time from power to an answer, where the bench states none


@dataclass(slots=True)
class Supply:
    """A tester's access to the supply: `turn` returns once it is switched, and after on once the port is back."""

    turn: Turn
    pause: Callable[[Ns], object]
    back: Ns = BACK

    def cycle(self) -> None:
        """Off, a moment, on."""
        self.turn(False)
        self.pause(OFF_TIME)
        self.turn(True)


def switch_of(bench: Bench, say: Say) -> Turn | None:
    """As [power] states it; None without one."""
    table = bench.power
    limit = table.get("limit_ms")
    if "on" in table:
        return lambda on: _run(bench, cast(list[str], table["on" if on else "off"]), limit)
    if "command" in table:
        return lambda on: _run(bench, [*cast(list[str], table["command"]), _word(on)], limit)
    if "relay" in table:
        return lambda on: _relay(table, on)
    if "prompt" in table:
        return lambda on: _operator(str(table["prompt"]), on, limit, say)
    return None


def _word(on: bool) -> str:
    return "on" if on else "off"


def _run(bench: Bench, argv: list[str], limit: object) -> None:
    seconds = (limit if isinstance(limit, (int, float)) else COMMAND_LIMIT_MS) / 1e3
    try:
        done = subprocess.run(argv, cwd=bench.folder, timeout=seconds, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, check=False)
    except (OSError, subprocess.TimeoutExpired) as error:
        raise BenchFault(f"[power] {argv[0]}: {error}", "exit code 0", str(error)) from error
    if done.returncode:
        raise BenchFault(f"[power] {argv[0]} ended with {done.returncode}", "exit code 0", str(done.returncode))


def _relay(table: Mapping[str, object], on: bool) -> None:
    write_once(str(table["relay"]), {**table, "value": int(on is not table.get("inverted", False))}, "[power] relay")


def write_once(url: str, table: Mapping[str, object], what: str) -> None:
    """Write one coil or register of a Modbus TCP server; INCONC if the write is refused."""
    unit, value = cast(int, table.get("unit", 1)), cast(int, table.get("value", 1))
    if "holding" in table:
        pdu = struct.pack(">BHH", 6, cast(int, table["holding"]), value)
    else:
        pdu = struct.pack(">BHH", 5, cast(int, table.get("coil", 0)), 0xFF00 if value else 0)
    try:
        host, port = tcp_address(url)
        with socket.create_connection((host, port), RELAY_LIMIT_S) as connection:
            connection.sendall(struct.pack(">HHHB", 1, 0, len(pdu) + 1, unit) + pdu)
            got = connection.recv(260)
    except (OSError, ValueError) as error:
        raise BenchFault(f"{what}: {error}", "the write is answered", str(error)) from error
    if got[7:] != pdu:
        raise BenchFault(f"{what} was refused", pdu.hex(" ").upper(), got.hex(" ").upper() or "nothing")


def _operator(prompt: str, on: bool, limit: object, say: Say) -> None:
    """Enter confirms that it is done."""
    seconds = (limit if isinstance(limit, (int, float)) else OPERATOR_LIMIT_MS) / 1e3
    say(f"{prompt}: {_word(on).upper()}, then press Enter (at most {seconds:g} s)")
    typed: list[str] = []
    reader = threading.Thread(target=lambda: typed.append(sys.stdin.readline()), daemon=True)
    reader.start()
    reader.join(seconds)
    if not typed or not typed[0]:
        got = "nothing was pressed in time" if not typed else "no operator: standard input is closed"
        raise BenchFault(f"[power] prompt: {got}", f"the supply is {_word(on)}", got)
