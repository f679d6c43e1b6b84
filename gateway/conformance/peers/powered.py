"""A machine of characters with a supply: off, it receives and sends nothing; on, it restarts."""

from collections.abc import Callable, Sequence
from typing import Any

from protocols.base.machine import Damage, Ns

Fresh = Callable[[], Any]  # a byte machine


class Powered:
    """`returns`: False for one that stays off."""

    def __init__(self, fresh: Fresh, returns: bool = True) -> None:
        self._fresh, self._returns = fresh, returns
        self._device = fresh()
        self._on = True

    def power(self, on: bool, now: Ns) -> None:
        self._on = on and self._returns
        if on:
            self._device = self._fresh()

    def stimulate(self, now: Ns) -> None:
        if self._on:
            self._device.stimulate(now)

    def receive(self, data: bytes, now: Ns) -> Sequence[object]:
        return list(self._device.receive(data, now)) if self._on else []

    def damaged(self, kind: Damage, now: Ns) -> Sequence[object]:
        return list(self._device.damaged(kind, now)) if self._on else []

    def sent(self, now: Ns) -> Sequence[object]:
        return list(self._device.sent(now)) if self._on else []

    def wake(self, now: Ns) -> Sequence[object]:
        return list(self._device.wake(now)) if self._on else []

    def deadline(self) -> Ns | None:
        due: Ns | None = self._device.deadline() if self._on else None
        return due

    def take_output(self) -> bytes:
        said = bytes(self._device.take_output())
        return said if self._on else b""

    def lost(self, now: Ns) -> Sequence[object]:
        return list(self._device.lost(now))
