"""What the integrated PLC costs: a scan of 1,000 commands as generated functions and with the test display, translating 10,000 commands."""

import time
from collections.abc import Callable

from gateway.pure.languages.plc.plc import Plc
from hil_tests.bench.figure_row import EMPTY_LOOP, Figure, loop_turns, row

PART = """U E0.{0}
UN M{1}.3
O(
U E1.{0}
O M{1}.{0}
)
S M{1}.1
L M{1}
L {1}
>
= A{2}.{0}
U M{1}.1
R M{1}.5
LD M{1}
ZV ACCU,3
TD M{1}
L 100
U E2.{0}
ST E,T{3}
U T{3}
SP N{4},1
U E3.{0}
= A{2}.1
M N{4}
L M5
+"""
PERIOD_NS = 4_000_000


def source(commands: int) -> str:
    """A program of so many commands, of the mixture that cells have: bits, bytes, timers, jumps forward."""
    length = len(PART.splitlines())
    parts = [PART.format(n % 8, 8 + 4 * (n % 120), n % 40, n % 32, n) for n in range(commands // length)]
    return "\n".join([*("\n".join(parts).splitlines()), *["U E0.0"] * (commands % length), "END"])


def costs_ms(action: Callable[[int], object], count: int) -> list[float]:
    """Costs of single calls in ms, sorted."""
    found = []
    for number in range(count):
        begin = time.perf_counter_ns()
        action(number)
        found.append((time.perf_counter_ns() - begin) / 1e6)
    return sorted(found)


def empty_loop_ms(count: int = 200) -> float:
    """The anchor: what 1,000 turns of an empty loop cost this interpreter here, median."""

    def turn(number: int) -> None:
        for _ in range(1_000):
            pass

    return costs_ms(turn, count)[count // 2]


def scan_ms(plc: Plc, count: int) -> list[float]:
    """Scans with changing inputs."""
    inputs = [bytes((number * 37 + at * 11) % 256 for at in range(40)) for number in range(16)]
    return costs_ms(lambda number: plc.scan(number * PERIOD_NS, inputs[number % 16]), count)


def run(count: int = 2_000) -> list[Figure]:
    """Rows plc.scan_1000, plc.scan_1000_p99, plc.display_1000 and plc.translate_10000."""
    anchor = empty_loop_ms()
    plc = Plc({"MAIN": source(1_000)})
    assert plc.start("MAIN") == []
    scans = scan_ms(plc, count)
    plc.watch("MAIN")
    shown = scan_ms(plc, count // 4)
    large = Plc({"MAIN": source(10_000)})
    translated = costs_ms(lambda number: large.start("MAIN"), 5)[2]
    return [
        row("plc.scan_1000", scans[len(scans) // 2], "ms", 0.1, "empty loop of 1,000 turns", anchor),
        row("plc.scan_1000_p99", scans[len(scans) * 99 // 100], "ms", 0.2, "empty loop of 1,000 turns", anchor),
        row("plc.display_1000", shown[len(shown) // 2], "ms", 0.5, "empty loop of 1,000 turns", anchor),
        row("plc.translate_10000", translated / 1e3, "s", 1.0, EMPTY_LOOP, loop_turns()),
    ]
