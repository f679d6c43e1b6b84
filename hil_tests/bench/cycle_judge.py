"""Judges a cycle from the broker's log, by bus stamps: period errors of SYNC, skipped and incomplete cycles, per sender.

    python -m hil_tests.bench.cycle_judge LOG [--period-us 4000] [--from NS] [--to NS]

It asks neither the gateway nor the C reference: what is not on the bus did not happen.
"""

import argparse
import itertools
import json
import pathlib
import sys
from collections.abc import Iterable
from dataclasses import asdict, dataclass

from hil_tests.lab.judges import bus_log as buslog

SYNC = 100
SET_VALUES = frozenset(range(210, 261, 10))
ACTUAL_VALUES = frozenset(range(610, 661, 10))


@dataclass(frozen=True, slots=True)
class Verdict:
    """One master's cycles in a window; times in us.  `cycles` are whole intervals between two of its SYNCs."""

    sender: int
    pid: int  # 0: the log does not say
    cycles: int
    skipped: int  # grid instants without a SYNC
    incomplete: int  # intervals without SYNC, 6 set values and 6 actual values once each
    sync_error_p50: float  # |interval - period|, of intervals without a skipped instant
    sync_error_p99: float
    sync_error_p999: float
    sync_error_max: float
    lost: int  # frames the log itself lost in the window: then nothing above is proved


def judge(lines: Iterable[str], period_ns: int, from_ns: int = 0, to_ns: int = 1 << 63) -> list[Verdict]:
    """One verdict for each sender of SYNC in the window, in order of first appearance."""
    entries = list(buslog.read(lines))
    pids = buslog.senders(entry for entry in entries if isinstance(entry, buslog.Remark))
    inside = [entry for entry in entries if from_ns <= entry.stamp_ns <= to_ns]
    lost = sum(entry.lost for entry in inside if isinstance(entry, buslog.Remark))
    frames = [entry for entry in inside if isinstance(entry, buslog.Logged)]
    masters = list(dict.fromkeys(frame.sender for frame in frames if frame.identifier == SYNC))
    return [_verdict(frames, master, pids.get(master, 0), period_ns, lost) for master in masters]


def _verdict(frames: list[buslog.Logged], master: int, pid: int, period_ns: int, lost: int) -> Verdict:
    starts = [at for at, frame in enumerate(frames) if frame.identifier == SYNC and frame.sender == master]
    errors, skipped, incomplete = [], 0, 0
    for first, second in itertools.pairwise(starts):
        interval = frames[second].stamp_ns - frames[first].stamp_ns
        instants = round(interval / period_ns)
        skipped += max(0, instants - 1)
        if instants <= 1:
            errors.append(abs(interval - period_ns))
        incomplete += not _complete(frames[first:second], master)
    errors.sort()
    p50, p99, p999, worst = (percentile(errors, share) / 1000 for share in (0.5, 0.99, 0.999, 1.0))
    return Verdict(master, pid, max(0, len(starts) - 1), skipped, incomplete, p50, p99, p999, worst, lost)


def _complete(cycle: list[buslog.Logged], master: int) -> bool:
    """SYNC and each set value once from the master, each actual value once from somebody else: 13 frames."""
    ours = sorted(
        frame.identifier for frame in cycle if frame.sender == master and (frame.identifier == SYNC or frame.identifier in SET_VALUES)
    )
    theirs = sorted(frame.identifier for frame in cycle if frame.sender != master and frame.identifier in ACTUAL_VALUES)
    return ours == [SYNC, *sorted(SET_VALUES)] and theirs == sorted(ACTUAL_VALUES)


def percentile(values: list[int], share: float) -> float:
    """Of sorted values; 0 for none."""
    return float(values[int((len(values) - 1) * share)]) if values else 0.0


def main(argv: list[str] | None = None) -> int:
    """Prints a JSON list of verdicts; 0, or 1 when the log holds no SYNC in the window."""
    parser = argparse.ArgumentParser(prog="python -m hil_tests.bench.cycle_judge", description="Judges a cycle from the broker's log.")
    parser.add_argument("log", type=pathlib.Path)
    parser.add_argument("--period-us", type=int, default=4000)
    parser.add_argument("--from", dest="from_ns", type=int, default=0)
    parser.add_argument("--to", dest="to_ns", type=int, default=1 << 63)
    arguments = parser.parse_args(argv)
    with arguments.log.open() as lines:
        verdicts = judge(lines, arguments.period_us * 1000, arguments.from_ns, arguments.to_ns)
    print(json.dumps([asdict(verdict) for verdict in verdicts], indent=1))
    return 0 if verdicts else 1


if __name__ == "__main__":
    sys.exit(main())
