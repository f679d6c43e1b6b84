"""How each kind of suite switches the supply of its device: the machine's own power(on, now), or the bench's [power]."""

import time
from collections.abc import Callable

from gateway.conformance.framework.frame_wire import VirtualFrames
from gateway.conformance.framework.machine import Guarded, GuardedFrames
from gateway.conformance.framework.power import Supply
from gateway.conformance.suites.can.tester import CanTester
from gateway.conformance.suites.line import LineTester
from gateway.conformance.suites.modbus.tester import ModbusTester
from gateway.conformance.suites.opening import Opened
from gateway.links.serial.tool_wire import VirtualWire, Wire
from protocols.base.machine import Ns


def _of_machine(wire: Callable[[], Wire], opened: Opened) -> Supply | None:
    """A new connection may have a new machine at its end."""
    if _power(wire()) is None:
        return None

    def act(on: bool) -> None:
        found = wire()
        power = _power(found)
        assert isinstance(found, VirtualWire) and power is not None, "as at the beginning"
        found.act(lambda now: power(on, now))

    return Supply(act, lambda time: _pass(wire(), time), opened.back)


def _power(wire: Wire) -> Callable[..., None] | None:
    device = wire.station if isinstance(wire, VirtualWire) else None
    return device.power if isinstance(device, Guarded) else None


def _pass(wire: Wire, time: Ns) -> None:
    """Skip frames of the time before."""
    until = wire.now() + time
    while wire.hear(until) is not None:
        pass


def _wait(time_ns: Ns) -> None:
    time.sleep(time_ns / 1e9)


def line_supply(opened: Opened, tester: LineTester, replaced: Callable[[Wire], None]) -> Supply | None:
    """A port in real time is closed within the block: it may disappear with the device."""
    if isinstance(tester.wire, VirtualWire):
        return _of_machine(lambda: tester.wire, opened)
    turn = opened.turn()
    if turn is None:
        return None

    def act(on: bool) -> None:
        if not on:
            tester.wire.close()
        turn(on)
        if on:
            replaced(opened.patiently(opened.wire, opened.back / 1e9))
            tester.mark = tester.wire.now()

    return Supply(act, _wait, opened.back)


def modbus_supply(opened: Opened, tester: ModbusTester, switched: Callable[[], None]) -> Supply | None:
    """The connection ends with the supply; connect again once the server accepts it."""
    if isinstance(tester.wire, VirtualWire):
        of_machine = _of_machine(lambda: tester.wire, opened)
        if of_machine is not None:
            switch = of_machine.turn

            def turned(on: bool) -> None:
                switched()
                switch(on)

            of_machine.turn = turned
        return of_machine
    turn = opened.turn()
    if turn is None:
        return None

    def act(on: bool) -> None:
        if not on:
            switched()
            tester.drop()
        turn(on)
        if on:
            opened.patiently(lambda: tester.wire, opened.back / 1e9)

    return Supply(act, _wait, opened.back)


def frame_supply(opened: Opened, tester: CanTester) -> Supply | None:
    """The bus remains."""
    wire = tester.wire
    if not isinstance(wire, VirtualFrames):
        turn = opened.turn()
        return None if turn is None else Supply(turn, tester.pause, opened.back)
    power = wire.device.power if isinstance(wire.device, GuardedFrames) else None
    return None if power is None else Supply(lambda on: wire.act(lambda now: power(on, now)), tester.pause, opened.back)
