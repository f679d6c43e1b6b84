"""Attaches to a running cell and keeps the records of the cycle: one per SYNC; the cycle never waits."""

import contextlib
import datetime
import os
import time
from collections.abc import Callable, Iterator, Sequence

import numpy as np

from drivers.ports.base import PortError
from gateway.assembly.data_block_signals import signals_of
from gateway.pure.cell.cell import Cell
from gateway.pure.scope.channels import AxisFact, Channel, channel
from gateway.pure.scope.records import SCOPE_LAYOUT
from gateway.pure.scope.rolling import Rolling
from gateway.pure.scope.trigger import Capture, Trigger, parse_trigger
from gateway.runtime.regions import ImageError, RingReader, recv_fds
from gateway.runtime.supervisor_client import ask
from gateway.scope.recording import Recording

NAP_S = 0.02  # the ring holds 4,096 records: 400 times as long at 2 ms
AT_ONCE = 1024
SILENT_S = 5.0


class ScopeError(Exception):
    """No such run, or one that has ended."""


def facts_of(cell: Cell) -> list[AxisFact]:
    """Axes of a cell as channels need them."""
    return [AxisFact(axis.name, axis.unit) for axis in cell.axis]


@contextlib.contextmanager
def attached(run: str) -> Iterator[RingReader]:
    """The scope ring of a run; raises ScopeError."""
    fds: dict[str, int] = {}
    try:
        with ask(run, "regions") as connection:
            fds = recv_fds(connection)
        yield RingReader(fds["scope"], "scope", SCOPE_LAYOUT)
    except (OSError, PortError, ImageError, KeyError) as error:
        raise ScopeError(f"run {run!r} does not answer ({error}); start it with: axisgate run CELL") from error
    finally:
        for fd in fds.values():
            os.close(fd)


def capture(
    ring: RingReader,
    channels: Sequence[Channel],
    *,
    seconds: float,
    pre_s: float,
    period_s: float,
    trigger: Trigger | None,
    stop: Callable[[], bool] = lambda: False,
    said: Callable[[Capture], None] = lambda capture: None,
) -> Capture:
    """Until `seconds` from the trigger are there, or `stop()` is true; raises ScopeError when the cycle falls silent."""
    kept = Capture(channels, max(1, round(seconds / period_s)), round(pre_s / period_s), trigger)
    heard = time.monotonic()
    while not kept.full and not stop():
        records = ring.take(AT_ONCE)
        for sequence, record in records:
            kept.take(sequence, record)
        if records:
            heard = time.monotonic()
        elif time.monotonic() - heard > SILENT_S:
            raise ScopeError(f"the cycle has been silent for {SILENT_S:.0f} s; {len(kept.rows)} records were kept until then")
        said(kept)
        if len(records) < AT_ONCE:
            time.sleep(NAP_S)
    return kept


def recording_of(kept: Capture | Rolling, channels: Sequence[Channel], cell: Cell, period_s: float, trigger: str) -> Recording:
    """Time 0 is the trigger; without one the first record."""
    stamps = np.frombuffer(kept.stamps, dtype=np.int64) if kept.stamps else np.zeros(0, np.int64)
    values = np.frombuffer(kept.rows.flat, dtype=np.float64) if kept.stamps else np.zeros(0)  # no copy: ten minutes are 38 MB
    zero = stamps[min(kept.triggered_at or 0, len(stamps) - 1)] if len(stamps) else 0
    ago = datetime.timedelta(seconds=(time.monotonic_ns() - int(zero)) / 1e9)
    return Recording(
        [each.name for each in channels],
        [each.unit for each in channels],
        (stamps - zero) / 1e9,
        values.reshape(len(kept.stamps), len(channels)),
        period_s,
        cell.cell.name,
        trigger,
        (datetime.datetime.now().astimezone() - ago).isoformat(timespec="milliseconds"),
        kept.lost,
    )


def named_channels(names: Sequence[str], cell: Cell) -> list[Channel]:
    """Raises ChannelError."""
    facts, signals = facts_of(cell), signals_of(cell)
    return [channel(name, facts, signals) for name in names]


def named_trigger(text: str, cell: Cell) -> Trigger | None:
    """Raises TriggerError; empty: none."""
    return parse_trigger(text, facts_of(cell), signals_of(cell)) if text else None
