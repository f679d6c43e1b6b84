"""IO logic and PPO of a dry run: special functions 1 and 2, led by the coordinates of its straight blocks (rho 3, L4210-4264).  Pure.

What they do on the way is motion.outputs.rho3 (AX-465, AX-466).  A call acts from the next block of its kinematic on, as in a cell.
The trace has the value where it is final, not each step of a PPO (AX-1682).
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

from gateway.pure.languages.baps2.errors import fault
from gateway.pure.languages.baps2.frames import to_workpiece
from gateway.pure.languages.baps2.machine import Machine
from gateway.pure.languages.baps2.tasks import Block, Task
from motion.errors import MotionError
from motion.outputs.rho3 import Call, Kind, PathOutputs

KINDS = {1: Kind.IOL, 2: Kind.PPO}
IN_USE = {1: 216, 2: 217}
ONE = 1  # number under which the outputs of a single function know it
Key = tuple[int, str, int]  # special function, kinematic, function number
NS = 1_000_000_000


@dataclass(frozen=True, slots=True)
class _Asked:
    """A call that waits for its block."""

    key: Key
    task: Task
    line: int
    call: Call


@dataclass(slots=True)
class DryOutputs:
    """All functions of a dry run."""

    machine: Machine
    _waiting: list[_Asked] = field(default_factory=list)
    _blocks: dict[int, list[_Asked]] = field(default_factory=dict)  # number of a block -> what begins with it
    _outputs: dict[Key, PathOutputs] = field(default_factory=dict)
    _running: dict[Key, _Asked] = field(default_factory=dict)
    _stepped: int = 0  # the moment of the last step

    @property
    def on(self) -> bool:
        """Positions are wanted once in a P5."""
        return bool(self._running)

    def call(self, task: Task, function: int, kinematic: str, size: int, values: Sequence[object]) -> None:
        """Record IOL or PPO when the program reaches it.  size: components of the kinematic's points, 0: not known."""
        number, coordinate, offset = (int(v) if isinstance(v, int | float) else 0 for v in (values[0], values[2], values[5]))
        position, value = (float(v) if isinstance(v, int | float) else 0.0 for v in (values[3], values[4]))
        if number == 0 or (number > 0 and not 1 <= coordinate <= (size or coordinate)):
            raise fault(218, f"function {number}, coordinate {coordinate}")
        key = (function, kinematic, abs(number))
        if number > 0:
            self._waiting.append(_Asked(key, task, task.process.line, Call(ONE, 1, coordinate, position, value, offset)))
            return
        self._waiting = [each for each in self._waiting if each.key != key]
        self._running.pop(key, None)
        self._of(key).call(KINDS[function], Call(-ONE, 1, 1, 0.0, value))
        self._say(task, key, task.process.line)

    def prepared(self, block: Block) -> None:
        """What has been asked for its kinematic begins with this block."""
        mine = [each for each in self._waiting if each.key[1] == block.kinematic]
        if mine:
            self._blocks[block.number] = [each for each in mine if not each.task.process.over]
            self._waiting = [each for each in self._waiting if each not in mine]

    def begun(self, block: Block) -> None:
        """A block begins; a runtime error where a function is still in use."""
        for asked in self._blocks.pop(block.number, ()):
            function = asked.key[0]
            try:
                self._of(asked.key).call(KINDS[function], asked.call)
            except MotionError as error:
                raise fault(IN_USE[function]) from error
            self._running[asked.key] = asked
            self._stepped = self.machine.now
            self._step(asked, 1.0)  # where the coordinate begins

    def step(self) -> None:
        """At each moment of the dry run."""
        now = self.machine.now
        if now > self._stepped:
            period, self._stepped = (now - self._stepped) / NS, now
            for asked in list(self._running.values()):
                self._step(asked, period)

    def _step(self, asked: _Asked, period_s: float) -> None:
        function, kinematic, _ = asked.key
        lane, outputs = self.machine.lane(kinematic), self._of(asked.key)
        place = to_workpiece(lane.frame, self.machine.where(kinematic))
        if len(place) < asked.call.coordinate:
            return
        said = outputs.step(1, place, period_s)
        if said:
            self.machine.event(asked.task, "warning", asked.line, text=said.partition(" (")[0])
        if said or not outputs.in_use(KINDS[function], 1, ONE):
            del self._running[asked.key]
            self._say(asked.task, asked.key, asked.line)

    def _of(self, key: Key) -> PathOutputs:
        return self._outputs.setdefault(key, PathOutputs())

    def _say(self, task: Task, key: Key, line: int) -> None:
        function, _, number = key
        value = self._of(key).outputs.get((KINDS[function], 1, ONE), 0.0)
        self.machine.outputs[number] = value
        self.machine.event(task, "out", line, channel=number, value=int(value) if value.is_integer() else value)
