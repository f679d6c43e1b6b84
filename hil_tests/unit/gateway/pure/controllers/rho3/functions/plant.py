"""A PLC and a panel before the functions, in virtual time: 4 ms a cycle, P9 = 40 ms."""

from collections.abc import Callable

from gateway.pure.controllers.rho3.functions.addresses import number_at, put_number
from gateway.pure.controllers.rho3.functions.dat_parsers import parse_exprog, parse_msd, parse_phgcode, parse_texts
from gateway.pure.controllers.rho3.functions.plc import Functions, Settings
from gateway.pure.controllers.rho3.functions.processes import Body, Kind, Process, ProcessTable, Program, Turn
from gateway.pure.image.error_list import ErrorList
from gateway.pure.image.records.cell import RC_BYTES, InputImage, Quality, get_bit, set_bit
from protocols.base.machine import Ns, ms

CYCLE, P9 = ms(4), ms(40)
MSD = "01 = 'first status'\n08 = 'this is a long text'\n99 = 'last text'\n"
TEXT = "01 = PHG,'This text is forty  characters, not longer'\n02 = 'short'\nFF = '" + "0123456789" * 8 + "'\n"
EXPROG = "01 = MAIN\n02 = PROGXY\n07 = OTHER\nFE = NOWHERE\n"
PHGCODE = "0 = 0\n4 = 7.1\n5 = 7.12.1\n6 = 7.12.2\nC = 7. 3\n"


def idle(_: Ns) -> Turn:
    return Turn.WAIT


def program(kind: Kind = Kind.NORMAL, priority: int = 140, kinematics: int = 1, body: Body = idle) -> Program:
    return Program(lambda: body, kind, priority, kinematics)


def settings(msd: str | None = MSD, texts: str | None = TEXT, language: str = "en", phg_option: bool = True) -> Settings:
    made = Settings(strobe_time=P9, language=language, phg_option=phg_option, programs=parse_exprog(EXPROG), modes=parse_phgcode(PHGCODE))
    made.msd = None if msd is None else parse_msd(msd)
    made.texts = None if texts is None else parse_texts(texts)
    return made


class Plant:
    """Everything between the PLC's outputs and what it reads."""

    def __init__(self, of: Settings | None = None, started: bool = True) -> None:
        self.now = ms(1000)
        self.inputs = InputImage(quality=bytearray([Quality.GOOD] * RC_BYTES))
        self.outputs = bytearray(RC_BYTES)
        self.errors = ErrorList()
        programs = {"MAIN": program(), "PROGXY": program(kinematics=2), "OTHER": program(Kind.PERMANENT)}
        self.processes = ProcessTable(programs)
        self.functions = Functions(of or settings(), self.errors, self.processes)
        self.display = self.functions.display
        self.refused: list[str] = []
        self.panel_ready = True
        self.cycle(int(started))

    def cycle(self, count: int = 1) -> "Plant":
        for _ in range(count):
            self.now += CYCLE
            said = self.functions.step(self.inputs, self.outputs, self.now, panel_ready=self.panel_ready)
            assert isinstance(said, list)
            self.refused += [text.key for text in said]
        return self

    def wait(self, time: Ns) -> "Plant":
        return self.cycle(time // CYCLE)

    def put(self, bit: int, value: bool = True) -> "Plant":
        set_bit(self.inputs.values, bit, value)
        return self

    def number(self, first: int, width: int, value: int) -> "Plant":
        put_number(self.inputs.values, first, width, value)
        assert number_at(self.inputs.values, first, width) == value
        return self

    def out(self, bit: int) -> bool:
        return get_bit(self.outputs, bit)

    def outs(self, *bits: int) -> list[int]:
        return [bit for bit in bits if self.out(bit)]

    def screen(self) -> list[str]:
        return [line.rstrip() for line in self.display.screen()]

    def start(self, name: str, parent: int = 0, body: Body | None = None) -> Process:
        process = self.processes.start(name, parent, body)
        assert isinstance(process, Process)
        return process

    def names(self) -> list[str]:
        return [process.name for process in self.processes.processes]

    def pulses(self, bit: int, count: int, read: Callable[[], int] = lambda: 1) -> list[tuple[int, int, int]]:
        """Each level of an output during `count` cycles as (level, cycles, what `read` says at its beginning)."""
        found: list[tuple[int, int, int]] = []
        for _ in range(count):
            self.cycle()
            level = int(self.out(bit))
            if found and found[-1][0] == level and (not level or found[-1][2] == read()):
                found[-1] = (level, found[-1][1] + 1, found[-1][2])
            else:
                found.append((level, 1, read()))
        return found
