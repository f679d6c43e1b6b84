"""The command sources as services runs them: one object per way in, each with its command and status block, its link watch and its
journal words."""

import struct
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from gateway.assembly.run import CommandSource
from gateway.pure.arbitration.command_block import AXES, COMMAND_WORDS, STATUS_WORDS, Code, Command, CommandBlock, Status, mask_word
from gateway.pure.arbitration.data_blocks import DataBlocks
from gateway.pure.arbitration.dispatcher import CommandDispatcher
from gateway.pure.arbitration.jobs import OnLoss
from gateway.pure.arbitration.link_watch import LinkEvent, LinkWatch
from gateway.pure.cell.cell import Cell
from gateway.pure.image.reasons import CommandState, Reason, Refusal
from gateway.pure.image.records.cell import AxisFlag, CellState
from gateway.runtime.regions import RegionWriter
from protocols.base.machine import Ns

_WORDS = struct.Struct(f"={COMMAND_WORDS}H{STATUS_WORDS}H")
Tell = Callable[..., None]  # journal.write


@dataclass(frozen=True)
class SourceContext:
    """Context of a command source of a run: its record in the plan, the dispatcher, the supervision of its partner, what a loss
    does, its
    region, the journal."""

    door: CommandSource
    office: CommandDispatcher
    watch: LinkWatch
    on_loss: OnLoss
    region: RegionWriter
    tell: Tell


class BaseSource:
    """What all command sources share."""

    def __init__(self, post: SourceContext) -> None:
        self.number, self.name, self.kind = post.door.number, post.door.name, post.door.kind
        self.office, self.watch, self.on_loss = post.office, post.watch, post.on_loss
        self.status = Status()
        self.block = CommandBlock(self._left_standing(post.region), len(post.office.axes))
        self._region, self._tell = post.region, post.tell
        self._written: bytes = b""
        post.office.control.link(post.door.number, alive=False)

    @staticmethod
    def _left_standing(region: RegionWriter) -> Sequence[int]:
        latest = region.latest()
        return _WORDS.unpack_from(latest)[:COMMAND_WORDS] if latest is not None else ()

    def heard(self, now: Ns, life: int | None = None) -> None:
        """A good telegram came."""
        if self.watch.telegram(now, life) is LinkEvent.ALIVE:
            self.office.link(self.number, self.on_loss, alive=True)
            self._tell("link", f"command source {self.number} {self.name}: link is alive", door=self.number)

    def wake(self, now: Ns) -> None:
        """Notify the dispatcher when the partner fell silent."""
        if self.watch.wake(now) is LinkEvent.SILENT:
            self.office.link(self.number, self.on_loss, alive=False)
            self.restart()
            words = f"{self.silence()} for {self.watch.max_silence / 1e6:.0f} ms"
            self._tell("link", f"command source {self.number} {self.name}: {words}; {self.on_loss.value}", door=self.number)

    def silence(self) -> str:
        """What the partner did instead of a sign of life."""
        return "silent"

    def restart(self) -> None:
        """The next telegram is only adopted (AX-141)."""
        self.block.link_returned()

    def refresh(self, state: CellState, axes: Sequence[tuple[float, float]], life: int, now: Ns) -> None:
        """Status words out of what the cycle published; `axes`: (actual, lag) in the axes' own units."""
        status, office = self.status, self.office
        job = office.door(self.number).last
        if job is not None and status.reason is not Reason.RESYNCHRONISED:
            status.state, status.reason = job.state, job.reason
        count = len(office.axes)
        status.enabled = mask_word(office.enabled_mask(), count)
        status.in_position = mask_word(office.enabled_mask(AxisFlag.IN_POSITION), count)
        status.referenced = mask_word(office.enabled_mask(AxisFlag.REFERENCED), count)
        status.fault = mask_word(office.enabled_mask(AxisFlag.FAULT | AxisFlag.LOST), count, every=False)
        status.override, status.life, status.owner = state.override, life, office.owner
        for n, (actual, lag) in enumerate(axes[:AXES]):
            status.actual[n], status.lag[n] = actual, lag
        self.publish(now)

    def publish(self, now: Ns) -> None:
        """Command and status words into the command source's region."""
        payload = _WORDS.pack(*self.block.words, *self.block.status_words(self.status)).ljust(self._region.size, b"\0")
        if payload != self._written:
            self._written = payload
            self._region.write(payload, now)

    def write_words(self, first: int, values: Sequence[int], now: Ns) -> None:
        """Words into the own command block; a fresh command goes to the dispatcher."""
        fresh = self.block.write(first, values)
        if isinstance(fresh, Command):
            self.status.reason = Reason.NONE
            job = self.office.command(self.number, fresh, now)
            self.status.state, self.status.reason = job.state, job.reason
        elif isinstance(fresh, Refusal):
            job = self.office.refuse(self.number, Code(self.block.words[0] & 0xFF), fresh.reason, fresh.detail)
            self.status.state, self.status.reason = job.state, job.reason
        elif fresh is Reason.RESYNCHRONISED:
            self.status.state, self.status.reason = CommandState.NONE, Reason.RESYNCHRONISED


def on_loss_of(word: str) -> OnLoss:
    """The cell's word for what a dead link does."""
    return OnLoss(word)


class CellValues:
    """One place that knows what every `from` name means."""

    def __init__(self, cell: Cell) -> None:
        self._axes = {axis.name: (n, 1000.0 if axis.unit == "mm" else 57.29577951308232) for n, axis in enumerate(cell.axis)}
        self._count = len(cell.axis)
        self.state = CellState()
        self.life = 0
        self.errors: list[tuple[int, str]] = []  # standing, first one first
        self.refusals: dict[
            int, tuple[int, str, int]
        ] = {}  # command source -> reason, words, stamp: what that command source was last refused

    def names(self) -> list[str]:
        """Every name that can be read."""
        single = ["ready", "drives_on", "emergency_stop", "error", "life", "override", "motion"]
        fields = ["actual", "set", "lag", "speed", "torque", "enabled", "referenced", "in_position", "fault"]
        axes = [f"axis.{name}.{field}" for name in (*self._axes, "*") for field in fields if name != "*" or field in _FLAGS]
        return [f"cell.{name}" for name in single] + ["error.first.code"] + axes

    def get(self, name: str, door: "BaseSource | None" = None) -> float:
        """Value in the unit of the name; KeyError for an unknown name."""
        match name.split("."):
            case ["cell", key]:
                return self._cell(key, door)
            case ["error", "first", "code"]:
                return float(next((code for code, *_ in self._seen_by(door)), 0))
            case ["axis", "*", key]:
                flag = _FLAGS[key]
                return float(all(axis.flags & flag for axis in self.state.axes[: self._count]))
            case ["axis", axis, key]:
                return self._axis(axis, key)
            case ["move", key] if door is not None:
                return float(_move_bit(door, key))
        raise KeyError(name)

    def _cell(self, key: str, door: "BaseSource | None") -> float:
        state = self.state
        match key:
            case "ready":
                return float(state.ready)
            case "drives_on":
                return float(all(axis.flags & AxisFlag.ENABLED for axis in state.axes[: self._count]))
            case "emergency_stop":
                return float(state.emergency)
            case "error":
                return float(bool(self._seen_by(door)))
            case "life":
                return float(self.life & 0x7FFF)
            case "override":
                return state.override * 100.0
            case "motion":
                return float(state.motion)
            case "control" if door is not None:
                return float(door.office.owner == door.number)
        raise KeyError(f"cell.{key}")

    def _seen_by(self, door: "BaseSource | None") -> list[tuple[int, str]]:
        """Standing errors, and what this very command source was refused last; another command source's mistakes are not its business."""
        own = self.refusals.get(door.number) if door is not None else None
        return self.errors + ([own[:2]] if own is not None else [])

    def _axis(self, name: str, key: str) -> float:
        if name not in self._axes:
            raise KeyError(f"axis.{name}.{key}; axes are {', '.join(self._axes)}")
        n, factor = self._axes[name]
        axis = self.state.axes[n]
        match key:
            case "actual":
                return axis.actual * factor
            case "set":
                return axis.set * factor
            case "lag":
                return axis.lag * factor
            case "speed":
                return axis.speed * factor
            case "torque":
                return axis.torque * 100.0
        return float(bool(axis.flags & _FLAGS[key]))


_FLAGS = {
    "enabled": AxisFlag.ENABLED,
    "referenced": AxisFlag.REFERENCED,
    "in_position": AxisFlag.IN_POSITION,
    "fault": AxisFlag.FAULT | AxisFlag.LOST,
}


def _move_bit(door: "BaseSource", key: str) -> bool:
    data = getattr(door, "data", None)
    if not isinstance(data, DataBlocks):
        raise KeyError(f"move.{key}")
    return data.handshake_bit(key)
