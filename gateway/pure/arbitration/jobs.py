"""Jobs of the dispatcher: one command of one command source, its outcome, and the text shown for it."""

from dataclasses import dataclass, field
from enum import Enum

from gateway.pure.arbitration.command_block import Code
from gateway.pure.image.reasons import CommandState, Reason, text
from gateway.pure.image.records.cell import EVERY_AXIS
from protocols.base.machine import Ns


@dataclass(frozen=True, slots=True)
class AxisFacts:
    """What the dispatcher must know of an axis; positions in the axis' own unit."""

    name: str
    unit: str  # mm | deg
    si: float  # one unit in m or rad
    low: float
    high: float
    endless: bool = False  # goes round: low .. high are its positions, and a way may lead beyond
    absolute: bool = False  # its encoder knows where it is: there is nothing to reference


class OnLoss(Enum):
    """What happens to a running move when the owner's link dies."""

    HOLD = "hold"
    FINISH = "finish_move"
    STOP = "stop_on_path"
    QUICK_STOP = "quick_stop"


@dataclass(slots=True)
class Job:
    """One command of one command source and what became of it."""

    id: int
    source: int
    code: int
    state: CommandState = CommandState.ACCEPTED
    reason: Reason = Reason.NONE
    detail: str = ""
    mask: int = 0
    until: Ns | None = None  # aborted with TIME_OUT then
    quiet: bool = False  # its completion is not reported
    watch: int = 0  # job whose end is this job's end (resume watches the move)
    also: tuple[int, ...] = ()  # jobs that have to end well, too: resume of several lanes
    span: int = EVERY_AXIS  # axes (bit n-1 = axis n) of the lanes that it is about
    held: bool = False  # hold-to-run: it stops without the services, whatever on_services_loss says
    what: str = ""  # which program or robot, in words; "": implied by its code

    @property
    def open(self) -> bool:
        return self.state in (CommandState.ACCEPTED, CommandState.RUNNING)


@dataclass(slots=True)
class SourceState:
    """The last command of a command source and the last one of each code."""

    last: Job | None = None
    by_code: dict[int, Job] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class DispatcherEvent:
    """Something a person wants to read in the journal."""

    what: str  # accepted | done | refused | aborted | stopped | control
    source: int
    code: int
    reason: Reason
    detail: str

    def sentence(self, language: str = "en") -> str:
        """One line for log and page."""
        name = Code(self.code).name.lower() if self.code in Code._value2member_map_ else f"code {self.code}"
        why = text(self.reason, language, self.detail)
        return f"command source {self.source}: {name} {self.what}" + (f": {why}" if why else "")
