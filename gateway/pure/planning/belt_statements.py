"""Statements of a program that set a belt: SYNC, and special functions 15 BELT_PARAM, 21 BELT_TYPE, 28 SET_BELTCNT.  Pure.

Source: rho 3 Releases part 1, L1694-1742 (SF 28, SYNC), L5998-6091 (SF 21), L6133-6189 (SF 15).  The type of a belt decides how its parts
are planned, so it stays with the planner (and goes to the cycle with each part); everything else is the cycle's.  AX-394.
"""

import struct
from collections.abc import Sequence
from dataclasses import dataclass, replace

from gateway.pure.image.records.cell import RC_BYTES
from gateway.pure.image.records.planner import Part, PieceRecord
from motion.errors import MotionError
from motion.execution.pieces import RECORD_SIZE
from motion.program.blocks import BeltAct, Sync, Synchron
from motion.program.errors import BlockError
from motion.sync.belt_state import Watch
from motion.sync.belts import Belt, Condition, Type
from motion.sync.errors import NO_BELT, NOT_POSSIBLE, TEXTS, BeltError
from motion.sync.facts import BeltFacts

PARAMETERS, TYPE, COUNTER = 15, 21, 28  # special functions
CYCLE_S = 0.01  # of a belt that only checks whether it would accept a value
SYNC = 0
_ACT = struct.Struct("=BBBi??3d")
CONDITIONS = tuple(Condition)


@dataclass(frozen=True, slots=True)
class ActOrder:
    """For the cycle.  function: 0 SYNC, 15, 28; belt: place from 0; values: of the function, or the limit of SYNC (m or rad)."""

    function: int
    belt: int
    values: tuple[float, float, float] = (0.0, 0.0, 0.0)
    condition: Condition = Condition.AT_LEAST
    input: int = 0
    level: bool = True
    inside: bool = False  # SYNC of an endless belt, in the part on it


def act_record(job: int, generation: int, order: ActOrder) -> PieceRecord:
    """As a record of the pieces ring."""
    head = (order.function, order.belt, CONDITIONS.index(order.condition), order.input, order.level, order.inside)
    body = _ACT.pack(*head, *order.values)
    return PieceRecord(Part.BELT_ACT, job, generation, body.ljust(RECORD_SIZE, b"\0"))


def act_of(record: PieceRecord) -> ActOrder:
    """The reverse of act_record."""
    function, belt, condition, number, level, inside, a, b, c = _ACT.unpack_from(record.piece)
    return ActOrder(function, belt, (a, b, c), CONDITIONS[condition], number, level, inside)


def act_order(act: BeltAct, belts: Sequence[BeltFacts], number: int, part: Synchron | None = None, kinematic: int = 1) -> ActOrder | None:
    """Return the order to the cycle, None: none (SF 21).  Raise BlockError with the manual's number, for the following block `number`.
    part: the synchronous part that contains the statement.
    """
    if act.inside:
        return _endless(act, belts, number, part, kinematic)
    if isinstance(act, Sync):
        return _sync(act, belts, number)
    if not 1 <= act.belt <= len(belts):
        raise BlockError(f"belt {act.belt}: {TEXTS[NO_BELT]}, P501 = {len(belts)}", code=NO_BELT, block=number, source="rho 3")
    try:
        belts_after(act, belts)
    except BeltError as error:
        raise BlockError(f"{error.text}, {error.detail}", code=error.code, block=number, source="rho 3") from error
    except MotionError as error:
        raise BlockError(str(error), block=number) from error
    if act.function == TYPE:
        return None
    a, b, c = (*act.values, 0.0, 0.0)[:3]
    return ActOrder(act.function, act.belt - 1, (a, b, c))


def _endless(act: BeltAct, belts: Sequence[BeltFacts], number: int, part: Synchron | None, kinematic: int) -> ActOrder:
    """SYNC inside a part: only of its own belt, without an input, and where an endless axis goes along with it (L11595-11617)."""
    why = ""
    facts = next((each for each in belts if part is not None and each.name == part.belt), None)
    if facts is None or not isinstance(act, Sync):
        why = "belt functions and SYNC must be outside synchronous and alterable parts, except SYNC of an endless belt"
    elif act.belt != facts.name:
        why = f"SYNC in a part on belt {facts.name} is one of this belt, not of {act.belt}"
    elif act.input is not None:
        why = f"SYNC of belt {facts.name} inside its part waits for a belt value, not for an input"
    elif facts.kind is not Type.PARALLEL or facts.carriers[kinematic].joint is None:
        why = f"SYNC inside a part needs a belt of type 1 with an endless axis parallel to it, and belt {facts.name} has none"
    if why or not isinstance(act, Sync):
        raise BlockError(f"{TEXTS[NOT_POSSIBLE]}: {why}", code=NOT_POSSIBLE, block=number, source="rho 3")
    return replace(_sync(act, belts, number), inside=True)


def _sync(act: Sync, belts: Sequence[BeltFacts], number: int) -> ActOrder:
    place = next((n for n, each in enumerate(belts) if each.name == act.belt), None)
    if place is None:
        known = ", ".join(each.name for each in belts) or "none"
        raise BlockError(f"belt {act.belt}: {TEXTS[NO_BELT]}; this cell has {known}", code=NO_BELT, block=number, source="rho 3")
    if act.input is None:
        condition = Condition.AT_LEAST if act.at_least else Condition.AT_MOST
        return ActOrder(SYNC, place, (act.limit, 0.0, 0.0), condition)
    if act.input not in range(8 * RC_BYTES):
        raise BlockError(f"sync {act.belt} input={act.input}: an RC input is needed", block=number)
    return ActOrder(SYNC, place, condition=Condition.INPUT, input=act.input, level=act.level)


def sets_type(act: BeltAct) -> bool:
    """SF 21: the cycle is informed of it with the next part on that belt."""
    return not isinstance(act, Sync) and act.function == TYPE


def belts_after(act: BeltAct, belts: Sequence[BeltFacts]) -> tuple[BeltFacts, ...]:
    """The belts once it is done; BeltError 92, MotionError for a value that is none."""
    if isinstance(act, Sync):
        return tuple(belts)
    changed, facts = list(belts), belts[act.belt - 1]
    trial = Belt(act.belt, facts.data, Watch(CYCLE_S))
    if act.function == TYPE:
        kind, tolerance = trial.check_type(int(act.values[0]))
        changed[act.belt - 1] = replace(facts, kind=kind, tolerance=tolerance)
    elif act.function == PARAMETERS:
        stop, run, patience = act.values
        trial.watch.parametrise(stop, run, patience / 1000)
        changed[act.belt - 1] = replace(facts, thresholds=(stop, run, int(patience)))
    return tuple(changed)
