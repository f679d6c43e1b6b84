"""The cell in virtual time with CiA 402 drives: core and dispatcher, emulated nodes, the real plan without the threads of a master."""

from collections.abc import Generator, Sequence
from typing import TypeVar

from drivers.drives import canopen_steps as steps
from drivers.drives import cia402_boot as plans
from drivers.drives.canopen_steps import Answer, Refused, Silent
from drivers.drives.cia402_boot import Booted
from drivers.drives.family import BusFamily
from drivers.emulator.cia402.slave import Cia402Slave
from gateway.assembly.canopen_nodes import node_plans
from gateway.assembly.drive_buses import make_family
from gateway.assembly.plant import bus_settings
from gateway.cell_file.load import load_cell
from gateway.files.eds_sheets import read_eds
from gateway.pure.cell.cell import Cell
from hil_tests.lab.virtual.cell_bench import CellBench
from protocols.base.machine import Frame, ms
from protocols.canopen import cob_id as cobid
from protocols.canopen import nmt, sdo
from protocols.canopen.nmt import State

DEMO_402: Cell = load_cell("demo-402")
PATIENCE_MS = 300
T = TypeVar("T")


class Dialogue:
    """Carries out the steps of a start-up on one emulated node, frame by frame, in bus time."""

    def __init__(self, slave: Cia402Slave, node: int, now: int) -> None:
        self.slave, self.node, self.now = slave, node, now
        self.heard: list[Frame] = []
        self.steps: list[steps.Step] = []
        self.refuse: dict[tuple[int, int], int] = {}  # (index, sub) of a download -> abort code: a hostile node
        self.lies: dict[tuple[int, int], bytes] = {}  # what an upload answers instead
        self.absent: set[tuple[int, int]] = set()  # uploads of objects that the node does not have
        self.silent: set[tuple[int, int]] = set()  # uploads that are not answered

    def carry(self, plan: Generator[steps.Step, Answer, T]) -> T:
        """To its end; raises what the plan raises."""
        step = next(plan)
        while True:
            self.steps.append(step)
            try:
                step = plan.send(self.answer(step))
            except StopIteration as end:
                result: T = end.value
                return result

    def answer(self, step: steps.Step) -> Answer:
        match step:
            case steps.Read(index, sub):
                if (index, sub) in self.silent:
                    return Silent.YES
                if (index, sub) in self.absent:
                    return Refused(sdo.Abort.NO_OBJECT)
                return self.lies.get((index, sub)) or self.upload(index, sub)
            case steps.Write(index, sub, data):
                if (index, sub) in self.refuse:
                    return Refused(self.refuse[index, sub])
                return self.download(index, sub, data)
            case steps.Nmt(command, awaits):
                self.say(nmt.command(command, self.node))
                return self.shown(awaits) if awaits is not None else b""
            case steps.Pause(pause):
                self.wait(pause)
                return b""
            case steps.Now():
                return (self.now // 1_000_000).to_bytes(8, "little")
            case steps.Sync(pause):
                self.say(Frame(cobid.SYNC))
                self.wait(pause)
                return b""

    def upload(self, index: int, sub: int) -> Answer:
        return self.asked(sdo.initiate(sdo.Request.INITIATE_UPLOAD, (index, sub)))

    def download(self, index: int, sub: int, data: bytes) -> Answer:
        answer = self.asked(sdo.expedited(sdo.Request.INITIATE_DOWNLOAD, (index, sub), data))
        return b"" if isinstance(answer, bytes) else answer

    def asked(self, request: bytes) -> Answer:
        self.say(Frame(cobid.sdo_request(self.node), request))
        for _ in range(PATIENCE_MS):
            for frame in self.heard:
                if frame.identifier == cobid.sdo_answer(self.node):
                    if frame.data[0] >> 5 == sdo.Answer.ABORT:
                        return Refused(sdo.abort_of(frame.data).code)
                    return sdo.expedited_data(frame.data)
            self.wait(1)
        return Silent.YES

    def shown(self, state: State) -> Answer:
        for _ in range(2000):
            if any(nmt.heartbeat_of(frame) == (self.node, state) for frame in self.heard):
                return b""
            self.wait(1)
        return Silent.YES

    def say(self, frame: Frame) -> None:
        self.heard = []
        self.slave.receive([frame._replace(stamp_ns=self.now)], self.now)
        self.heard += self.slave.take_output()

    def wait(self, pause_ms: int) -> None:
        self.now += ms(pause_ms)
        self.slave.wake(self.now)
        self.heard += self.slave.take_output()


class Cell402Bench(CellBench):
    """One command source commands; the drives are emulated CiA 402 nodes."""

    slave: Cia402Slave

    def __init__(self, p5_ms: int = 4, *, cell: Cell = DEMO_402) -> None:
        super().__init__(p5_ms, cell=cell)
        self.booted = self.start_up()

    def _drives(self) -> tuple[Cia402Slave, BusFamily]:
        bus = self.cell.bus[0]
        sheets = {axis.drive.node: read_eds(self.cell, axis, simulated=True) for axis in self.cell.axis if axis.drive.node}
        dictionaries = {node: sheet.dictionary for node, sheet in sheets.items() if sheet is not None}
        return Cia402Slave(bus_settings(self.cell, bus.name, self.p5_ms), dictionaries), make_family(self.cell, bus, self.p5_ms)

    def start_up(self, nodes: Sequence[int] = ()) -> list[Booted]:
        """Every node (or these), one after the other; the cycle may speak to them from now on."""
        found = []
        for _, plan in node_plans(self.cell, self.cell.bus[0], self.p5_ms, simulated=True):
            if not nodes or plan.node in nodes:
                dialogue = Dialogue(self.slave, plan.node, self.now)
                found.append(dialogue.carry(plans.boot(plan)))
                self.now = dialogue.now
                self.family.release(plan.node, found[-1].mode)
        return found
