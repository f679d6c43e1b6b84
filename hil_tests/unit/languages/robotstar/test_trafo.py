"""TRAFO_6D: modes, limits, control word, what is copied."""

import pytest

from hil_tests.unit.languages.robotstar.memory import Ran, checked, run

Point = tuple[float, float, float]


def position(point: Point, more: str = "", angles: Point = (0, 0, 0)) -> str:
    x, y, z = point
    a, b, c = angles
    return f"POSITION #N, X:{x}, Y:{y}, Z:{z}, A:{a}, B:{b}, C:{c}{more}"


def reference(*points: Point, more: str = "", front: str = "") -> str:
    return "\n".join(filter(None, [front, "TOOL T", *(position(point, more) for point in points)]))


def trafo(control: int, source: str, one: str, two: str | None = None, **files: str) -> Ran:
    """Transforms SRC into DST and calls it; one reference program where `two` is None."""
    names = ("REFQ", "REFQ" if two is None else "REFZ")
    step = f'TRAFO_6D Ref_source:"{names[0]}", Ref_destination:"{names[1]}", Source:"SRC", Destination:"DST", ISTEUER'
    body = f"COPY {control},ISTEUER\n{step}"
    text = f"{body}\nTOOL T\nTEST #VARIABLE,ISTEUER,#>=,65536,X\nCALL DST\nLABEL X"
    memory = {"P.MPR": text, "REFQ.MPR": one, "SRC.SPR": source, "V.MPR": "VAR ISTEUER\nVAR RARR[6]\nVAR RK\nVAR S_N(20)"}
    return run(memory | ({} if two is None else {"REFZ.MPR": two}) | {f"{name}.SPR": body for name, body in files.items()})


def error(ran: Ran) -> int:
    value = ran.value("ISTEUER")
    assert isinstance(value, int)
    return (value >> 16) & 0xFFFF


TRIANGLE: tuple[Point, Point, Point] = ((0, 0, 0), (100, 0, 0), (0, 100, 0))
NUMERIC = "VAR RARR[6]"


def numbers(*values: float) -> str:
    return "\n".join(f"COPY {value:.6f},RARR[{n}]" for n, value in enumerate(values, 1))


def moved(ran: Ran) -> list[Point]:
    assert error(ran) == 0, error(ran)
    return [(round(x, 6), round(y, 6), round(z, 6)) for x, y, z in ran.targets()]


@pytest.mark.requirement("RSV-TRF-01", by="gateway.pure.languages.robotstar.trafo_geometry:shift")
@pytest.mark.requirement("RSV-TRF-10", by="gateway.pure.languages.robotstar.trafo_geometry:Map.pose")
def test_a_taught_shift() -> None:
    by_100 = tuple((x + 100, y, z) for x, y, z in TRIANGLE)
    assert moved(trafo(0, position((1, 2, 3)), reference(*TRIANGLE), reference(*by_100))) == [(101, 2, 3)]
    turned = reference((0, 0, 0), (0, 100, 0), (-100, 0, 0))
    ran = trafo(0, position((10, 0, 0)), reference(*TRIANGLE), turned)
    assert moved(ran) == [(0, 10, 0)] and ran.when("target")[0][1] == {"X": 0, "Y": 10, "Z": 0, "A": 0, "B": 0, "C": 90}
    kept = trafo(2, position((10, 0, 0), angles=(5, 6, 7)), reference(*TRIANGLE), turned)
    assert kept.when("target")[0][1] == {"X": 0, "Y": 10, "Z": 0, "A": 5, "B": 6, "C": 7}


@pytest.mark.requirement("RSV-TRF-02", by="gateway.pure.languages.robotstar.trafo_geometry:offset")
@pytest.mark.requirement("RSV-TRF-03", by="gateway.pure.languages.robotstar.trafo_geometry:offset")
@pytest.mark.parametrize(
    "control, values, at, to",
    [
        (0, (10, 20, 30, 0, 0, 0), (1, 2, 3), (11, 22, 33)),
        (0, (0, 0, 0, 0, 0, 90), (10, 0, 0), (0, 10, 0)),
        (1 << 5, (0, 90, 5, 0, 0, 0), (10, 0, 0), (0, 10, 5)),
        (1 << 5, (5, 0, 0, 0, 0, 0), (0, 10, 0), (0, 15, 0)),
    ],
)
def test_a_numeric_shift(control: int, values: tuple[float, ...], at: Point, to: Point) -> None:
    files = {"REFQ.MPR": f"{NUMERIC}\nTOOL T\n{position((0, 0, 0))}", "SRC.SPR": position(at), "V.MPR": "VAR ISTEUER"}
    text = f"{numbers(*values)}\nCOPY {control},ISTEUER\nTRAFO_6D REFQ,REFQ,SRC,DST,ISTEUER\nTOOL T\nCALL DST"
    assert moved(run(files | {"P.MPR": text})) == [to]


@pytest.mark.requirement("RSV-TRF-04", by="gateway.pure.languages.robotstar.trafo_geometry:plane")
@pytest.mark.requirement("RSV-TRF-05", by="gateway.pure.languages.robotstar.trafo_geometry:line")
@pytest.mark.parametrize(
    "parameter, points, k, at, to",
    [
        (0, TRIANGLE, 2, (1, 2, 3), (1, 2, 6)),
        (0, TRIANGLE, -1, (1, 2, 3), (1, 2, -3)),
        (1, ((0, 0, 0), (0, 0, 100)), 2, (1, 2, 3), (2, 4, 3)),
        (1, ((0, 0, 0), (0, 0, 100)), -1, (1, 2, 3), (-1, -2, 3)),
        (2, ((0, 0, 0),), 0.5, (2, 4, 6), (1, 2, 3)),
    ],
)
def test_scaling(parameter: int, points: tuple[Point, ...], k: float, at: Point, to: Point) -> None:
    front = f"LOC_CONST RK,{k:.1f}"
    assert moved(trafo(4 | parameter << 5, position(at), reference(*points, front=front))) == [to]


@pytest.mark.requirement("RSV-TRF-06", by="gateway.pure.languages.robotstar.trafo:_factor")
@pytest.mark.parametrize(
    "parameter, points, source, destination, to",
    [
        (0, TRIANGLE, (0, 0, 100), (0, 0, 50), (0, 0, 5)),
        (0, TRIANGLE, (0, 0, 100), (0, 0, -50), (0, 0, -5)),
        (1, ((0, 0, 0), (100, 0, 0)), (0, 0, 100), (0, 0, -50), (0, 0, 5)),
        (2, ((0, 0, 0),), (0, 0, 100), (0, -50, 0), (0, 0, 5)),
    ],
)
def test_the_factor_from_two_positions(parameter: int, points: tuple[Point, ...], source: Point, destination: Point, to: Point) -> None:
    ran = trafo(4 | parameter << 5, position((0, 0, 10)), reference(source, *points), reference(destination))
    assert moved(ran) == [to]


@pytest.mark.requirement("RSV-TRF-07", by="gateway.pure.languages.robotstar.trafo_geometry:mirror_shift")
def test_a_mirrored_shift() -> None:
    there: tuple[Point, ...] = ((500, 0, 0), (500, 100, 0), (600, 0, 0))
    source = "\n".join(position(point) for point in (*TRIANGLE, (0, 0, 10)))
    found = moved(trafo(2 << 2, source, reference(*TRIANGLE), reference(*there)))
    assert found[:3] == list(there)
    assert found[3] == (500, 0, 10)  # z of the destination frame points down: the height is reversed


@pytest.mark.requirement("RSV-TRF-08", by="gateway.pure.languages.robotstar.trafo_geometry:check_triangle")
@pytest.mark.parametrize("third, number", [((0, 40, 0), 10), ((100, 36, 0), 11), ((0, 50, 0), 0)])
def test_distances_and_angles(third: Point, number: int) -> None:
    wrong = reference((0, 0, 0), (200, 0, 0), third)
    assert error(trafo(0, position((0, 0, 0)), wrong, reference(*TRIANGLE))) == number
    assert error(trafo(0, position((0, 0, 0)), reference(*TRIANGLE), wrong)) == (number and number + 100)


@pytest.mark.requirement("RSV-TRF-09", by="gateway.pure.languages.robotstar.trafo:_write")
def test_an_existing_destination() -> None:
    shifted = reference(*((x + 100, y, z) for x, y, z in TRIANGLE))
    old = {"DST": position((7, 7, 7))}
    assert error(trafo(0, position((1, 2, 3)), reference(*TRIANGLE), shifted, **old)) == 301
    assert moved(trafo(1, position((1, 2, 3)), reference(*TRIANGLE), shifted, **old)) == [(101, 2, 3)]


@pytest.mark.requirement("RSV-TRF-11", by="gateway.pure.languages.robotstar.trafo:trafo")
@pytest.mark.requirement("RSV-TRF-12", by="gateway.pure.languages.robotstar.trafo:_check_control")
@pytest.mark.parametrize(
    "control, source, number",
    [(7 << 2, "C", 402), (7 << 5, "C", 403), (1 << 10, "C", 401), (0, "VAR_POS P1", 206), (0, "WAIT 0.0", 0)],
)
def test_the_control_word_and_the_source(control: int, source: str, number: int) -> None:
    text = f"LOC_VAR P1\n{source}"
    assert error(trafo(control, text, reference(*TRIANGLE), reference(*TRIANGLE))) == number
    ran = trafo(control | 1 << 8, text, reference(*TRIANGLE), reference(*TRIANGLE))
    assert ran.texts() == ([f"TRAFO_6D-error: {number}"] if number else [])


def test_reference_programs_that_do_not_fit() -> None:
    good = reference(*TRIANGLE)
    rows = ((reference(*TRIANGLE[:2]), 103), (good + "\n\\WAIT 1", 102), (good + "\nWAIT 1", 107), (good.removeprefix("TOOL T\n"), 106))
    for two, number in rows:
        assert error(trafo(0, position((0, 0, 0)), good, two)) == number
        assert error(trafo(0, position((0, 0, 0)), two, good)) == number - 100
    assert trafo(2 << 2, "C", good).value("ISTEUER") == 2 << 2 | 150 << 16


def three(*more: str) -> str:
    return "\n".join(["TOOL T", *(position(point, each) for point, each in zip(TRIANGLE, more, strict=True))])


ON_A_LINE = reference((0, 0, 0), (100, 0, 0), (200, 0, 0))
UNKNOWN, UNSET = "TOOL T\nVAR_POS PX\nVAR_POS PX\nVAR_POS PX", "LOC_VAR PX\nTOOL T\nVAR_POS PX\nVAR_POS PX\nVAR_POS PX"
AXES_ALONE = "TOOL T" + "\nPOSITION #N, A1:1, A2:2, A3:3, A4:4, A5:5, A6:6" * 3


@pytest.mark.parametrize(
    "wrong, number",
    [
        (ON_A_LINE, 4),
        (reference((0, 0, 0), (100, 0, 0), (-100, 0, 0)), 4),
        (AXES_ALONE, 4),
        (reference((0, 0, 0), (100, 0, 0), (-100, 20, 0)), 11),
        (three(", A7:1", ", A7:2", ", A7:1"), 5),
        (UNKNOWN, 8),
        (UNSET, 9),
        (reference((0, 0, 0), (0, 0, 0), (0, 100, 0)), 10),
        (three(", Frame:1", "", ""), 13),
        (three(", Frame:1", ", Frame:2", ", Frame:1"), 14),
    ],
)
def test_what_is_wrong_with_the_positions_of_a_reference_program(wrong: str, number: int) -> None:
    """Each number of the source program has one of the destination, 100 higher (L3834-3874)."""
    good = reference(*TRIANGLE)
    assert error(trafo(0, position((0, 0, 0)), wrong, good)) == number
    assert error(trafo(0, position((0, 0, 0)), good, wrong)) == number + 100


@pytest.mark.parametrize(
    "one, number",
    [
        (reference((0, 0, 0), front="LOC_CONST RK,1.0"), 50),
        (reference((0, 0, 0), front="LOC_VAR RA[5]"), 51),
        (reference((0, 0, 0), front="LOC_VAR RA[6]", more=", A7:1"), 51),
        (reference((0, 0, 0), front="LOC_VAR RA[6]"), 9),
        (reference((0, 0, 0)), 8),
    ],
)
def test_the_array_of_a_numeric_shift(one: str, number: int) -> None:
    assert error(trafo(0, position((0, 0, 0)), one)) == number


@pytest.mark.parametrize("missing, number", [("REFQ.MPR", 1), ("REFZ.MPR", 101), ("SRC.SPR", 201)])
def test_programs_that_are_missing(missing: str, number: int) -> None:
    files = {"REFQ.MPR": reference(*TRIANGLE), "REFZ.MPR": reference(*TRIANGLE), "SRC.SPR": position((0, 0, 0)), "V.MPR": "VAR ISTEUER"}
    files |= {"P.MPR": 'COPY 0,ISTEUER\nTRAFO_6D REFQ,REFZ,"SRC",DST,ISTEUER'}
    assert error(run({name: text for name, text in files.items() if name != missing})) == number


def test_references_that_do_not_fit_each_other() -> None:
    good, seventh = reference(*TRIANGLE), reference(*TRIANGLE, more=", A7:1")
    assert error(trafo(0, "C", seventh, good)) == 112
    assert error(trafo(1 << 5, "C", good, good)) == 151
    far = (0.0, 0.0, 100.0)
    assert error(trafo(4, "C", reference((0, 0, 49), *TRIANGLE), reference(far))) == 10
    assert error(trafo(4, "C", reference(far, *TRIANGLE), reference((0, 0, -49)))) == 110
    assert error(trafo(1 << 9, position((0, 0, 0)), good, good)) == 0, "bit 9 has no error to leave out"


@pytest.mark.parametrize("here, there", [(", A7:1", ""), ("", ", A7:1")])
def test_a_source_with_other_additional_axes_than_the_references(here: str, there: str) -> None:
    good = reference(*TRIANGLE, more=here)
    assert error(trafo(0, position((1, 2, 3), there), good, good)) == 202


def test_axes_of_another_station_are_paired_in_their_order() -> None:
    """7, 8, 9 at station 1 and 7, 10, 11 at station 2: 8 goes with 10 and 9 with 11 (L3464-3468)."""
    one = reference(*TRIANGLE, more=", Frame:1, A7:1, A8:2, A9:3")
    two = reference(*TRIANGLE, more=", Frame:2, A7:2, A10:10, A11:20")
    ran = trafo(0, position((1, 2, 3), ", Frame:1, A7:5, A8:6, A9:7"), one, two)
    value = ran.when("target")[0][1]
    assert isinstance(value, dict)
    assert {name: value[name] for name in value if name not in "XYZABC"} == {"Frame": 2, "A7": 6, "A10": 14, "A11": 24}


@pytest.mark.parametrize("after, place", [((), ("P", 3)), (("1 ACK",), ("SRC", 4)), (("1 ACK", "2 POWER"), ("SRC", 1))])
def test_the_display_goes_to_the_step_of_the_source_once_the_error_is_acknowledged(after: tuple[str, ...], place: tuple[str, int]) -> None:
    """The errors marked (*) in the table (L3828): here 206."""
    good = reference(*TRIANGLE)
    files = {"REFQ.MPR": good, "REFZ.MPR": good, "SRC.SPR": "LOC_VAR P1\nWAIT 0.0\nVAR_POS P1", "V.MPR": "VAR ISTEUER"}
    ran = run(files | {"P.MPR": "COPY 256,ISTEUER\nTRAFO_6D REFQ,REFZ,SRC,DST,ISTEUER"}, at=after)
    assert ran.texts() == ["TRAFO_6D-error: 206"]
    assert (ran.end["program"], ran.end["step"]) == place


@pytest.mark.requirement("RSV-TRF-13", by="gateway.pure.languages.robotstar.trafo:_copied")
def test_other_steps_are_copied() -> None:
    source = f"VAR I7\nWAIT 1.0\n{position((1, 2, 3))}\nWRITE_BIT #AUSGANG,1,0,0"
    ran = trafo(0, source, reference(*TRIANGLE), reference(*TRIANGLE))
    steps = ran.cell.memory.programs["DST"][0].steps
    assert [(step.word, step.valid) for step in steps[1:4]] == [("VAR", False), ("WAIT", True), ("POSITION", True)]
    assert ran.cell.memory.programs["DST"][0].kind == "SPR" and ran.cell.memory.owners["I7"].name == "SRC"
    assert isinstance(at := ran.when("A0")[0][0], float) and at > 1.0


@pytest.mark.requirement("RSV-TRF-14", by="gateway.pure.languages.robotstar.trafo:_axes")
@pytest.mark.parametrize("here, there, to", [(1000, 2000, 1800), (1000, 1000, 1200)])
def test_a_mirrored_additional_axis(here: int, there: int, to: int) -> None:
    ran = trafo(
        2 << 2, position((0, 0, 0), ", A7:1200"), reference(*TRIANGLE, more=f", A7:{here}"), reference(*TRIANGLE, more=f", A7:{there}")
    )
    value = ran.when("target")[0][1]
    assert isinstance(value, dict) and value["A7"] == to


@pytest.mark.requirement("RSV-TRF-15", by="gateway.pure.languages.robotstar.trafo:Transformation.step")
def test_frame_numbers() -> None:
    def frames(source: int, one: int, two: int) -> tuple[int, object]:
        ran = trafo(0, position((0, 0, 0), f", Frame:{source}"), *(reference(*TRIANGLE, more=f", Frame:{n}") for n in (one, two)))
        found = ran.when("target")
        return error(ran), found[0][1].get("Frame", 0) if found and isinstance(found[0][1], dict) else None

    assert frames(5, 0, 0) == (0, 5)
    assert frames(2, 2, 3) == (0, 3)
    assert frames(0, 2, 3) == (0, 0)
    assert frames(4, 2, 3) == (205, None)
    assert frames(0, 0, 3) == (113, None)


def test_a_program_in_work_is_not_overwritten() -> None:
    files = {"P.MPR": "COPY 1,ISTEUER\nTRAFO_6D REFQ,REFZ,SRC,P,ISTEUER", "SRC.SPR": position((0, 0, 0)), "V.MPR": "VAR ISTEUER"}
    ran = run(files | {"REFQ.MPR": reference(*TRIANGLE), "REFZ.MPR": reference(*TRIANGLE)})
    assert ran.texts() == ["program in the stack"] and ran.step == 3


@pytest.mark.parametrize(("call", "said"), [("CALL DST", []), ('CALL "S:/DST"', []), ("CALL DTS", ["step 3: program DTS not found"])])
def test_a_destination_that_is_still_to_be_made_may_be_called(call: str, said: list[str]) -> None:
    texts = {"P.MPR": f"TRAFO_6D REFQ,REFZ,SRC,DST,ISTEUER\n{call}", "SRC.SPR": "WAIT 1", "V.MPR": "VAR ISTEUER"}
    _, faults = checked(texts | {"REFQ.MPR": reference(*TRIANGLE), "REFZ.MPR": reference(*TRIANGLE)})
    assert [fault.text for fault in faults] == said
