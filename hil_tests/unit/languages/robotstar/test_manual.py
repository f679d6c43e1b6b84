"""The manual's own listings, imported as printed and run in virtual time."""

import pathlib

import pytest

from gateway.pure.languages.base.faults import Faults
from gateway.pure.languages.robotstar.checker import check
from gateway.pure.languages.robotstar.listing import import_listing, points_of
from gateway.pure.languages.robotstar.memory import Memory, Source
from gateway.pure.languages.robotstar.robot import MODES
from gateway.pure.languages.robotstar.script import NS, orders
from gateway.pure.languages.robotstar.virtual import VirtualCell
from hil_tests.unit.languages.robotstar.memory import WORDS, Ran

FOLDER = next(parent for parent in pathlib.Path(__file__).resolve().parents if parent.name == "hil_tests") / "vectors" / "robotstar"
POINTS = points_of((FOLDER / "points.csv").read_text())


def run(program: str, *names: str, until: float = 600) -> Ran:
    files: dict[str, str] = {}
    for name in names:
        files |= import_listing((FOLDER / f"{name}.txt").read_text(encoding="utf-8"), WORDS, POINTS, program).files
    faults = Faults()
    memory = Memory.read([Source(name, text) for name, text in files.items()], WORDS, faults)
    cell = VirtualCell(memory, MODES["test2"])
    check(memory, faults, cell.system.names())
    cell.run([], round(until * NS), program)
    return Ran(cell, [fault.text for fault in faults], cell.end(program))


def test_circles_l322() -> None:
    ran = run("BEWEGUNG", "interpol_l322")
    modes = [(event["mode"], target[0]) for event, target in zip(ran.cell.events, ran.targets(), strict=True)]
    circle = [("ZIRK_BAHN_ORI", x) for x in (350, 400, 450, 500)]
    assert modes == [("PTP", 100), ("PTP", 200), ("LINEAR", 300), *circle, ("PTP", 0)] and not ran.faults


def test_analog_input_l592() -> None:
    """Its POSITION has no name: with one and a tool it runs."""
    text = (FOLDER / "analog_l592.txt").read_text(encoding="utf-8")
    found = import_listing(text, WORDS, POINTS)
    assert "MARKÈ is read as MARKE" in [note.text for note in found.notes]
    body = found.files["ANALOG_TEST.MPR"].replace("POSITION", "TOOL T\nPOSITION #N, X:1, Y:0, Z:0, A:0, B:0, C:0")
    coat = 'SPR "BESCHICHTE"\nSCHR_BIT #AUSGANG,1,1,0\nEND'
    memory = Memory.read([Source("ANALOG_TEST.MPR", body), Source("BESCHICHTE.SPR", coat)], WORDS, Faults())
    cell = VirtualCell(memory, MODES["test2"])
    cell.run(orders(["3 EA2=4.9", "5 EA2=5.5"]), 9 * NS, "ANALOG_TEST")
    ran = Ran(cell, [], cell.end("ANALOG_TEST"))
    assert [value for _, value in ran.when("A0")] == [16] and ran.when("A1") == [(5.0, 1)] and ran.texts() == []


def test_three_dimensional_pallet_l4349() -> None:
    ran = run("PALTEST", "paltest_l4349", "pattern_l4373")
    parts = [target for target in ran.targets() if target[2] in (0, 50)]
    assert parts == [(100.0 * x, 150.0 * y, 50.0 * z) for z in (0, 1) for y in (0, 1, 2) for x in (0, 1, 2)]
    assert (len(ran.targets()), ran.state, ran.step, ran.faults) == (55, "stopped", 19, [])
    assert [ran.value(name) for name in ("ITOTAL", "ACTVALUE1", "ACTVALUE2", "ACTVALUE3")] == [0, 0, 0, 2]


@pytest.mark.parametrize("until", [200.0])
def test_the_listing_that_leaves_out_a_row_does_not_end_l4461(until: float) -> None:
    ran = run("PALTEST", "palskip_l4461", "pattern_l4373", until=until)
    assert ran.state == "running" and not ran.texts()
