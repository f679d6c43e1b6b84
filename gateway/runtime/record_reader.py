"""A record of a region, unpacked only where its bytes have changed: an idle planner publishes the same ones 200 times a second."""

from collections.abc import Callable
from typing import Generic, TypeVar

from gateway.runtime.regions import RegionReader

R = TypeVar("R")


class RecordReader(Generic[R]):
    """`unpack`: bytes of the region to a read-only record; `none`: the record before the first one is published."""

    def __init__(self, region: RegionReader, unpack: Callable[[bytes], R], none: R) -> None:
        self.region = region
        self._unpack, self._record = unpack, none
        self._payload: bytes | None = None

    def read(self) -> R:
        """The newest record."""
        payload = self.region.read()
        if payload is not None and payload != self._payload:
            self._record, self._payload = self._unpack(payload), payload
        return self._record
