"""The rho 3's devices under any order of calls, signals, characters, damage and time: nothing raises, nothing is lost, nothing stays."""

from collections.abc import Callable

from hypothesis import given, settings
from hypothesis import strategies as st

from gateway.pure.controllers.rho3.serial.baps import (
    BINARY,
    CHARACTER,
    INTEGER,
    REAL,
    TEXT,
    BapsType,
    ItemError,
    Value,
    array,
    pack,
    point,
    unpack,
)
from gateway.pure.controllers.rho3.serial.events import Event, Finished
from gateway.pure.controllers.rho3.serial.manager import LineManager
from gateway.pure.controllers.rho3.serial.setup import DISABLE_BITS, Assignment, Function, Process, Setup
from protocols.base.machine import Damage, Ns, ms

PROCESSES = tuple(Process(number, 100 + number % 2, stop_on_error=number == 3) for number in range(4))
UNITS = ("V24_1", "V24_2", "V24_3", "PHG", "TTY")
TYPES = (BINARY, CHARACTER, INTEGER, REAL, TEXT, point(2), array(INTEGER, 3))
SETUP = Setup(
    (
        Assignment(Function.V24_1, "SER_1", 8, input_timeout_ms=3000),
        Assignment(Function.V24_2, "SER_1", 2, "19200 8E1", input_timeout_ms=500),
        Assignment(Function.V24_3, "PHG", 6, input_timeout_ms=500),
        Assignment(Function.COUPLING, "SER_2"),
        Assignment(Function.PRINTING, "SER_1"),
    ),
    lines=("SER_1", "SER_2", "PHG"),
)


class Shop:
    """The control and everything it told."""

    def __init__(self) -> None:
        self.now: Ns = 0
        self.control = LineManager(SETUP)
        self.told: list[Event] = []
        self.tickets: list[int] = []

    def serve(self) -> None:
        """Whatever was said leaves at once."""
        for _ in range(1000):
            said = False
            for line in self.control.lines.values():
                if line.take_output():
                    said = True
                    self.told += line.sent(self.now)
            if not said:
                return
        raise AssertionError("talks without end")

    def pass_time(self, span: Ns) -> None:
        end = self.now + span
        for _ in range(10_000):
            due = min((due for line in self.control.lines.values() if (due := line.deadline()) is not None), default=end)
            if due >= end:
                self.now = end
                return
            self.now = max(self.now, due)
            for line in self.control.lines.values():
                self.told += line.wake(self.now)
            self.serve()
        raise AssertionError("a deadline stands still")


def step(shop: Shop, draw: Callable[[st.SearchStrategy[int]], int], noise: bytes) -> None:
    control, now = shop.control, shop.now
    process, unit = PROCESSES[draw(st.integers(1, 3))], UNITS[draw(st.integers(0, 4))]
    line = list(control.lines.values())[draw(st.integers(0, 2))]
    match draw(st.integers(0, 11)):
        case 0 if control.room(process, unit):
            shop.tickets.append(
                control.write(process, unit, [(CHARACTER, 65)] * draw(st.integers(0, 20)), now, draw(st.integers(0, 3)) == 0)
            )
        case 1:
            shop.tickets.append(control.read(process, unit, [TYPES[draw(st.integers(0, 6))] for _ in range(draw(st.integers(1, 3)))], now))
        case 2:
            control.set_disable(list(DISABLE_BITS)[draw(st.integers(0, 5))], bool(draw(st.integers(0, 1))), now)
        case 3:
            (control.read_begin if draw(st.integers(0, 1)) else control.write_begin)(process, unit, now)
        case 4:
            control.end_process(process, bool(draw(st.integers(0, 1))), now)
        case 5:
            shop.told += line.damaged(list(Damage)[draw(st.integers(0, 3))], now)
        case 6:
            shop.told += line.lost(now)
        case 7:
            shop.pass_time(ms(draw(st.integers(0, 2000))))
        case 8:
            shop.tickets.append(control.print_out(process, noise, now))
        case 9:
            line.reopened(now)
        case _:
            shop.told += line.receive(noise, now)
    shop.serve()


@settings(max_examples=150, deadline=None)
@given(data=st.data(), pieces=st.lists(st.binary(max_size=6) | st.sampled_from([b"\x02", b"\x10", b"A\x10\x03\x52", b"1\r"]), max_size=40))
def test_every_call_ends_once_and_nothing_raises(data: st.DataObject, pieces: list[bytes]) -> None:
    shop = Shop()
    for noise in pieces:
        step(shop, data.draw, noise)
        for name in SETUP.lines:
            assert shop.control.owner(name) not in {function for function in DISABLE_BITS if _disabled(shop.control, function)}
    for process in PROCESSES[1:]:
        shop.control.end_process(process, True, shop.now)
    shop.serve()
    for line in shop.control.lines.values():
        line.reopened(shop.now)
    shop.pass_time(ms(60_000))
    ended = [event.ticket for event in shop.told + shop.control.take_events() if isinstance(event, Finished)]
    assert sorted(ended) == sorted(ticket for ticket in shop.tickets if ticket)
    assert all(shop.control.condition(process, unit) is not None for process in PROCESSES for unit in UNITS)


def _disabled(control: LineManager, function: Function) -> bool:
    from gateway.pure.controllers.rho3.serial.setup import INFO_TEXTS

    return INFO_TEXTS[function] in control.info()


@given(kind=st.sampled_from(TYPES), data=st.binary(max_size=90), low_byte_first=st.booleans())
def test_bytes_are_a_value_that_packs_to_the_same_bytes_or_are_refused(kind: BapsType, data: bytes, low_byte_first: bool) -> None:
    data = data[: kind.size].ljust(kind.size, b"\0") if len(data) % 7 else data
    value: Value
    try:
        value = unpack(kind, data, low_byte_first)
    except ItemError:
        return
    assert pack(kind, value, low_byte_first) == data
