"""Every listing of the manual, imported as printed and run in virtual time, against a golden log: repairs, positions, bits, messages, end.

What a print leaves out (a head, a tool, definitions, the program that calls it) is in `around` of its row.
"""

import pathlib
from dataclasses import dataclass, field, replace

import pytest

from gateway.assembly.listings import robotstar_listing
from gateway.pure.languages.base.faults import Faults
from gateway.pure.languages.robotstar.checker import check
from gateway.pure.languages.robotstar.listing import import_listing, points_of
from gateway.pure.languages.robotstar.memory import Memory, Source
from gateway.pure.languages.robotstar.robot import MODES
from gateway.pure.languages.robotstar.script import NS, orders
from gateway.pure.languages.robotstar.virtual import VirtualCell
from hil_tests.lab.virtual.reis_bench import SHIPPED
from hil_tests.unit.languages.robotstar.memory import WORDS

FOLDER = next(parent for parent in pathlib.Path(__file__).resolve().parents if parent.name == "hil_tests") / "vectors" / "robotstar"
POINTS = points_of((FOLDER / "points.csv").read_text())
LEFT, RIGHT = 0, 3


@dataclass(frozen=True)
class Listing:
    """prints: files of the vectors; program: the one that starts; around: programs that are not printed, `@NAME` is the body of a printed
    one; script: orders."""

    prints: tuple[str, ...]
    program: str
    around: dict[str, str] = field(default_factory=dict)
    script: tuple[str, ...] = ()
    values: tuple[tuple[str, str], ...] = ()  # <..> of the print
    until: float = 600
    column: int | None = None  # of prints that have two programs beside one another


WORK = "TOOL T\nPOSITION #N, X:100, Y:20, Z:30, A:0, B:0, C:10"
SHIFTS = "".join(f"COPY {value}, RARR[{n}]\n" for n, value in enumerate((10, 20, 30, 0, 0, 45), 1))


def trafo(control: int, destination: str = "REFZ", values: str = "") -> dict[str, str]:
    """A main program that transforms WORK and runs what comes of it; the variables of the right-hand prints."""
    names = [name for name in POINTS if name[0] == "P" and len(name) <= 3]
    variables = "\n".join(f"VAR {name}, {POINTS[name]}" for name in names)
    call = f'TRAFO_6D "REFQ","{destination}","WORK","MADE",I_C\nCALL "MADE"\nSTOP'
    return {
        "MAIN.MPR": f"TOOL T\n{values}COPY {control}, I_C\n{call}",
        "WORK.SPR": WORK,
        "V.MPR": f"VAR I_C\n{variables}",
    }


CLEAN = "SCHR_BIT #AUSGANG,1,1,0\nWAIT 1\nSCHR_BIT #AUSGANG,0,1,0"
PALLET = (
    'TOOL T\nPALLET "PATTERN1",#INIT\nLABEL "CYCLE"\nPALLET "PATTERN1",#ON\nPOSITION #N, X:0, Y:0, Z:0, A:0, B:0, C:0\n'
    'PALLET "PATTERN1",#OFF\nTEST #VARIABLE,ITOTAL,#>,0,"CYCLE"\nSTOP'
)
SPLINE = "TOOL T\nPATH_SPEED 100\n@SPLINE\nSTOP"
COUNTS = (
    ("value:<number>", "value:2"),
    ("<T-variable>", "T"),
    ("<xxx>", "2"),
    ("<pallet pattern name>", '"PATTERN1"'),
    ("corner point 1", "corner point1"),
)
TEACH = tuple((f"POSITION {n}", f"POSITION {name}") for n, name in enumerate("ABCDE", 1))

LISTINGS = {
    "interpol_l322": Listing(("interpol_l322",), "BEWEGUNG", until=43),
    "shift_l402": Listing(("shift_l402",), "MAIN", {"MAIN.MPR": "TOOL T\n@SHIFT\nSTOP", "V.MPR": "VAR VEKTOR_1"}),
    "cleaning_l567": Listing(
        ("cleaning_l567",), "MAIN", {"MAIN.MPR": "@CLEANING\nWAIT 1", "REINIGEN.SPR": CLEAN}, ("2.5 E0.6=1",), until=6
    ),
    "distance_l932": Listing(("distance_l932",), "MAIN", {"MAIN.MPR": "TOOL T\n@DISTANCE\nSTOP", "V.MPR": "VAR V_BAHN\nVAR RWEG"}),
    "spline_l1854": Listing(("spline_l1854",), "MAIN", {"MAIN.MPR": SPLINE}, values=TEACH),
    "spline_l1863": Listing(("spline_l1863",), "MAIN", {"MAIN.MPR": SPLINE}, values=TEACH),
    "spline_l1874": Listing(("spline_l1874",), "MAIN", {"MAIN.MPR": SPLINE}, values=TEACH),
    "spline_l1885": Listing(("spline_l1885",), "MAIN", {"MAIN.MPR": SPLINE}, values=TEACH),
    "pal_l4263": Listing(("pal_l4263",), "MAIN", {"MAIN.MPR": PALLET}, values=COUNTS),
    "paltest_l4349": Listing(("paltest_l4349", "pattern_l4373"), "PALTEST"),
    "pattern5x8_l4489": Listing(("pattern5x8_l4489",), "MAIN", {"MAIN.MPR": PALLET}),
    "extended_l4551": Listing(
        ("extended_l4551",), "MAIN", {"MAIN.MPR": PALLET}, values=(*COUNTS, ("<control bits>", "3"), ("<distance>", "40.0"))
    ),
    "variables_l4613": Listing(
        ("variables_l4613",),
        "MAIN",
        {
            "MAIN.MPR": "TOOL T\n"
            + "".join(
                f"POSITION #N, X:{x}, Y:{y}, Z:{z}, A:0, B:0, C:0\nACT_POS {name}\n"
                for name, x, y, z in (("P_ZP", 0, 0, 0), ("P_EP1", 90, 0, 0), ("P_EP2", 0, 80, 0), ("P_EP3", 0, 0, 70))
            )
            + PALLET.partition("\n")[2]
        },
        values=COUNTS,
    ),
}


CONSTANT = (("CONST/VAR", "CONST"), ("VAR/CONST", "CONST"), ("RVAR", "RVAR, 2.0"), ("MP/SP", "SP"))
TRAFOS: dict[str, tuple[dict[str, str], tuple[tuple[str, str], ...]]] = {
    "trafo_l3550": (trafo(1), CONSTANT),
    "trafo_l3584": (trafo(1, "REFQ", SHIFTS), CONSTANT),
    "trafo_l3613": (trafo(5), CONSTANT),
    "trafo_l3652": (trafo(5, "REFQ"), CONSTANT),
    "trafo_l3678": (trafo(37), CONSTANT),
    "trafo_l3712": (trafo(37, "REFQ"), CONSTANT),
    "trafo_l3733": (trafo(69), CONSTANT),
    "trafo_l3764": (trafo(69, "REFQ"), CONSTANT),
    "trafo_l3782": (trafo(9), CONSTANT),
}
LISTINGS |= {
    f"{name}_{side}": Listing((name,), "MAIN", around, values=values, column=column)
    for name, (around, values) in TRAFOS.items()
    for side, column in (("positions", LEFT), ("variables", RIGHT))
}


def memory_of(row: Listing) -> tuple[dict[str, str], list[str]]:
    """Files of the memory, and what the import repaired."""
    files: dict[str, str] = {}
    bodies: dict[str, str] = {}
    notes: list[str] = []
    for name in row.prints:
        text = (FOLDER / f"{name}.txt").read_text(encoding="utf-8")
        if row.column is not None:
            text = "\n".join(" ".join(line.strip("| ").split("|")[row.column : row.column + 2]) for line in text.splitlines())
        for old, new in row.values:
            text = text.replace(old, new)
        found = import_listing(text, WORDS, POINTS, name.partition("_")[0].upper())
        notes += [f"{name} line {note.line}: {note.text}" for note in found.notes]
        for file, made in found.files.items():
            bodies[file.partition(".")[0]] = "\n".join(line.split(None, 1)[1] for line in made.splitlines()[1:-1])
            files[file] = made
    for file, text in row.around.items():
        for name in [name for name in bodies if f"@{name}" in text]:
            text = text.replace(f"@{name}", bodies[name])
            files.pop(f"{name}.MPR", None)
        name, _, kind = file.partition(".")
        files[file] = f'{kind} "{name}"\n{text}\nEND\n'
    return files, notes


def log(name: str) -> str:
    """What the listing does."""
    row = LISTINGS[name]
    files, notes = memory_of(row)
    faults = Faults()
    memory = Memory.read([Source(*each) for each in files.items()], WORDS, faults)
    cell = VirtualCell(memory, MODES["auto"])
    check(memory, faults, cell.system.names())
    cell.run(orders(row.script), round(row.until * NS), row.program)
    end = cell.end(row.program)
    lines = [*notes, *(f"{fault}" for fault in faults)]
    for event in cell.events:
        mode = f" {event['mode']}" if "mode" in event else ""
        value = event["value"]
        shown = " ".join(f"{key}={value[key]}" for key in value) if isinstance(value, dict) else value
        lines.append(f"{event['at']:.3f} {event['what']}{mode} {shown}")
    lines.append(f"{end['state']} {end['program']} step {end['step']}")
    variables = end["variables"]
    assert isinstance(variables, dict)
    lines += [f"{key} = {value}" for key, value in variables.items() if value is not None and not key.startswith("P")]
    return "\n".join(lines) + "\n"


@pytest.mark.parametrize("name", LISTINGS)
def test_a_listing_runs_as_its_golden_log_has_it(name: str) -> None:
    assert log(name) == (FOLDER / "golden" / f"{name}.log").read_text(encoding="utf-8")


def test_the_page_has_the_listing_of_a_cells_program_with_its_faults(tmp_path: pathlib.Path) -> None:
    (tmp_path / "memory" / "JOBS").mkdir(parents=True)
    (tmp_path / "memory" / "JOBS" / "P.MPR").write_text('MPR "P"\nCOPY 1\nEND\n')
    assert SHIPPED.controller is not None
    cell = replace(SHIPPED, file=str(tmp_path / "cell.toml"), controller=replace(SHIPPED.controller, memory="memory"))
    found = robotstar_listing(cell, "JOBS/P")
    assert found is not None and (found.file, found.lines) == ("JOBS/P.MPR", ('MPR "P"', "COPY 1", "END"))
    assert [(line, severity) for line, severity, _ in found.faults] == [(2, "error")]
    assert robotstar_listing(cell, "Q") is None
    (tmp_path / "memory" / "JOBS" / "P.MPR").write_text('MPR "P"\n\nC text\n  STOP\n/* remark */\nCOPY 1\nEND\n')
    found = robotstar_listing(cell, "JOBS/P")
    assert found is not None and found.lines == ('MPR "P"', "C text", "STOP", "COPY 1", "END"), "a line a step"
    assert ([line for line, _, _ in found.faults], found.statements) == ([4], (3, 5))
