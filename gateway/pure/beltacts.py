"""Statements of a program that set a belt: SYNC, and special functions 15 BELT_PARAM, 21 BELT_TYPE, 28 SET_BELTCNT.  Pure.

Source: rho 3 Releases part 1, L1694-1742 (SF 28, SYNC), L5998-6091 (SF 21), L6133-6189 (SF 15).  The type of a belt decides how its parts
are planned, so it stays with the planner (and goes to the cycle with each part); everything else is the cycle's.  AX-394.
"""

import struct
from collections.abc import Sequence
from dataclasses import dataclass, replace

from gateway.pure.plannerrecords import Part, PieceRecord
from gateway.pure.records import RC_BYTES
from motion.errors import MotionError
from motion.pieces import RECORD_SIZE
from motion.program.blocks import BeltAct, Sync
from motion.program.errors import BlockError
from motion.sync.belts import Belt, Condition
from motion.sync.errors import NO_BELT, NOT_POSSIBLE, TEXTS, BeltError
from motion.sync.facts import BeltFacts
from motion.sync.watch import Watch

PARAMETERS, TYPE, COUNTER = 15, 21, 28  # special functions
CYCLE_S = 0.01  # of a belt that is only asked whether it would take a value
SYNC = 0
_ACT = struct.Struct("=BBBi?3d")
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


def act_record(job: int, generation: int, order: ActOrder) -> PieceRecord:
    """As a record of the pieces ring."""
    body = _ACT.pack(order.function, order.belt, CONDITIONS.index(order.condition), order.input, order.level, *order.values)
    return PieceRecord(Part.BELT_ACT, job, generation, body.ljust(RECORD_SIZE, b"\0"))


def act_of(record: PieceRecord) -> ActOrder:
    """The reverse of act_record."""
    function, belt, condition, number, level, a, b, c = _ACT.unpack_from(record.piece)
    return ActOrder(function, belt, (a, b, c), CONDITIONS[condition], number, level)


def act_order(act: BeltAct, belts: Sequence[BeltFacts], number: int) -> ActOrder | None:
    """What the cycle does of it, None: nothing (SF 21); BlockError with the manual's number, for the block `number` behind it."""
    if act.inside:
        what = f"{TEXTS[NOT_POSSIBLE]}: SYNC and belt functions stand outside of synchronous and alterable parts"
        raise BlockError(what, code=NOT_POSSIBLE, block=number, source="rho 3")
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
    """SF 21: the cycle hears of it with the next part on that belt."""
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
