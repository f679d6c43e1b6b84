"""Settings of a serial line against the abilities of both partners: times, roles, types, amounts, own polling; with figures."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

from gateway.assembly.line_dialects import rk512_dialect
from gateway.checks.context import Context, number
from gateway.pure.cell.cell import Cell, Db, Line, Notice, Times
from gateway.pure.lines.line_profiles import link_profile
from gateway.pure.reports.transfer_times import character_ms, job_ms
from gateway.registry import CONTROLLERS, LINE_LAYERS
from protocols.p3964r.profiles import NETWORK, PROFILES, Profile, least_char_delay
from protocols.rk512.dialects import Dialect

TIMES: Mapping[str, str] = {  # key of [line.times] -> field of the profile
    **dict.fromkeys(("QVZ", "ADT"), "ack_delay"),
    **dict.fromkeys(("ZVZ", "CDT"), "char_delay"),
    "BWZ": "block_wait",
    "pause": "retry_pause",
    "no_buffer": "no_buffer_wait",
}
SAME = (("QVZ", "ADT", "acknowledgement delay"), ("ZVZ", "CDT", "character delay"))
LEAST_CHARACTERS = 2  # a time below two characters is over before an answer can be there
MARGIN = 1.25  # turnaround of both stations and doubled DLE, as in the notes on polling


@dataclass(frozen=True, slots=True)
class Own:
    """A job of our own: its block, its kind, its duration."""

    block: Db
    job: str
    ms: float

    @property
    def words(self) -> str:
        return f"{self.job} {self.block.words} words {self.ms:.0f} ms"


def profile_of(line: Line) -> Profile | None:
    """The station the line names; None where there is none of that name."""
    return PROFILES.get(line.profile.removesuffix(NETWORK))


def dialect_of(line: Line) -> Dialect | None:
    """Its RK512 dialect; None if it has none, or its name is unknown."""
    return rk512_dialect(line) if LINE_LAYERS[line.layer].blocks and profile_of(line) is not None else None


def times(check: Context) -> None:
    """Every value of [line.times] can be set at that station and at that speed; no time has two names."""
    for line in check.cell.line:
        station = profile_of(line)
        for german, english, what in SAME:
            if None not in (getattr(line.times, german), getattr(line.times, english)):
                hint = f"{german} and {english} are two names of the {what}: keep one"
                check.fault(f"line.{line.name}.times.{english}", getattr(line.times, english), hint)
        for name in (*TIMES, "reaction"):
            value = getattr(line.times, name)
            if value is not None and station is not None:
                _suitable(check, line, station, name, value)


def _suitable(check: Context, line: Line, station: Profile, name: str, value: int) -> None:
    key, two = f"line.{line.name}.times.{name}", LEAST_CHARACTERS * character_ms(line)
    least = least_char_delay(line.baud) / 1e6 if name in ("ZVZ", "CDT") and (line.profile.startswith("siemens")) else 0.0
    if name in ("QVZ", "ADT", "ZVZ", "CDT") and value < max(two, least):
        hint = f"two characters take {two:.1f} ms at {line.format}"
        hint += f"; the minimum of {station.name} at {line.baud} Bd is {least:.0f} ms" if least > two else ""
        check.fault(key, value, hint, f">= {max(two, least):.0f}", "ms")
    settable = station.settable
    if settable is None or name not in ("QVZ", "ADT", "ZVZ", "CDT", "BWZ"):
        return
    span = f"{settable.least}..{settable.most}"
    if not settable.least <= value <= settable.most:
        check.fault(key, value, f"{station.name} takes {span} ms", span, "ms")
    elif value % settable.step:
        near = value // settable.step * settable.step
        hint = f"{station.name} counts in steps of {settable.step} ms: {near} or {near + settable.step}"
        check.fault(key, value, hint, span, "ms")


def types(check: Context) -> None:
    """The declared blocks can be served, and the dialect can reach them."""
    lines = {line.name: line for line in check.cell.line}
    for line in check.cell.line:
        layer = LINE_LAYERS[line.layer]
        if layer.blocks and not set(line.rk512.types) <= set(layer.kinds):
            kinds = " ".join(layer.kinds)
            check.fault(f"line.{line.name}.rk512.types", " ".join(line.rk512.types), f"{layer.words} carries data modules only", kinds)
    for block in check.cell.db:
        at = lines.get(block.line)
        dialect = None if at is None else dialect_of(at)
        if at is None or dialect is None:
            continue
        if at.role != "active" and block.kind not in at.rk512.types:
            listed = ", ".join(f'"{kind}"' for kind in at.rk512.types)
            hint = f'kind = "{block.kind}", but line {at.name} serves types = [{listed}] only: the block cannot be reached'
            check.fault(f"db.{block.number}.kind", block.kind, hint)
        most = dialect.most_word + 1
        if block.kind in "DX" and block.words > most:
            hint = f"byte 6 of a telegram of {dialect.name} reaches DW {dialect.most_word}"
            check.fault(f"db.{block.number}.words", block.words, hint, f"1..{most}", "words")


def own_jobs(check: Context) -> None:
    """Our own SEND and FETCH: allowed by the role, known to the dialect, within its amounts, and in the time there is."""
    lines = {line.name: line for line in check.cell.line}
    for line in check.cell.line:
        mine = [block for block in check.cell.db if block.line == line.name and (block.every_ms or block.on_change)]
        if line.role == "active" and not mine and LINE_LAYERS[line.layer].blocks:
            hint = (
                'no [[db]] of this line has every_ms or on_change: an active line would send nothing; role = "passive" serves the partner'
            )
            check.fault(f"line.{line.name}.role", line.role, hint)
    for block in check.cell.db:
        at = lines.get(block.line)
        dialect = None if at is None else dialect_of(at)
        if at is not None and dialect is not None:
            _own_job(check, block, at, dialect)
    for line in check.cell.line:
        _reachable(check, line)


def _own_job(check: Context, block: Db, line: Line, dialect: Dialect) -> None:
    key = f"db.{block.number}"
    if not (block.every_ms or block.on_change):
        for name, value in (("at_partner", block.at_partner), ("flag", block.flag)):
            if value:
                check.fault(f"{key}.{name}", value, "only jobs of axisgate have it: every_ms or on_change is missing")
        return
    if line.role == "passive":
        name = "every_ms" if block.every_ms else "on_change"
        hint = f'line {line.name} has role = "passive": it never sends unprompted; role = "both" or "active" allows it'
        check.fault(f"{key}.{name}", getattr(block, name), hint)
    fetch = block.writer == "plc"
    if fetch and block.on_change:
        check.fault(f"{key}.on_change", "true", 'writer = "plc": the time of a change there is unknown; every_ms fetches it')
    if fetch and not dialect.reaction:
        check.fault(f"{key}.every_ms", block.every_ms, f"{dialect.name} has no reaction telegrams, which would carry the data of a FETCH")
    kind = block.at_partner[1:2].replace("B", "D") or block.kind
    if not fetch and kind.encode() not in dialect.send_kinds:
        known = " ".join(map(chr, dialect.send_kinds))
        check.fault(f"{key}.at_partner", block.at_partner, f"{dialect.name} takes a SEND to {known} only, not to {kind}", '"DB20.DW0"')
    _amount(check, block, dialect)


def _amount(check: Context, block: Db, dialect: Dialect) -> None:
    """Bytes and words of one job of ours."""
    if 2 * block.words > dialect.most_bytes:
        hint = f"{2 * block.words} bytes, {dialect.name} carries {dialect.most_bytes} in one job"
        check.fault(f"db.{block.number}.words", block.words, hint, f"1..{dialect.most_bytes // 2}", "words")
    if not block.at_partner:
        return
    head, _, first = block.at_partner.partition(".DW")
    last = int(first) + block.words - 1
    if not 1 <= int(head[2:]) <= 255:
        check.fault(f"db.{block.number}.at_partner", block.at_partner, "data blocks are 1..255")
    if last > dialect.most_word:
        hint = f"{block.words} words from DW {first} end at DW {last}; {dialect.name} reaches DW {dialect.most_word}"
        check.fault(f"db.{block.number}.at_partner", block.at_partner, hint)


def own(cell: Cell, line: Line) -> list[Own]:
    """Our cyclic jobs on a line."""
    blocks = [block for block in cell.db if block.line == line.name and block.every_ms]
    return [Own(block, "FETCH" if block.writer == "plc" else "SEND", job_ms(line, block.words)) for block in blocks]


def _reachable(check: Context, line: Line) -> None:
    """All our cyclic jobs together have to fit into the time of the line."""
    jobs = own(check.cell, line)
    used = sum(job.ms / job.block.every_ms for job in jobs)
    if used <= 1.0:
        return
    fastest = min(jobs, key=lambda job: job.block.every_ms)
    listed, total = " + ".join(job.words for job in jobs), sum(job.ms for job in jobs)
    hint = f"{listed} at {line.baud} Bd fill the line to {100 * used:.0f} %: not reachable; expect {total:.0f}..{MARGIN * total:.0f} ms"
    check.fault(f"db.{fastest.block.number}.every_ms", fastest.block.every_ms, hint, "", "ms")


def program_units(check: Context) -> None:
    """A line with units of programs has nothing else, the cell runs BAPS2 programs, and each unit is on one line."""
    owners: dict[str, str] = {}
    for line in check.cell.line:
        key = f"line.{line.name}"
        if LINE_LAYERS[line.layer].commands:
            if line.program:
                check.fault(f"{key}.program", line.program[0].device, 'units of programs need layer = "program" on their line')
            continue
        if not line.program:
            check.fault(f"{key}.layer", line.layer, 'the line has no unit: add [[line.program]] with device = "V24_1"')
        if not runs_baps2(check.cell):
            check.fault(f"{key}.layer", line.layer, 'units belong to BAPS2 programs: [controller] kind = "rho3" with memory')
        for unit in line.program:
            if unit.device in owners:
                check.fault(f"{key}.program", unit.device, f"the unit is on line {owners[unit.device]} already")
            owners.setdefault(unit.device, line.name)


def runs_baps2(cell: Cell) -> bool:
    """Whether programs with READ and WRITE run in it."""
    return cell.controller is not None and bool(cell.controller.memory) and CONTROLLERS[cell.controller.kind].parameters


# ---- notes
def fixed_times(cell: Cell) -> Iterator[Notice]:
    """Times set otherwise than the station has them, where that station cannot be set."""
    for line in cell.line:
        station, ours = profile_of(line), link_profile(line)
        if station is None:
            continue
        usual = link_profile(replace(line, times=Times()))
        changed = [
            (name, getattr(ours, field), getattr(usual, field))
            for name, field in TIMES.items()
            if getattr(line.times, name) is not None and getattr(ours, field) != getattr(usual, field)
        ]
        for name, value, before in changed:
            text = f"times.{name} = {value / 1e6:g} ms instead of {before / 1e6:g} ms"
            if station.settable is None and name in ("QVZ", "ADT", "ZVZ", "CDT"):
                text += f": {station.name} has fixed times, so the partner expects {before / 1e6:g} ms; both ends need the same"
                yield Notice("warning", f"line {line.name}", text)
            else:
                yield Notice("note", f"line {line.name}", f"{text}: set the partner to the same")


def amounts(cell: Cell) -> Iterator[Notice]:
    """A block the partner cannot have in one job; undeclared types."""
    for line in cell.line:
        dialect = dialect_of(line)
        if dialect is None or line.role == "active":
            continue
        for block in cell.db:
            if block.line == line.name and 2 * block.words > dialect.served_bytes:
                text = f"{block.words} words = {2 * block.words} bytes; {dialect.name} serves {dialect.served_bytes} bytes in one job"
                refused = f"more is refused with 10h, {number(dialect.served_bytes // 2)} words at once are served"
                yield Notice("warning", f"db {block.number}", f"{text}: {refused}")
        there = {block.kind for block in cell.db if block.line == line.name}
        for kind in line.rk512.types:
            if kind in "XTZ" and kind not in there:
                text = f'types has "{kind}" and no [[db]] has kind = "{kind}": every job to it gets {dialect.unknown_block:02X}h'
                yield Notice("warning", f"line {line.name}", text)


def flags(cell: Cell) -> Iterator[Notice]:
    """Coordination flags that stay set until they are reset."""
    for line in cell.line:
        if line.rk512.coordination_flag == "keep":
            text = 'coordination_flag = "keep": a flag a job has set stays until `axisgate var "M 6.4" --set 0`; until then it gets 32h'
            yield Notice("warning", f"line {line.name}", text)


CHECKS = (times, types, own_jobs, program_units)
NOTES = (fixed_times, amounts, flags)
