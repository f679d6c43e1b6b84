"""Moves that programs of a control have under way, each in the name of the command source that started the program.  Pure."""

from collections.abc import Callable

from gateway.pure.arbitration.jobs import Job
from gateway.pure.controllers.rho3.functions.processes import State
from gateway.pure.controllers.rho3.signals.commands import AxisCommands
from gateway.pure.controllers.rho3.signals.control_state import ControlState
from gateway.pure.controllers.rho3.signals.hosted import HostedPrograms
from gateway.pure.controllers.rho3.signals.steps import Step, fault_of
from protocols.base.machine import Ns


class ProgramMoves:
    """Of programs of the cell and of the interpreter (`hosted`; None: there is none)."""

    def __init__(self, control: ControlState, commands: AxisCommands, hosted: Callable[[], HostedPrograms | None]) -> None:
        self._control, self._commands, self._hosted = control, commands, hosted
        self._jobs: dict[tuple[str, int], Job] = {}  # program and robot (0: a step of its own) -> its move
        self._listed: set[str] = set()  # programs with a process, as of the last cycle

    @property
    def selector(self) -> int:
        """The command source whose byte carries the selection strobe: programs move the axes in its name."""
        setup = self._control.setup
        return setup.owners.get(setup.functions.places.select_strobe >> 3, 0)

    def begin(self, program: str, step: Step, now: Ns) -> Job:
        """A step of a program; refused as any other command of that command source."""
        control = self._control
        process = control.processes.named(program)
        kinematic = 1 if process is None else (process.kinematics & -process.kinematics).bit_length()  # the lowest it moves
        factors = control.factor_table.acting(min(max(kinematic, 1), control.setup.installation.kinematics))
        job = self._jobs[program, 0] = self._commands.move(self.selector, step, now, factors)
        return job

    def open_path(self, program: str, robot: int) -> Job:
        """A program of the interpreter moves a robot from now on.  ProcessFault."""
        return self._opened(program, robot, lambda source, mask: self._commands.stream(source, robot, mask))

    def open_reference(self, program: str, robot: int, now: Ns) -> Job:
        """REF_PNT.  ProcessFault."""
        return self._opened(program, robot, lambda source, mask: self._commands.reference(source, mask, now))

    def _opened(self, program: str, robot: int, ask: Callable[[int, int], Job]) -> Job:
        hosted, control = self._hosted(), self._control
        tested = hosted is not None and hosted.tests(program)
        barred = control.modes.set_up(program, robot) if tested else control.modes.prepare(program, (robot,))
        if barred is not None:
            raise fault_of(barred)
        source = (hosted.source_of(program) if hosted is not None else 0) or self.selector
        job = self._jobs[program, robot] = ask(source, control.setup.robot_masks[robot - 1])
        if job.open and not tested:
            control.modes.begins(program, (robot,))
        return job

    def closed(self, program: str, robot: int) -> None:
        """Its order is over."""
        self._control.modes.ends(program, robot)
        self._jobs.pop((program, robot), None)

    def end(self, now: Ns) -> None:
        """The motion of a program that is gone or in error ends at once and is not finished (L2610)."""
        processes = self._control.processes
        for (name, robot), job in list(self._jobs.items()):
            process = processes.named(name)
            alive = process is not None and process.state is not State.FAULTY
            if job.open and not alive:
                self._commands.stop(job.source, now, give_up=job)
            if not job.open or not alive:
                del self._jobs[name, robot]
        listed = {process.name for process in processes.processes}
        for name in self._listed - listed:
            self._control.modes.deselected(name)
        self._listed = listed
