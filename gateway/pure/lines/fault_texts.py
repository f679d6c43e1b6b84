"""What a 3964R link and RK512 report, in the words of a journal and of the page."""

from protocols.p3964r.events import (
    BlockRefused,
    Failure,
    LineBreak,
    ReceptionFailed,
    Refusal,
    SendFailed,
    SendRepeated,
    Stage,
    StrayCharacters,
)
from protocols.rk512.active import Denied, Failed, Unasked
from protocols.rk512.passive import Refused, UnexpectedReaction
from protocols.rk512.station import Repeated

REFUSED = {
    Refusal.GAP: "silence inside the block, longer than the character delay",
    Refusal.ORDER: "a DLE followed by neither DLE nor the end",
    Refusal.LENGTH: "more characters than a block may have",
    Refusal.CHECK: "wrong block check",
    Refusal.DAMAGED: "characters damaged on the line (parity, framing or overrun)",
    Refusal.BREAK: "the line was interrupted (BREAK)",
    Refusal.NO_BUFFER: "the previous block has not been read yet",
    Refusal.LOST: "the port was lost",
}
FAILED = {
    Failure.SILENT: "no answer within the acknowledgement delay",
    Failure.NAK: "the partner answered NAK",
    Failure.WRONG: "the partner answered neither DLE nor NAK",
    Failure.DAMAGED: "the answer was received damaged",
    Failure.CONFLICT: "gave way to the partner, which then sent no complete block",
    Failure.BREAK: "the line was interrupted (BREAK)",
    Failure.CROWDED: "too many jobs waiting",
    Failure.LOST: "the port was lost",
    Failure.REVOKED: "cancelled",
}
STAGES = {Stage.WAITING: "while it waited", Stage.CONNECT: "at the connection", Stage.BLOCK: "after the block"}


def fault_words(event: object) -> str:
    """An event of the link or of RK512; anything else as it calls itself."""
    return _of_the_link(event) or _of_rk512(event) or str(event)


def _of_the_link(event: object) -> str:
    match event:
        case BlockRefused(why, count):
            return f"a block of the partner was not accepted, {count} characters of it were received: {REFUSED[why]}"
        case ReceptionFailed(why, attempts):
            return f"the partner gave up a block after {attempts} attempt{'s' * (attempts != 1)}, the first fault: {REFUSED[why]}"
        case SendRepeated(_, why, stage):
            return f"a block is sent again: {FAILED[why]} {STAGES[stage]}"
        case SendFailed(_, why, stage):
            return f"a block was given up: {FAILED[why]} {STAGES[stage]}"
        case StrayCharacters(count):
            return f"{count} characters outside any block"
        case LineBreak():
            return "the line was interrupted (BREAK)"
    return ""


def _of_rk512(event: object) -> str:
    match event:
        case Refused(number, why, head):
            return f"a telegram of the partner was refused with error {number:02X}h ({why}): {head.hex(' ')}"
        case UnexpectedReaction(head) | Unasked(head):
            return f"a reaction was received without a request: {head.hex(' ')}"
        case Denied(job, number):
            return f"job {job}: the partner answered with error {number:02X}h"
        case Failed(job, trouble):
            return f"job {job}: no valid reaction ({trouble.name.lower().replace('_', ' ')})"
        case Repeated():
            return "the partner sent a telegram twice; it was accepted once"
    return ""
