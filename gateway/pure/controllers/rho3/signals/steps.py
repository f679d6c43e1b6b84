"""Programs a cell declares: what a process of the control does where no interpreter runs.  AX-334.

A program is a list of steps, played in order: a PTP move of some axes, a program of the planner, a user output, waiting for a user
input, waiting a time.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Protocol

from gateway.pure.arbitration.jobs import Job
from gateway.pure.controllers.rho3.functions.processes import Body, ProcessFault, Turn
from gateway.pure.controllers.rho3.signals.fast_io import Channels, InputFault
from gateway.pure.controllers.rho3.signals.modes import OperatingModes, Refusal, RuntimeFault
from gateway.pure.image.reasons import CommandState, text
from protocols.base.machine import Ns

CODES = {Refusal.MANUAL: 250, Refusal.SWITCHED: 251, Refusal.NOT_MANUAL: 252}  # ours: the manual prints texts (AX-334)
NOT_MOVED, INADMISSABLE = 253, 254  # ours: the dispatcher refused the move, or it was aborted; "inadmissable input" (AX-477)


@dataclass(frozen=True, slots=True)
class Step:
    """Exactly one of: `to` (axis index -> target in its unit), `program` (number of the cell's), `output`, `input`, `wait`."""

    to: Mapping[int, float] = field(default_factory=dict)
    program: int | None = None
    speed: float = 1.0  # 0..1
    output: int = 0  # binary output 1..120 or 801..804, gets `value`
    input: int = 0  # binary input 1..120, 610..639 or 801..804, is waited for until it has `value`
    value: bool = True
    wait: Ns = 0


class StepHost(Protocol):
    """What a program needs of the cell."""

    @property
    def modes(self) -> OperatingModes:
        """Its operating modes."""

    channels: Channels

    def move(self, program: str, step: Step, now: Ns) -> Job:
        """A PTP move or a program of the planner; `program` asks for it."""


def fault_of(fault: RuntimeFault) -> ProcessFault:
    """With a code for the interface."""
    return ProcessFault(CODES[fault.why], f"{fault.why.value} (kinematic {fault.kinematic})")


class Played:
    """One start of a program."""

    def __init__(self, name: str, steps: Sequence[Step], kinematics: Sequence[int], host: StepHost, *, repeat: bool, language: str) -> None:
        """`repeat`: from the beginning again after the last step."""
        self._name, self._steps, self._kinematics, self._host = name, steps, kinematics, host
        self._repeat, self._language = repeat, language
        self._at = 0
        self._job: Job | None = None
        self._since: Ns | None = None

    def __call__(self, now: Ns) -> Turn:
        """One turn: until a step has to wait.  Raises ProcessFault."""
        while self._at < len(self._steps):
            if not self._done(self._steps[self._at], now):
                return Turn.WAIT
            self._at, self._since, self._job = self._at + 1, None, None
        if not self._repeat:
            return Turn.DONE
        self._at = 0
        return Turn.WAIT

    def _done(self, step: Step, now: Ns) -> bool:
        if step.to or step.program is not None:
            return self._moved(step, now)
        if step.output or step.input:
            return self._switched(step)
        self._since = now if self._since is None else self._since
        return now - self._since >= step.wait

    def _switched(self, step: Step) -> bool:
        channels = self._host.channels
        try:
            if step.input:
                return channels.read(step.input) is step.value
            channels.write(step.output, step.value)
        except InputFault as fault:
            raise ProcessFault(INADMISSABLE, str(fault)) from fault
        return True

    def _moved(self, step: Step, now: Ns) -> bool:
        modes, job = self._host.modes, self._job
        if job is None:
            barred = modes.prepare(self._name, self._kinematics)
            if barred is not None:
                raise fault_of(barred)
            job = self._job = self._host.move(self._name, step, now)
            if job.open:
                modes.begins(self._name, self._kinematics)
        if job.open:
            return False
        modes.ends(self._name)
        if job.state is not CommandState.DONE:
            raise ProcessFault(NOT_MOVED, text(job.reason, self._language, job.detail))
        return True


def body_maker(
    name: str, steps: Sequence[Step], kinematics: Sequence[int], host: StepHost, *, repeat: bool = False, language: str = "en"
) -> Callable[[], Body]:
    """What the process table calls for each start."""
    return lambda: Played(name, steps, kinematics, host, repeat=repeat, language=language)
