"""Axisgate's emulated CiA 402 drive and booster as machines of frames, with exchangeable parts: for trials of a CAN suite."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import lru_cache

from drivers.emulator.canopen.node import CanopenNode
from drivers.emulator.cia402.orders import OrderedAxis
from drivers.emulator.cia402.slave import Cia402Slave
from drivers.emulator.servo.settings import BusSettings, DriveSettings, ServoSettings
from gateway.conformance.framework.frame_wire import Pair
from gateway.files.find import find_config
from protocols.base.machine import Frame, Ns
from protocols.canopen.dictionary import Key, ObjectDictionary
from protocols.canopen.eds import parse

NODE, CYCLE_MS = 1, 4.0
QUICK = ServoSettings(boot_s=0.01, charge_s=0.0)
Says = Callable[["Drive", Frame], Sequence[Frame]]
Tune = Callable[["Drive"], None]


@lru_cache
def dictionary() -> ObjectDictionary:
    found, faults = parse(find_config("axisgate_402.eds", "drives").read_text(encoding="utf-8"))
    assert not faults, faults
    return found


def without(*indexes: int) -> ObjectDictionary:
    """A data sheet that lacks these objects."""
    full = dictionary()
    entries = {key: entry for key, entry in full.entries.items() if key[0] not in indexes}
    return replace(full, entries=entries, heads={index: head for index, head in full.heads.items() if index not in indexes})


def put(target: object, **parts: object) -> None:
    """Exchanges methods or values of an object."""
    for name, part in parts.items():
        setattr(target, name, part)


class Drive:
    """One node.  The three parts: changes to a frame it sends, to one it receives, and parts exchanged once, before power-up."""

    def __init__(
        self,
        tune: Tune | None = None,
        says: Says | None = None,
        hears: Says | None = None,
        settings: DriveSettings | None = None,
        lacks: Sequence[int] = (),
        node: int = NODE,
    ) -> None:
        sheet = without(*lacks) if lacks else dictionary()
        drive = DriveSettings(QUICK) if settings is None else settings
        self.slave = Cia402Slave(BusSettings(CYCLE_MS, 1, {}, {node: drive}), {node: sheet})
        self._says, self._hears = says, hears
        self.now: Ns = 0
        self.tally = 0  # for faults that come now and then
        if tune is not None:
            tune(self)

    @property
    def node(self) -> CanopenNode:
        return self.slave.seats[0].node

    @property
    def axis(self) -> OrderedAxis:
        return self.slave.seats[0].axis

    def fixed(self, key: Key, value: int) -> None:
        """Reads always return this value."""
        self.node.objects.readers[key] = lambda: value

    def unchecked(self, *keys: Key) -> None:
        """Writes are not checked any more."""
        for key in keys:
            self.node.objects.checks.pop(key, None)

    # ---- the machine
    def receive(self, frames: Sequence[Pair], now: Ns) -> None:
        self.now = now
        heard = [Frame(identifier, data, now) for identifier, data in frames]
        if self._hears is not None:
            heard = [frame._replace(stamp_ns=now) for one in heard for frame in self._hears(self, one)]
        self.slave.receive(heard, now)

    def wake(self, now: Ns) -> None:
        self.now = now
        self.slave.wake(now)

    def deadline(self) -> Ns | None:
        return self.slave.deadline()

    def take_output(self) -> list[tuple[int, bytes]]:
        said = self.slave.take_output()
        self.slave.take_record()
        if self._says is not None:
            said = [frame for one in said for frame in self._says(self, one)]
        return [(frame.identifier, frame.data) for frame in said]

    def sent(self, now: Ns) -> None:
        """Nothing counts from here."""

    def lost(self, now: Ns) -> None:
        self.slave.lost(now)

    def power(self, on: bool, now: Ns) -> None:
        number = self.slave.seats[0].number
        if on:
            self.slave.power_on(number)
        else:
            self.slave.power_off(number)
