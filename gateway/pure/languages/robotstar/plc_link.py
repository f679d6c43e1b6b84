"""The integrated PLC in parallel with the robot program in virtual time: one image of markers and outputs.  Source: robotstar 5.1, 5.6,
5.8.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

from gateway.pure.languages.base.faults import Faults
from gateway.pure.languages.base.requests import Ns
from gateway.pure.languages.base.source import Position
from gateway.pure.languages.plc.check import check_programs
from gateway.pure.languages.plc.messages import DRIVES_OFF, NOTE, TEXT_PROGRAM
from gateway.pure.languages.plc.messages import Message as PlcMessage
from gateway.pure.languages.plc.plc import Plc, PlcState
from gateway.pure.languages.robotstar.robot import CYCLE, Message
from gateway.pure.languages.robotstar.virtual import BASES, VirtualCell

INPUTS, OUTPUTS, AREA = BASES["INPUT"], BASES["OUTPUT"], 40
QUIET = frozenset((*range(944, 948), *range(988, 1148), *range(1464, 1480)))  # filled by the system: no event


@dataclass(slots=True)
class PlcLink:
    """Scans once a cycle.  `sources`: programs by path below the root without suffix; `start`: the name to begin with."""

    sources: Mapping[str, str]
    start: str
    plc: Plc = field(init=False)
    _shown: PlcState = PlcState.STOP
    _on: bool = False

    def __post_init__(self) -> None:
        texts = {TEXT_PROGRAM if _is_text(key) else key: text for key, text in self.sources.items()}
        self.plc = Plc(texts)

    def power_on(self, cell: VirtualCell) -> None:
        """Starts the program; a refused start is a message for each fault."""
        if self._on:
            self.plc.power_on(self.plc.retained(cell.now), cell.now)
            self.plc.drives = True
        self._on = True
        for message in self.plc.start(start_of(self.sources, self.start)):
            cell.say(_message(message))
        self.plc.take_messages()
        self._state(cell)

    def scan(self, cell: VirtualCell, now: Ns) -> Ns:
        """One scan over the common image; outputs the PLC wrote are its own (L2274)."""
        memory = self.plc.data.memory
        memory[:] = cell.image
        self.plc.drives = cell.drives
        outputs = self.plc.scan(now, bytes(cell.image[INPUTS : INPUTS + AREA]))
        self._take_markers(cell, memory)
        self._take_outputs(cell, outputs)
        self._state(cell)
        self._messages(cell)
        return now + CYCLE

    def acknowledge(self, cell: VirtualCell) -> None:
        """The operator has acknowledged: M1021.1."""
        if self.plc.shown_message is not None:
            self.plc.acknowledge()
            cell.image[1021] = cell.image[1021] & ~1 | 2

    def owned(self, number: int) -> int:
        """The bits of an output byte that the last scan wrote; those of a stopped PLC are the robot's."""
        return self.plc.outputs_written[number] if self.plc.state is PlcState.RUN else 0

    def _take_markers(self, cell: VirtualCell, memory: bytearray) -> None:
        for number in range(INPUTS) if memory[:INPUTS] != cell.image[:INPUTS] else ():
            if memory[number] != cell.image[number]:
                if number in QUIET:
                    cell.image[number] = memory[number]
                else:
                    cell.set_byte(number, memory[number])
        cell.image[INPUTS : INPUTS + AREA] = memory[INPUTS : INPUTS + AREA]  # inputs a program wrote

    def _take_outputs(self, cell: VirtualCell, outputs: bytes) -> None:
        stopped = self.plc.state is PlcState.STOP and self._shown is PlcState.RUN
        for number, (value, mask) in enumerate(zip(outputs, self.plc.outputs_written, strict=True)):
            own = 0xFF if stopped else mask if self.plc.state is PlcState.RUN else 0
            cell.set_byte(OUTPUTS + number, cell.image[OUTPUTS + number] & ~own | value & own)

    def _state(self, cell: VirtualCell) -> None:
        if self.plc.state is not self._shown:
            self._shown = self.plc.state
            cell.state_event(self._shown.value)

    def _messages(self, cell: VirtualCell) -> None:
        for message in self.plc.take_messages():
            if message.reaction == NOTE:
                cell.say(_message(message))
            else:
                cell.robot.fail(_message(message))
            if message.reaction == DRIVES_OFF:
                cell.set_drives(False)


def _message(message: PlcMessage) -> Message:
    return Message(message.text, message.number, message.program, message.step, message.kind)


def start_of(sources: Mapping[str, str], name: str) -> str:
    """The path of a start program: as given, else the first of that name."""
    wanted = name.strip().replace("\\", "/").upper().partition(":")[2].lstrip("/") if ":" in name else name.strip().upper()
    wanted = wanted.removesuffix(".PLC")
    keys = sorted(sources)
    return next((key for key in keys if key.upper() == wanted), next((key for key in keys if key.upper().endswith("/" + wanted)), name))


def _is_text(key: str) -> bool:
    """Whether a program is that of the clear texts (L2825)."""
    return key.upper().rpartition("/")[2] == TEXT_PROGRAM


def check_plc(sources: Mapping[str, str], files: Mapping[str, str], faults: Faults) -> None:
    """Faults of all PLC programs; `files`: the file of each."""
    names = {key.upper(): file for key, file in files.items()}
    for fault in check_programs(sources):
        place = Position(names.get(fault.position.file.upper(), fault.position.file), fault.position.line, fault.position.column)
        faults.error("plc." + fault.id, place, fault.text, fault.hint)
