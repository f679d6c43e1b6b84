"""The proposal as a DBC: every signal with its confidence and reason as a comment."""

from collections.abc import Iterator

from gateway.pure.buses.inference.roles import Inferred
from gateway.pure.buses.inference.signals import Found

SURE = 0.8  # confidence from which a finding is reported as proved by the recording


def names(found: Inferred) -> dict[int, str]:
    """Identifier -> message name: SYNC, SET_n, ACT_n, MSG_identifier."""
    out = {series.identifier: f"MSG_{series.identifier}" for series in found.cycles.messages}
    if found.cycles.sync is not None:
        out[found.cycles.sync] = "SYNC"
    for axis in found.axes:
        out |= {axis.set_id: f"SET_{axis.number}", axis.actual_id: f"ACT_{axis.number}"}
    return out


def as_dbc(found: Inferred, source: str) -> str:
    """The text of the file; `source` names the recording."""
    called = names(found)
    lengths = {series.identifier: series.length for series in found.cycles.messages}
    lines = [
        f'VERSION "inferred from {source}; a proposal, to be confirmed on the living control"',
        "",
        "NS_ :",
        "",
        "BS_:",
        "",
        "BU_: BUS",
        "",
    ]
    for identifier, name in sorted(called.items()):
        lines.append(f"BO_ {identifier} {name}: {lengths.get(identifier, 0)} BUS")
        lines += [f" {_signal(each, lengths[identifier], found.reverse)}" for each in found.of(identifier)]
        lines.append("")
    return "\n".join([*lines, *_comments(found, called)]) + "\n"


def _signal(each: Found, length: int, reverse: bool) -> str:
    if each.signed:
        low, high = -(1 << each.bits - 1), (1 << each.bits - 1) - 1
    else:
        low, high = 0, (1 << each.bits) - 1
    start = _high_bit(each, length) if reverse else each.start
    order, sign = "0" if reverse else "1", "-" if each.signed else "+"
    unit = each.name.rpartition("_")[2] if each.name.endswith(("_inc", "_rpm")) else ""
    return f'SG_ {each.name} : {start}|{each.bits}@{order}{sign} (1,0) [{low}|{high}] "{unit}" Vector__XXX'


def _high_bit(each: Found, length: int) -> int:
    """Motorola signals begin with their highest bit, counted within the byte it is in."""
    high = each.start + each.bits - 1  # in the word of the reversed bytes
    return 8 * (length - 1 - high // 8) + high % 8


def _comments(found: Inferred, called: dict[int, str]) -> Iterator[str]:
    cycle = f"cycle {found.cycles.period_ns / 1e6:g} ms"
    yield f'CM_ "Proposed from a recording of {len(found.cycles.messages)} cyclic messages, {cycle}.";'
    for axis in found.axes:
        why = f"set value of axis {axis.number}; {called[axis.actual_id]} follows it, confidence {axis.confidence:.2f}"
        yield f'CM_ BO_ {axis.set_id} "{why}";'
    for each in found.signals:
        yield f'CM_ SG_ {each.identifier} {each.name} "confidence {each.confidence:.2f}: {each.why}";'
