"""The command sources as services runs them: one object per way in, each with its command and status block, its link watch and its
journal words."""

import struct
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from gateway.assembly.run import CommandSource
from gateway.pure.arbitration.command_block import AXES, COMMAND_WORDS, STATUS_WORDS, Code, Command, CommandBlock, Status, mask_word
from gateway.pure.arbitration.dispatcher import CommandDispatcher
from gateway.pure.arbitration.jobs import OnLoss
from gateway.pure.arbitration.link_watch import LinkEvent, LinkWatch
from gateway.pure.controllers.control import Control
from gateway.pure.image.reasons import CommandState, Reason, Refusal
from gateway.pure.image.records.cell import AxisFlag, CellState
from gateway.runtime.regions import RegionWriter
from gateway.services.context import RunContext
from gateway.services.part import Part
from gateway.services.shared_image import SharedImage
from gateway.services.value_directory import ValueDirectory
from protocols.base.machine import Ns

_WORDS = struct.Struct(f"={COMMAND_WORDS}H{STATUS_WORDS}H")
WriteJournal = Callable[..., None]  # journal.write


@dataclass(frozen=True, slots=True)
class SourceContext:
    """Everything a command source needs: its run, the shared image, the values by name, the dispatcher; its record in the plan, the watch
    over its partner, the reaction to a loss, its region.
    """

    run: RunContext
    image: SharedImage
    values: ValueDirectory
    dispatcher: CommandDispatcher
    source: CommandSource
    watch: LinkWatch
    on_loss: OnLoss
    region: RegionWriter


class BaseSource(Part):
    """Common base of all command sources; a part of the services process."""

    medium = ""  # the page shows its traffic under this heading: lines or modbus

    def __init__(self, context: SourceContext) -> None:
        self.number, self.name, self.kind = context.source.number, context.source.name, context.source.kind
        self.dispatcher, self.watch, self.on_loss = context.dispatcher, context.watch, context.on_loss
        self._run, self._image, self._values = context.run, context.image, context.values
        self.block_status = Status()
        self.block = CommandBlock(self._latest_command(context.region), len(context.dispatcher.axes))
        self._region, self._journal = context.region, context.run.journal.write
        self._written: bytes = b""
        context.dispatcher.control.link(context.source.number, alive=False)

    @staticmethod
    def _latest_command(region: RegionWriter) -> Sequence[int]:
        latest = region.latest()
        return _WORDS.unpack_from(latest)[:COMMAND_WORDS] if latest is not None else ()

    def heard(self, now: Ns, life: int | None = None) -> None:
        """A good telegram came."""
        if self.watch.telegram(now, life) is LinkEvent.ALIVE:
            self.dispatcher.link(self.number, self.on_loss, alive=True)
            self._journal("link", f"command source {self.number} {self.name}: link is alive", source=self.number)

    @property
    def in_control(self) -> bool:
        """It may move the axes."""
        return self.dispatcher.owns(self.number)

    def move_bit(self, key: str) -> bool:
        """busy, done, refused of its last move; KeyError: it has no handshake."""
        raise KeyError(f"move.{key}")

    def join(self, control: Control) -> None:
        """The control of the run is made."""

    def show(self, outputs: bytes | None) -> None:
        """RC outputs of this tick; None: none have been published yet."""

    def passed(self, number: int) -> list[list[object]] | None:
        """Traffic after the piece or exchange of that number, for the page; None: nothing is kept."""
        return None

    def row(self) -> dict[str, object]:
        """For tools: link, last outcome, counters."""
        return {
            "number": self.number,
            "name": self.name,
            "kind": self.kind,
            "alive": self.watch.alive,
            "losses": self.watch.losses,
            "state": CommandState(self.block_status.state).name,
            "reason": Reason(self.block_status.reason).name,
            **self.counters(),
        }

    def counters(self) -> dict[str, object]:
        """For tools."""
        return {}

    def step(self, now: Ns) -> None:
        """At each tick."""
        self.wake(now)

    def wake(self, now: Ns) -> None:
        """Reports a partner that fell silent to the dispatcher."""
        if self.watch.wake(now) is LinkEvent.SILENT:
            self.dispatcher.link(self.number, self.on_loss, alive=False)
            self.restart()
            words = f"{self.silence()} for {self.watch.max_silence / 1e6:.0f} ms"
            self._journal("link", f"command source {self.number} {self.name}: {words}; {self.on_loss.value}", source=self.number)

    def silence(self) -> str:
        """The partner's behaviour instead of a sign of life."""
        return "silent"

    def restart(self) -> None:
        """The next telegram is only adopted (AX-141)."""
        self.block.link_returned()

    def refresh(self, state: CellState, axes: Sequence[tuple[float, float]], life: int, now: Ns) -> None:
        """Status words from the cycle's published state; `axes`: (actual, lag) in the axes' own units."""
        status, dispatcher = self.block_status, self.dispatcher
        job = dispatcher.source(self.number).last
        if job is not None and status.reason is not Reason.RESYNCHRONISED:
            status.state, status.reason = job.state, job.reason
        count = len(dispatcher.axes)
        status.enabled = mask_word(dispatcher.enabled_mask(), count)
        status.in_position = mask_word(dispatcher.enabled_mask(AxisFlag.IN_POSITION), count)
        status.referenced = mask_word(dispatcher.enabled_mask(AxisFlag.REFERENCED), count)
        status.fault = mask_word(dispatcher.enabled_mask(AxisFlag.FAULT | AxisFlag.LOST), count, every=False)
        own = dispatcher.control.axes_of(self.number)
        status.override, status.life, status.owner = state.override_of(own), life, self.number if own else dispatcher.owner
        for n, (actual, lag) in enumerate(axes[:AXES]):
            status.actual[n], status.lag[n] = actual, lag
        self.publish(now)

    def publish(self, now: Ns) -> None:
        """Command and status words into the command source's region."""
        payload = _WORDS.pack(*self.block.words, *self.block.status_words(self.block_status)).ljust(self._region.size, b"\0")
        if payload != self._written:
            self._written = payload
            self._region.write(payload, now)

    def write_words(self, first: int, values: Sequence[int], now: Ns) -> None:
        """Words into the own command block; a fresh command goes to the dispatcher."""
        fresh = self.block.write(first, values)
        if isinstance(fresh, Command):
            self.block_status.reason = Reason.NONE
            job = self.dispatcher.command(self.number, fresh, now)
            self.block_status.state, self.block_status.reason = job.state, job.reason
        elif isinstance(fresh, Refusal):
            job = self.dispatcher.refuse(self.number, Code(self.block.words[0] & 0xFF), fresh.reason, fresh.detail)
            self.block_status.state, self.block_status.reason = job.state, job.reason
        elif fresh is Reason.RESYNCHRONISED:
            self.block_status.state, self.block_status.reason = CommandState.NONE, Reason.RESYNCHRONISED


def on_loss_of(word: str) -> OnLoss:
    """The cell's reaction to a dead link."""
    return OnLoss(word)
