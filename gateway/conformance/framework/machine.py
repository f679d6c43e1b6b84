"""`machine:FILE.py:FACTORY?key=value`: the object FACTORY returns is tested in virtual time (the seven methods of a byte machine)."""

import importlib.util
import math
import pathlib
import sys
import urllib.parse
from collections.abc import Callable, Sequence
from typing import Any, cast

from drivers.ports.base import PortError
from gateway.conformance.framework.bench_file import BadFile
from gateway.conformance.framework.frame_wire import Pair
from protocols.base.machine import Damage, Frame, Machine, Ns

METHODS = ("receive", "damaged", "sent", "wake", "deadline", "take_output", "lost")
FRAME_METHODS = ("receive", "sent", "wake", "deadline", "take_output", "lost")  # a CAN machine may have error_frame as well


class MachineDied(PortError):
    """The device under test raised an exception and is dead."""


class Guarded:
    """Pass on to the device; an exception ends the device, not the tester."""

    def __init__(self, device: Machine[object], name: str) -> None:
        self.device, self._name = device, name
        self._on, self._woken = True, -1
        self.stimulate = self._optional("stimulate")
        self.hold = self._optional("hold")
        switch = self._optional("power")
        self.power = None if switch is None else self._switching(switch)

    def _switching(self, switch: Callable[..., None]) -> Callable[..., None]:
        def switched(on: bool, now: Ns) -> None:
            self._on = on
            switch(on, now)

        return switched

    def _optional(self, name: str) -> Callable[..., None] | None:
        found = getattr(self.device, name, None)
        if not callable(found):
            return None
        act = cast(Callable[..., object], found)

        def guarded(*arguments: object) -> None:
            self._call(lambda: act(*arguments), name)

        return guarded

    def _call(self, act: Callable[[], object], method: str) -> object:
        try:
            return act()
        except (Exception, SystemExit) as error:  # a signal to the run is a KeyboardInterrupt
            raise MachineDied(0, f"{self._name}: {method} raised {type(error).__name__}: {error}") from error

    def _events(self, act: Callable[[], object], method: str) -> Sequence[object]:
        found = self._call(act, method)
        return list(found) if isinstance(found, (list, tuple)) else []

    def receive(self, data: bytes, now: Ns) -> Sequence[object]:
        return self._events(lambda: self.device.receive(data, now), "receive")

    def damaged(self, kind: Damage, now: Ns) -> Sequence[object]:
        return self._events(lambda: self.device.damaged(kind, now), "damaged")

    def sent(self, now: Ns) -> Sequence[object]:
        return self._events(lambda: self.device.sent(now), "sent")

    def wake(self, now: Ns) -> Sequence[object]:
        self._woken = now
        return self._events(lambda: self.device.wake(now), "wake")

    def deadline(self) -> Ns | None:
        """Without supply none that a wake left as it was: no timer runs there."""
        due = self._call(self.device.deadline, "deadline")
        if due is None:
            return None
        if not isinstance(due, (int, float)) or not math.isfinite(due):
            raise MachineDied(0, f"{self._name}: deadline returned {due!r}; nanoseconds expected, or None")
        moment = math.ceil(due)
        return moment if self._on or moment > self._woken else None

    def take_output(self) -> bytes:
        said = self._call(self.device.take_output, "take_output")
        if said is None:
            return b""
        if not isinstance(said, (bytes, bytearray)):
            raise MachineDied(0, f"{self._name}: take_output returned {said!r:.60}; bytes expected")
        return bytes(said)

    def lost(self, now: Ns) -> Sequence[object]:
        return self._events(lambda: self.device.lost(now), "lost")


class GuardedFrames:
    """The same for a CAN machine: pairs (identifier, data) in and out."""

    def __init__(self, device: object, name: str) -> None:
        self._bytes = Guarded(cast(Machine[object], device), name)
        self.device = cast(Any, device)
        self._name = name
        self.stimulate, self.hold, self.power = self._bytes.stimulate, self._bytes.hold, self._bytes.power

    def receive(self, frames: Sequence[Pair], now: Ns) -> None:
        self._bytes._call(lambda: self.device.receive(list(frames), now), "receive")

    def wake(self, now: Ns) -> None:
        self._bytes.wake(now)

    def deadline(self) -> Ns | None:
        return self._bytes.deadline()

    def lost(self, now: Ns) -> None:
        self._bytes.lost(now)

    def take_output(self) -> list[Frame]:
        said = self._bytes._call(self.device.take_output, "take_output")
        if said is not None and not isinstance(said, (list, tuple)):
            raise MachineDied(0, f"{self._name}: take_output returned {said!r:.60}; a list of pairs (identifier, data) expected")
        return [self._frame(one) for one in said or ()]

    def _frame(self, one: object) -> Frame:
        good = isinstance(one, tuple) and len(one) >= 2 and isinstance(one[0], int) and isinstance(one[1], (bytes, bytearray))
        if not good or not isinstance(one, tuple) or len(one[1]) > 8:
            raise MachineDied(0, f"{self._name}: take_output returned {one!r}; a pair (identifier, data of at most 8 bytes) expected")
        return Frame(one[0], bytes(one[1]))


AnyGuarded = Guarded | GuardedFrames


def load_machine(url: str, folder: pathlib.Path, frames: bool = False) -> Callable[[], AnyGuarded]:
    """A maker of the device; BadFile names the fault in the address, the file or the factory."""
    address, _, query = url.removeprefix("machine:").partition("?")
    name, colon, factory_name = address.rpartition(":")
    if not colon or not name or not factory_name:
        raise BadFile([f"port.url {url}: machine:FILE.py:FACTORY?key=value expected"])
    path = (folder / name).resolve()
    values = dict(urllib.parse.parse_qsl(query, keep_blank_values=True))
    factory = _factory(path, factory_name, url)

    methods = FRAME_METHODS if frames else METHODS

    def make() -> AnyGuarded:
        try:
            device = factory(**values)
        except (Exception, SystemExit) as error:
            said = " ".join(f"{type(error).__name__}: {error}".split())
            raise BadFile([f"port.url {url}: {factory_name} raised {said}; check its keys and values"]) from error
        missing = [method for method in methods if not callable(getattr(device, method, None))]
        if missing:
            raise BadFile([f"port.url {url}: what {factory_name} returns lacks {', '.join(missing)}; a machine has {', '.join(methods)}"])
        label = f"{path.name}:{factory_name}"
        return GuardedFrames(device, label) if frames else Guarded(cast(Machine[object], device), label)

    return make


def _factory(path: pathlib.Path, name: str, url: str) -> Callable[..., object]:
    if not path.is_file():
        raise BadFile([f"port.url {url}: {path} does not exist; the path is taken from the folder of the bench file"])
    spec = importlib.util.spec_from_file_location(f"conformance_device_{path.stem}", path)
    if spec is None or spec.loader is None:
        raise BadFile([f"port.url {url}: {path} is not a Python file"])
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    sys.path.insert(0, str(path.parent))
    try:
        spec.loader.exec_module(module)
    except (Exception, SystemExit) as error:
        raise BadFile([f"port.url {url}: {path} cannot be loaded ({type(error).__name__}: {error})"]) from error
    finally:
        sys.path.remove(str(path.parent))
    found = getattr(module, name, None)
    if not callable(found):
        raise BadFile([f"port.url {url}: {path.name} has no function {name}"])
    return cast(Callable[..., object], found)
