"""Gateway's side of a CiA 402 drive in cyclic synchronous position mode: one controlword image, one set position, once per SYNC.

Source: IEC 61800-7-201 (states, modes, homing), AX-302..AX-309.  607Ah is 6064h until the drive is switched on and is then kept until the
first demanded position; in any other mode than CSP it follows 6064h.  The drive object never raises on a message of the drive.
"""

from dataclasses import dataclass
from enum import Enum, IntEnum, auto
from typing import NamedTuple

from drivers.drives.cia402_states import Command, State, next_command, state_of
from drivers.drives.demand_edges import DemandEdges
from drivers.drives.family import Actual, Demand, Event, Homing, Latched, Power
from drivers.drives.held import HeldPosition

LOST_AFTER = 2  # actual values missing in a row
STILL_CYCLES, STILL_INC = 10, 2  # standstill: at most so many increments of motion over so many cycles
PIPELINE = 4  # cycles from a controlword bit to a statusword that knows of it: burst, SYNC, TPDO, and one to spare (AX-304)


class Mode(IntEnum):
    """6060h, 6061h."""

    NONE = 0
    PP = 1
    PV = 3
    HM = 6
    IP = 7
    CSP = 8


class Bit(IntEnum):
    """Bits of controlword and statusword used here."""

    START_HOMING = 0x0010  # controlword, HM
    WARNING = 0x0080
    TARGET_REACHED = 0x0400
    HOMING_ATTAINED = 0x1000  # HM
    HOMING_ERROR = 0x2000  # HM


HOME_SWITCH = 4  # 60FDh bit 2


class Cia402Actual(NamedTuple):
    """Status reported by the drive; all fields but the first two as last received."""

    statusword: int = 0  # 6041h
    position_inc: int = 0  # 6064h
    torque_permille: int = 0  # 6077h
    lag_inc: int = 0  # 60F4h
    inputs: int = 0  # 60FDh
    mode: int = 0  # 6061h
    error: int = 0  # code of the last EMCY, 0: none
    latched: Latched | None = None  # 60BAh, 60BBh, or 60BCh, 60BDh

    @property
    def reference_switch(self) -> bool:
        """Home switch of the digital inputs."""
        return bool(self.inputs & HOME_SWITCH)


class Cia402Set(NamedTuple):
    """Data sent to the drive."""

    controlword: int = 0  # 6040h
    position_inc: int = 0  # 607Ah
    mode: int = Mode.CSP  # 6060h


@dataclass(frozen=True, slots=True)
class Cia402Settings:
    """Increments and cycles; the assembly computes them from the cell."""

    jump_inc: int = 8192  # first demanded position: so close to the held one
    step_inc: int = 32768  # every later one: so close to the one before
    timeout_cycles: int = 1250  # for switching on or off (5 s at P5 = 4 ms)
    homing_cycles: int = 15_000  # for a reference run by the drive
    mode_cycles: int = 500  # until a change of mode is shown

    def make(self) -> "Cia402Drive":
        """A drive without any message so far."""
        return Cia402Drive(self)


class Phase(Enum):
    """State of the dialogue."""

    LOST = auto()  # nothing received from the drive, or not yet
    OFF = auto()
    SWITCHING_ON = auto()
    ENABLED = auto()
    TO_HOMING = auto()  # 6060h = 6 sent, waiting for 6061h
    START = auto()  # bit 4 sent: the statusword does not know of it yet
    HOMING = auto()
    AT_HOME = auto()  # attained: the drive's position has jumped to its new zero, 607Ah follows it there
    GIVING_UP = auto()  # bit 4 cleared: the axis decelerates to standstill
    TO_CSP = auto()  # 6060h = 8 sent, waiting for 6061h
    STOPPING = auto()  # quick stop, then off
    FAULT = auto()


POWERS = {
    Phase.LOST: Power.LOST,
    Phase.OFF: Power.OFF,
    Phase.SWITCHING_ON: Power.SWITCHING_ON,
    Phase.STOPPING: Power.SWITCHING_OFF,
    Phase.FAULT: Power.FAULT,
}
AT_HOMING = (Phase.TO_HOMING, Phase.START, Phase.HOMING, Phase.AT_HOME, Phase.GIVING_UP, Phase.TO_CSP)
ENABLED_PHASES = (Phase.ENABLED, *AT_HOMING)


class ReferenceRun:
    """A reference run of the drive: its demand, its outcome, and the mode of operation it needs."""

    __slots__ = ("asked", "attained", "cycles", "demand_before", "mode", "outcome")

    def __init__(self) -> None:
        self.demand_before = True  # a demand present at the start is not a command
        self.asked = False
        self.cycles = 0  # of the run, over all its phases
        self.outcome = Homing.NONE
        self.attained = False  # how the run that ends in TO_CSP went
        self.mode = Mode.CSP  # wanted

    def note(self, *, demand: bool) -> None:
        """Once a cycle."""
        self.asked = demand and (self.asked or not self.demand_before)
        self.demand_before = demand
        if not demand and self.outcome is not Homing.RUNNING:
            self.outcome = Homing.NONE

    def begin(self) -> None:
        """Homing mode is wanted."""
        self.asked, self.outcome, self.mode, self.cycles = False, Homing.RUNNING, Mode.HM, 0

    def leave(self, *, attained: bool) -> None:
        """CSP is wanted again; the outcome is reported once the drive shows it."""
        self.attained, self.mode = attained, Mode.CSP

    def end(self, *, done: bool) -> None:
        """The run is over, or there was none."""
        self.mode = Mode.CSP
        if self.outcome is Homing.RUNNING:
            self.outcome = Homing.DONE if done else Homing.FAILED


class Cia402Drive:
    """One drive.  A new object starts without a status, and a demand already present then is not a command (design 1)."""

    def __init__(self, settings: Cia402Settings | None = None) -> None:
        self._settings = settings or Cia402Settings()
        self._phase = Phase.LOST
        self._cycles = 0  # in the present phase
        self._edges, self._run = DemandEdges(), ReferenceRun()
        self._held = HeldPosition(self._settings.jump_inc, self._settings.step_inc)
        self._state: State | None = None
        self._still = 0  # cycles at standstill
        self._disable = False  # quick stop ends: the axis is at standstill, or does not reach it
        self.position_inc = 0
        self._last = Cia402Actual()
        self.fault_code = 0
        self.missing = 0
        self.epoch = 0
        self.events: list[Event] = []

    @property
    def power(self) -> Power:
        """Seen from outside."""
        return POWERS.get(self._phase, Power.ENABLED)

    @property
    def phase(self) -> Phase:
        """Exactly."""
        return self._phase

    @property
    def follows(self) -> bool:
        """In CSP and taking the demanded position."""
        return self._phase is Phase.ENABLED

    @property
    def homing(self) -> Homing:
        """Outcome of the last reference run, until its demand ends."""
        return self._run.outcome

    @property
    def configured(self) -> bool:
        """The drive answers: the master has started it up."""
        return self._phase is not Phase.LOST

    @property
    def set_inc(self) -> int:
        """Last 607Ah."""
        return self._held.inc

    @property
    def torque_permille(self) -> int:
        """Last actual torque."""
        return self._last.torque_permille

    @property
    def warning(self) -> bool:
        """Bit 7 of the last statusword."""
        return bool(self._last.statusword & Bit.WARNING)

    def idle(self) -> Cia402Set:
        """Before the first SYNC."""
        return Cia402Set()

    def step(self, actual: Actual | None, demand: Demand) -> Cia402Set:
        """actual: of this SYNC, None when none came.  The set value for the next SYNC."""
        self.events = []
        self._edges.note(demand, fault=self._phase is Phase.FAULT, lost=self._phase is Phase.LOST)
        self._run.note(demand=demand.home)
        self._run.cycles += self._phase in AT_HOMING
        if isinstance(actual, Cia402Actual):
            self._hear(actual)
            self._judge(actual, demand)
        else:
            self._miss()
        self._place(demand)
        return Cia402Set(self._controlword(), self._held.inc, self._run.mode)

    # ---- inputs ------------------------------------------------------------------------------------------------------
    def _miss(self) -> None:
        self.missing += 1
        if self.missing >= LOST_AFTER and self._phase is not Phase.LOST:
            self.epoch += 1
            self._run.end(done=False)
            self._go(Phase.LOST, Event.LOST)

    def _hear(self, actual: Cia402Actual) -> None:
        self.missing = 0
        self._still = self._still + 1 if abs(actual.position_inc - self.position_inc) <= STILL_INC else 0
        self._last, self.position_inc = actual, actual.position_inc
        self._state = state_of(actual.statusword)

    def _judge(self, actual: Cia402Actual, demand: Demand) -> None:
        """Fault and loss first, then the condition of the phase."""
        self._cycles += 1
        faulty = self._state in (State.FAULT, State.REACTING)
        self.fault_code = actual.error if faulty else 0
        if self._phase is Phase.LOST:  # a drive that is on was never commanded on, or no longer is
            self._go(Phase.STOPPING if self._state in (State.ENABLED, State.QUICK_STOP) else Phase.OFF, Event.RETURNED)
        if faulty and self._phase is not Phase.FAULT:
            self._run.end(done=False)
            self._go(Phase.FAULT, Event.FAULT)
        elif self._phase is Phase.FAULT:
            if not faulty:
                self._edges.reset_left = 0
                self._go(Phase.OFF, Event.FAULT_CLEARED)
        elif self._phase is Phase.OFF:
            if self._edges.asked:
                self._edges.asked = False
                self._go(Phase.SWITCHING_ON)
        elif self._phase is Phase.STOPPING:
            self._stop()
        else:
            self._control(actual, demand)

    def _control(self, actual: Cia402Actual, demand: Demand) -> None:
        """On the way on, or on."""
        if not demand.on:
            self._run.end(done=False)
            self._go(Phase.STOPPING)
        elif self._phase is Phase.SWITCHING_ON:
            if self._state is State.ENABLED and actual.mode == Mode.CSP:
                self._go(Phase.ENABLED, Event.ENABLED)
            elif self._cycles >= self._settings.timeout_cycles or (self._holds and self._held.strayed(self.position_inc)):
                self._go(Phase.STOPPING, Event.TIMEOUT)
        elif self._state is not State.ENABLED:
            self._run.end(done=False)
            self._go(Phase.STOPPING, Event.DROPPED)
        elif self._phase is Phase.ENABLED:
            if self._run.asked:
                self._run.begin()
                self._go(Phase.TO_HOMING)
        else:
            self._home(actual, demand)

    def _stop(self) -> None:
        """Quick stop until the drive leaves control, waits at standstill for disable voltage (605Ah 5..8), or exceeds its timeout."""
        late = self._cycles >= self._settings.timeout_cycles
        if self._state in (State.DISABLED, State.NOT_READY):
            self._go(Phase.OFF, Event.OFF)
        elif self._state is State.QUICK_STOP and self._still >= STILL_CYCLES and self._cycles > STILL_CYCLES:
            self._disable = True
        elif late and not self._disable:
            self._disable = True
            self.events.append(Event.TIMEOUT)

    # ---- referencing by the drive ------------------------------------------------------------------------------------
    def _home(self, actual: Cia402Actual, demand: Demand) -> None:
        """Source: IEC 61800-7-201, homing: bits 13, 12, 10 of the statusword; AX-304."""
        status, settings = actual.statusword, self._settings
        given_up = not demand.home or self._run.cycles >= settings.homing_cycles
        if self._phase is Phase.TO_HOMING:
            if actual.mode == Mode.HM:
                self._go(Phase.START)
            elif given_up or self._cycles >= settings.mode_cycles:
                self._back(homed=False)
        elif self._phase is Phase.START:
            if self._cycles >= PIPELINE:  # until then "attained" may belong to the previous run
                self._go(Phase.HOMING)
        elif self._phase is Phase.HOMING:
            if status & Bit.HOMING_ERROR or given_up:
                self._go(Phase.GIVING_UP)
            elif status & Bit.HOMING_ATTAINED and status & Bit.TARGET_REACHED:
                self._go(Phase.AT_HOME)
        else:
            self._return(actual)

    def _return(self, actual: Cia402Actual) -> None:
        """From home, or from where the run was aborted, back to CSP."""
        if self._phase is Phase.AT_HOME:
            if self._cycles >= PIPELINE:  # CSP must not begin with a 607Ah from before the jump
                self._back(homed=True)
        elif self._phase is Phase.GIVING_UP:
            if self._still >= STILL_CYCLES and self._cycles > STILL_CYCLES:
                self._back(homed=False)
        elif actual.mode == Mode.CSP:
            self._go(Phase.ENABLED)
            self._run.end(done=self._run.attained)
        elif self._cycles >= self._settings.mode_cycles:
            self._run.end(done=False)
            self._go(Phase.STOPPING, Event.TIMEOUT)

    def _back(self, *, homed: bool) -> None:
        self._run.leave(attained=homed)
        self._go(Phase.TO_CSP)

    # ---- outputs -----------------------------------------------------------------------------------------------------
    def _go(self, phase: Phase, event: Event | None = None) -> None:
        if phase in (Phase.FAULT, Phase.LOST):
            self._edges.asked = False
        self._phase, self._cycles, self._disable = phase, 0, False
        if event is not None:
            self.events.append(event)

    @property
    def _holds(self) -> bool:
        """The drive is switched on, or about to be enabled: 607Ah is kept."""
        return self._state in (State.SWITCHED_ON, State.ENABLED)

    def _place(self, demand: Demand) -> None:
        if self._phase is Phase.ENABLED:
            refused = self._held.take(demand.position_inc) if self._cycles else None  # in the first cycle the demand does not know of it
            if refused is not None:
                self.events.append(refused)
        elif self._phase is not Phase.TO_HOMING and not (self._phase is Phase.SWITCHING_ON and self._holds):
            self._held.follow(self.position_inc)

    def _controlword(self) -> int:
        """The only place that builds 6040h."""
        if self._phase in ENABLED_PHASES:
            start = Bit.START_HOMING if self._phase in (Phase.START, Phase.HOMING, Phase.AT_HOME) else 0
            return Command.ENABLE.value | start
        if self._phase is Phase.SWITCHING_ON and self._state is not None:
            command = next_command(self._state, State.ENABLED)
            if self._state is State.NOT_READY:  # some drives leave statusword 0000h only at their first controlword
                return Command.SHUTDOWN.value
            return Command.ENABLE.value if self._state is State.ENABLED else command.value if command else 0
        if self._phase is Phase.LOST:
            return Command.QUICK_STOP.value  # if it still receives, it brakes
        if self._phase is Phase.STOPPING and self._state in (State.ENABLED, State.QUICK_STOP) and not self._disable:
            return Command.QUICK_STOP.value
        if self._phase is Phase.FAULT and self._edges.reset_left:
            return Command.RESET.value
        return Command.DISABLE_VOLTAGE.value
