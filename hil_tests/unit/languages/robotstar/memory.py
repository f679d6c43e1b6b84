"""Runs programs of a small memory in virtual time."""

from dataclasses import dataclass, field

from gateway.files.robotstar import words
from gateway.pure.languages.base.faults import Faults
from gateway.pure.languages.robotstar.checker import check
from gateway.pure.languages.robotstar.memory import Memory, Source
from gateway.pure.languages.robotstar.robot import MODES
from gateway.pure.languages.robotstar.script import NS, orders
from gateway.pure.languages.robotstar.virtual import VirtualCell

WORDS = words()


@dataclass
class Ran:
    """What happened."""

    cell: VirtualCell
    faults: list[str]
    end: dict[str, object] = field(default_factory=dict)

    @property
    def state(self) -> object:
        return self.end["state"]

    @property
    def step(self) -> object:
        return self.end["step"]

    def value(self, name: str) -> object:
        variables = self.end["variables"]
        assert isinstance(variables, dict)
        return variables[name]

    def texts(self) -> list[object]:
        return [event["text"] for event in self.cell.events if event["what"] == "message"]

    def message(self) -> dict[str, object]:
        return next(event for event in self.cell.events if event["what"] == "message")

    def targets(self) -> list[tuple[float, float, float]]:
        found = [event["value"] for event in self.cell.events if event["what"] == "target"]
        return [(value["X"], value["Y"], value["Z"]) for value in found if isinstance(value, dict)]

    def when(self, what: str) -> list[tuple[object, object]]:
        return [(event["at"], event["value"]) for event in self.cell.events if event["what"] == what]


def sources(files: dict[str, str]) -> list[Source]:
    """A body without a head gets head and END of the file's name."""
    made = []
    for path, text in files.items():
        name, _, kind = path.rpartition("/")[2].rpartition(".")
        lines = [line.strip() for line in text.strip().splitlines()]
        if not lines or lines[0].split()[0] not in ("MPR", "SPR", "MAC", "PAL", "MP", "SP"):
            lines = [f'{kind} "{name}"', *lines, "END"]
        made.append(Source(path, "\n".join(f"{number} {line}" for number, line in enumerate(lines, 1))))
    return made


def checked(files: dict[str, str]) -> tuple[Memory, Faults]:
    faults = Faults()
    memory = Memory.read(sources(files), WORDS, faults)
    check(memory, faults, VirtualCell(memory, MODES["auto"]).system.names())
    return memory, faults


def run(files: dict[str, str], program: str = "P", mode: str = "test2", until: float | None = None, at: tuple[str, ...] = ()) -> Ran:
    """START of a program at 0."""
    faults = Faults()
    memory = Memory.read(sources(files), WORDS, faults)
    cell = VirtualCell(memory, MODES[mode])
    check(memory, faults, cell.system.names())
    cell.run(orders(at), None if until is None else round(until * NS), program)
    return Ran(cell, [fault.text for fault in faults], cell.end(program))


def steps(text: str, definitions: str = "", mode: str = "test2", until: float | None = None, at: tuple[str, ...] = ()) -> Ran:
    """One main program with global definitions in another."""
    return run({"P.MPR": text, "VARS.MPR": definitions}, mode=mode, until=until, at=at)
