"""The interpreter of a running cell: modes, START and STOP as in virtual time, the way is the planner's.  Source: robotstar 1.4, 1.5.

Steps without outside effect run ahead of the robot.  A step that reads the cell, waits, stops the program or is wrong does so where the
position before it is over.
"""

from collections.abc import Callable
from dataclasses import dataclass, field

from gateway.pure.languages.base.requests import Ns
from gateway.pure.languages.robotstar.ahead import Ahead
from gateway.pure.languages.robotstar.faults import StepFault
from gateway.pure.languages.robotstar.machine import Go, NotYet
from gateway.pure.languages.robotstar.path import Target
from gateway.pure.languages.robotstar.program import Program
from gateway.pure.languages.robotstar.robot import CYCLE, Message, Mode, Robot, State

BREAKPOINT = "breakpoint"  # how a program stopped before a step with one


class NoDrive:
    """Of a robot whose positions go to the planner; only virtual time asks it."""

    def begin(self, target: Target, now: Ns) -> str:
        """A way begins."""
        del target, now
        return ""

    def way(self, part: float) -> None:
        """How much of the way is done."""

    def arrived(self, target: Target, mode: str, now: Ns) -> None:
        """The position is reached."""

    def factor(self) -> float:
        """Override."""
        return 1.0


@dataclass(slots=True)
class CellRobot(Robot):
    """Call `advance` once a turn; how: what it stopped for, "ended" (STOP, END, a single step), "breakpoint", "stopped" or
    "aborted"."""

    ahead: Ahead = field(kw_only=True)
    places: Callable[[], tuple[float, ...]] = field(kw_only=True)  # set values of the cell's axes
    how: str = ""
    fault: Message | None = None
    _blocked: bool = False  # the step in force waits for the positions before
    _halting: str = ""  # how the program ends where the last position is over
    _put: Go | None = None  # prepared

    @property
    def quits(self) -> str:
        """How an error is acknowledged in a cell."""
        return "acknowledge it with RC input 62 or the key Quit: axisgate var reis.key.quit --set 1, then --set 0"

    # ---- orders ----------------------------------------------------------------------------------------------------------
    def select(self, program: Program) -> None:
        """Choose a program; an interrupted one is not resumed (L1262)."""
        self._drop()
        Robot.select(self, program)

    def to_step(self, step: int) -> None:
        """The same for a step of the program selected."""
        self._drop()
        self.machine.to_step(step)
        self._forget()

    def _drop(self) -> None:
        self.ahead.forget()
        self._blocked, self._halting = False, ""
        self._put, self.how, self.fault = None, "", None

    def set_mode(self, mode: Mode) -> None:
        """Another mode, while the program is stopped (L1264)."""
        self.mode = mode
        self.machine.repeats, self.machine.returns = mode.repeats, not mode.executer
        self.machine.simulated, self.machine.executer = mode.simulated, mode.executer

    def start(self, now: Ns) -> str:
        """START; "" or why it is refused."""
        wrong = Robot.start(self, now)
        if not wrong:
            self.how, self.fault = "", None
            self.ahead.goes_on(self.places(), self.machine.tool)
        return wrong

    def stop(self, now: Ns) -> None:
        """STOP on the path; START continues from there."""
        if self.state in (State.RUNNING, State.WAITING):
            self.how = "stopped"
            self.ahead.rests(self.places())
        Robot.stop(self, now)

    def fails(self, fault: StepFault, place: tuple[str, int]) -> None:
        """What was handed on cannot be run: an error of its step."""
        self.how, self.state = "aborted", State.ERROR
        self.failure = self.fault = Message(fault.text, fault.code or None, *place, fault.kind)
        self.say(self.fault)

    # ---- time ------------------------------------------------------------------------------------------------------------
    def advance(self, now: Ns) -> Ns | None:
        """Runs up to now; when it is to be called again, None: only when something changes."""
        if self._blocked or self._halting:
            if self.ahead.busy or self.state is not State.RUNNING:
                return now + CYCLE
            self._blocked = False
            if self._halting:
                how, self._halting = self._halting, ""
                self._stops_itself(how)
                return None
        return Robot.advance(self, now)

    def _steps(self, budget: int, now: Ns) -> int:
        try:
            left = Robot._steps(self, budget, now)
        except NotYet:
            self._blocked = True
        return 0 if self._blocked or self._halting else left

    def _halted(self, *, at_breakpoint: bool) -> None:
        how = BREAKPOINT if at_breakpoint else "ended"
        if self.ahead.busy:
            self._halting = how
        else:
            self._stops_itself(how)

    def _stops_itself(self, how: str) -> None:
        self.how = how
        Robot._halted(self, at_breakpoint=how == BREAKPOINT)

    def _failed(self, fault: StepFault) -> None:
        if self.ahead.busy:
            self._blocked = True  # the step is executed again where the position before is over
            return
        frame = self.machine.frame
        assert frame is not None
        Robot._failed(self, fault)
        self.how = "aborted"
        self.fault = Message(fault.text, fault.code or None, frame.program.name, frame.at + 1, fault.kind)

    def _step_done(self, now: Ns) -> None:
        Robot._step_done(self, now)
        if self.state is State.STOPPED and not self.how:
            self.how = "ended"

    def _serve(self, now: Ns) -> Ns | None:
        request = self.machine.request
        if isinstance(request, Go):
            self.state = State.RUNNING
            return self._way(request, now)
        if self.ahead.busy:
            self.state, self._asked_at = State.RUNNING, now  # the time of a wait continues where the position is reached
            return now + CYCLE
        return Robot._serve(self, now)

    def _way(self, request: Go, now: Ns) -> Ns | None:
        if request is not self._put:
            if not self.ahead.room() or (self.single and self.ahead.busy):
                return now + CYCLE
            try:
                self.ahead.put(request, self.machine.world.planned(), self.places())
            except StepFault as fault:
                self._failed(fault)
                if self._blocked:
                    return now + CYCLE
                return None
            self._put = request
        if self.single and self.ahead.busy:
            return now + CYCLE
        self._put = None
        self.machine.answered()
        return None

    @property
    def waits(self) -> bool:
        """Nothing is prepared before something has happened in the cell."""
        request = self.machine.request
        asks = request is not None and not isinstance(request, Go)
        halts = self._blocked or bool(self._halting) or self.single
        return halts or asks or self.ahead.full or self.state is not State.RUNNING

    # ---- what shows ------------------------------------------------------------------------------------------------------
    @property
    def moving(self) -> bool:
        """Return whether a movement is running."""
        return self.state is State.RUNNING and self.ahead.under_way() is not None

    def place(self) -> tuple[str, int]:
        """Program and step in work: of the position under way, else under the cursor."""
        block = self.ahead.under_way()
        return Robot.place(self) if block is None else block.place

    def done(self) -> tuple[str, int]:
        """Program and step that was executed last: before the position under way, else before the cursor."""
        block = self.ahead.under_way()
        return self.machine.last_done() if block is None else block.done

    def cursor(self) -> tuple[str, int]:
        """Program and step that is executed next."""
        return Robot.place(self)
