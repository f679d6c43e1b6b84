"""Signals that command the axes, as commands of their command sources: the dispatcher judges them like every other command.

Source: rho3 4.10 (L1295-1305, L7920-7941); AX-333.  Control is asked for with the first drive-on of a command source and given back at rest
when its last one has fallen, as an old-style command source does it.
"""

from collections.abc import Mapping

from gateway.pure.arbitration.command_block import Code, Command
from gateway.pure.arbitration.dispatcher import CommandDispatcher
from gateway.pure.arbitration.jobs import Job
from gateway.pure.controllers.rho3.signals.drives import Asked
from gateway.pure.controllers.rho3.signals.steps import Step
from gateway.pure.image.records.cell import CellState, Motion
from motion.program.factors import FULL, Factors
from protocols.base.machine import Ns

AT_REST = (Motion.IDLE, Motion.STOPPED)


class AxisCommands:
    """Requests of the signals to the dispatcher."""

    def __init__(self, dispatcher: CommandDispatcher, sets_override: bool) -> None:
        """`sets_override`: no other source of this cell does, so drive-on sets 100 %."""
        self._dispatcher, self._sets_override = dispatcher, sets_override
        self._leaving: set[int] = set()  # command sources whose drive-on has fallen: control goes back at rest
        self._abandon: list[Job] = []  # stopped moves, given up as soon as they rest

    def drives(self, asked: Mapping[int, Asked], wanted: int, disabled: int, now: Ns) -> None:
        """Edges of the drive-on signals; `wanted`: axes whose signal is set, `disabled`: axes that stay off regardless of it."""
        for source, change in asked.items():
            if change.off:
                self._say(source, Command(Code.DISABLE, change.off), now)
                if not wanted:
                    self._leaving.add(source)
            on = change.on & ~disabled
            if on:
                self._leaving.discard(source)
                self._switch_on(source, on, now)

    def _switch_on(self, source: int, mask: int, now: Ns) -> None:
        if not self._dispatcher.owns(source):
            self._say(source, Command(Code.REQUEST_CONTROL), now)
        self._say(source, Command(Code.ENABLE, mask), now)
        cell = self._dispatcher.cell
        if (
            self._sets_override
            and cell is not None
            and self._dispatcher.owns(source)
            and cell.override_of(self._dispatcher.control.axes_of(source)) <= 0.0
        ):
            self._say(source, Command(Code.OVERRIDE, velocity=1.0), now)

    def move(self, source: int, step: Step, now: Ns, factors: Factors = FULL) -> Job:
        """A step that moves: PTP of the axes it names, or a program of the cell; `factors`: V and A of the control (AX-495)."""
        speed, acceleration = step.speed * factors.velocity, factors.acceleration
        if step.program is not None:
            return self._dispatcher.order_program(source, step.program, now, speed, acceleration)
        mask = sum(1 << number for number in step.to)
        places = tuple(step.to.get(n, 0.0) for n in range(mask.bit_length()))
        return self._say(source, Command(Code.PTP_ABSOLUTE, mask, speed, acceleration, places), now)

    def stream(self, source: int, robot: int, mask: int) -> Job:
        """Blocks of a program of the interpreter; refused as any other command of that command source."""
        return self._dispatcher.order_stream(source, robot, mask)

    def reference(self, source: int, mask: int, now: Ns) -> Job:
        """A reference run of these axes."""
        return self._say(source, Command(Code.REFERENCE, mask), now)

    def slow(self, move: Job, share: float) -> None:
        """Special function 41: a share, 0 .. 1, of the speed of the move under way."""
        self._dispatcher.slow_move(move, share)

    def run_on(self, mask: int, distance: float) -> None:
        """Special function 42: m or rad that these axes continue after an edge."""
        self._dispatcher.run_on(mask, distance)

    def stop(self, source: int, now: Ns, give_up: Job | None = None) -> None:
        """Stops on the path; `give_up`: the move whose rest is abandoned, as where a program is taken off (L2610)."""
        if give_up is None:
            self._say(source, Command(Code.STOP), now)
            return
        if self._lanes:
            self._dispatcher.stop_move(give_up)  # the other lanes continue
        else:
            self._say(source, Command(Code.STOP), now)
        self._abandon.append(give_up)

    def resume(self, source: int, now: Ns) -> None:
        """Goes on with a stopped move."""
        self._say(source, Command(Code.RESUME), now)

    def override(self, source: int, value: float, now: Ns) -> None:
        """0..1."""
        self._say(source, Command(Code.OVERRIDE, velocity=value), now)

    def bar(self, mask: int) -> None:
        """These axes are disabled at the interface."""
        self._dispatcher.bar(mask)

    def open_ready(self) -> None:
        """The READY contact opens."""
        self._dispatcher.open_ready()

    def settle(self, now: Ns) -> None:
        """Once per cycle: what had to wait for rest."""
        cell = self._dispatcher.cell
        for job in list(self._abandon):
            if not job.open:
                self._abandon.remove(job)  # it has ended, or its remainder is gone
            elif cell is not None and cell.motion_of(job.span) is Motion.STOPPED:
                self._abandon.remove(job)
                if self._lanes:
                    self._dispatcher.abandon_move(job)
                else:
                    self._say(job.source, Command(Code.ABANDON), now)
        for source in list(self._leaving):
            if self._motion(source, cell) in AT_REST:
                self._leaving.discard(source)
                if self._dispatcher.owns(source):
                    self._say(source, Command(Code.RELEASE_CONTROL), now)

    @property
    def _lanes(self) -> bool:
        return self._dispatcher.cell is not None and bool(self._dispatcher.cell.apart)

    def _motion(self, source: int, cell: CellState | None) -> Motion:
        """Of what this command source has control of."""
        return cell.motion_of(self._dispatcher.control.axes_of(source)) if cell is not None else Motion.IDLE

    def _say(self, source: int, command: Command, now: Ns) -> Job:
        return self._dispatcher.command(source, command, now)
