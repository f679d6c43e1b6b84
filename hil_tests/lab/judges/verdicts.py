"""The demo's verdicts: what both PLCs did and when (the story) against what emulator, bus and line recorded."""

import json
import pathlib
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace

from drivers.emulator.servo.record import read as read_record
from drivers.ports.serial.line_format import Run, parse_record
from gateway.pure.cell.cell import Cell
from gateway.pure.image.reasons import Reason
from hil_tests.lab.judges import bus_log as buslog
from hil_tests.lab.judges.judge import Judge, Move, SetPath, Verdict, recovery_s, repeats_while_unplugged
from protocols.servodyn.plan import SYNC_ID

DRIVES = 6
THINKING_NS, THINKING_SHARE = 3_000_000, 0.4  # at the end of P5 the cycle waits for no answer any more: the smaller of both (AX-149)
NOT_OWNER, FORMAT = 1, 5  # reason numbers (AX-140)


@dataclass(slots=True)
class Story:
    """Stamps and what the PLCs read; nothing of it is a verdict yet."""

    moves: list[tuple[str, Move]] = field(default_factory=list)
    events: dict[str, int] = field(default_factory=dict)  # ns
    facts: dict[str, float] = field(default_factory=dict)


def machine_late(log: pathlib.Path, p5_ms: int) -> str:
    """By the bus log: SYNC away for more than two periods, or answers missing two cycles in a row, in words; "" when neither happened."""
    try:
        with log.open() as lines:
            frames = buslog.frames(lines)
    except OSError:
        return ""
    period, last_sync, late_before = p5_ms * 1_000_000, 0, False
    patience = period - min(THINKING_NS, THINKING_SHARE * period)
    answered: list[int] = []
    for frame in frames:
        if frame.identifier != SYNC_ID:
            answered += [frame.stamp_ns] if 610 <= frame.identifier <= 660 else []
            continue
        if last_sync and frame.stamp_ns - last_sync > 2 * period:
            return f"{(frame.stamp_ns - last_sync) / 1e6:.0f} ms without SYNC in the bus log"
        late = bool(last_sync) and (len(answered) < DRIVES or max(answered) - last_sync > patience)
        if late and late_before:
            return "answers of the drives late two cycles in a row"
        last_sync, late_before, answered = frame.stamp_ns, late, []
    return ""


def run_says_late(alarms: pathlib.Path, since_ns: int) -> str:
    """By the alarms of the run itself: drives stopped because this machine was late, in words; "" when none did."""
    try:
        records = [json.loads(line) for line in alarms.read_text().splitlines()]
    except (OSError, ValueError):
        return ""
    late = [record for record in records if record.get("what") == "came" and record["code"] == Reason.MACHINE_LATE]
    return next((str(record["text"]) for record in late if record["ns"] >= since_ns), "")


def at_most(name: str, value: float, limit: float) -> Verdict:
    """A figure with an upper bound; what is not a number does not hold."""
    return Verdict(name, value, f"<= {limit:g}", value <= limit)


def verdicts_of(cell: Cell, folder: pathlib.Path, story: Story, bus_clock_ns: int) -> list[Verdict]:
    """`bus_clock_ns`: what has to be added to the bus log's stamps to get the monotonic clock."""
    judge = Judge(cell, read_record((folder / "emulator-drives.rec").read_bytes()))
    line = parse_record((folder / "line-plc1.rec").read_text().splitlines(keepends=True))
    with (folder / "bus-drives.log").open() as log:
        path = SetPath(cell, shifted(buslog.frames(log), bus_clock_ns))
    return [*of_the_sources(story), *of_the_moves(judge, path, story), *of_the_line(judge, story, line.runs), *of_the_restart(judge, story)]


def of_the_sources(story: Story) -> Iterator[Verdict]:
    """One owner; numbers in a wrong format."""
    facts = story.facts
    refused = (facts["refused reason"], facts["owner"])
    yield Verdict("PLC 2 refused while PLC 1 has control, reason", refused[0], "1, owner 1", refused == (NOT_OWNER, 1))
    words = facts["format reason"] == FORMAT and facts["format words"] == 1.0
    yield Verdict("KG instead of REAL refused in words, reason", facts["format reason"], "5", words)


def of_the_moves(judge: Judge, path: SetPath, story: Story) -> Iterator[Verdict]:
    """Targets, lag, path."""
    moves = [move for _, move in story.moves]
    yield at_most(f"{len(moves)} targets missed by at most, increments", max(judge.missed_by(move) for move in moves), 2)
    lags = [lag for move in moves if (lag := judge.lag_error(move)) is not None]
    yield at_most("lag against speed / Kv, worst, %", 100 * max(lags, default=float("nan")), 5)
    for who, what in (("stop", "stop and resume"), ("override", "override changes"), ("plc1", "the broken line")):
        off = max(path.off_line(move) for name, move in story.moves if name == who)
        yield at_most(f"path deviation over {what}, increments", off, 1)
    yield at_most("moved by the wrong number, increments", judge.moved(story.events["format"], story.events["format end"]), 2)


def of_the_line(judge: Judge, story: Story, runs: list[Run]) -> Iterator[Verdict]:
    """The cable pulled and put back."""
    unplug, plug, resume = (story.events[name] for name in ("unplug", "plug", "resume"))
    rest = judge.rest_after(unplug, plug)
    yield Verdict("axes at rest after the cable was pulled, s", rest or 0.0, "0.9 .. 2.0", rest is not None and 0.9 <= rest <= 2.0)
    repeats = repeats_while_unplugged(runs, unplug, plug)
    yield Verdict("repeats seen while unplugged", repeats, ">= 1", repeats >= 1)
    yield at_most("line recovered after plugging, s", recovery_s(runs, plug), 2)
    yield at_most("moved between plugging and the new command, increments", judge.moved(plug, resume), 2)


def of_the_restart(judge: Judge, story: Story) -> Iterator[Verdict]:
    """Services killed under a start bit that stays set."""
    yield at_most("services back after SIGKILL, s", story.facts["services back"], 3)
    yield at_most("both links at work after that, s", story.facts["links back"], 2)
    yield at_most("moved by the start bit that was still set, increments", judge.moved(story.events["kill"], story.events["kill end"]), 2)


def shifted(frames: Iterable[buslog.Logged], by_ns: int) -> Iterator[buslog.Logged]:
    """The same frames on the monotonic clock."""
    for frame in frames:
        yield replace(frame, stamp_ns=frame.stamp_ns + by_ns) if by_ns else frame
