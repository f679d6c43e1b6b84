"""COPY: conversions, structures, groups, the fourteen messages."""

import pytest

from gateway.pure.languages.robotstar.values import Structure
from hil_tests.unit.languages.robotstar.memory import run, steps

ALL = (
    "\n".join(
        f"VAR {name}" for name in ("I1", "I2", "R1", "RV[2]", "V1", "V2", "P1", "P2", "T1", "T2", "I_A[10]", "I_V[5]", "V_A[2]", "S1(5)")
    )
    + "\nCONST IK,5"
)


@pytest.mark.requirement("RSV-CPY-01", by="gateway.pure.languages.robotstar.values:converted")
@pytest.mark.parametrize(
    "text, name, value",
    [
        ("COPY 8,RV[1]", "RV[1]", 8.0),
        ("COPY 3.0,R1\nCOPY R1,I1", "I1", 3),
        ("COPY 2.5,I1", "I1", 3),
        ("COPY -2.5,I1", "I1", -3),
        ("COPY 2,I1\nCOPY 4.5,RV[I1]\nCOPY RV[2],R1", "R1", 4.5),
        ('COPY "ABC",S1', "S1", "ABC"),
    ],
)
def test_conversion(text: str, name: str, value: object) -> None:
    ran = steps(text, ALL)
    assert ran.value(name) == value and type(ran.value(name)) is type(value) and not ran.texts()


@pytest.mark.requirement("RSV-CPY-03", by="gateway.pure.languages.robotstar.values:Structure.copy_from")
def test_whole_structures() -> None:
    ran = steps("COPY 1,T1.X\nCOPY 2,T1.Y\nCOPY 3,T1.Z\nCOPY 90,T1.RZ\nCOPY T1,T2\nCOPY_OFFSETS 1,T2,1,RV,1", ALL)
    assert [ran.value(f"T2.{name}") for name in ("X", "Y", "Z", "RZ")] == [1, 2, 3, 90]
    one, other = (ran.cell.memory.globals[name] for name in ("T1", "T2"))
    assert isinstance(one, Structure) and isinstance(other, Structure)
    assert one.raw == other.raw and len(one.raw) == 16 and one.raw[3] == 1


@pytest.mark.requirement("RSV-CPY-04", by="gateway.pure.languages.robotstar.access:element")
def test_elements() -> None:
    text = "COPY 12.5,V1.Y\nCOPY V1.y,R1\nCOPY 7,P1.Frame\nCOPY P1.FRAME,I1\nCOPY 90,T1.RZ\nCOPY T1.rz,RV[1]\nCOPY 4,V2.A24"
    ran = steps(text, ALL)
    assert [ran.value(name) for name in ("R1", "I1", "RV[1]", "V2.A24")] == [12.5, 7, 90.0, 4.0]
    for text in ("COPY 1,V1.Q", "COPY 1,V1.A25", "COPY 1,P1.TIME"):
        assert steps(text, ALL).texts() == ["Wrong operand types!"]


@pytest.mark.requirement("RSV-CPY-05", by="gateway.pure.languages.robotstar.access:check_groups")
@pytest.mark.parametrize(
    "text, wrong",
    [
        ("COPY 1,P1.X\nCOPY P1.x,V1.z", False),
        ("COPY 1,V1.A7\nCOPY V1.A7,P1.A9", False),
        ("COPY 1,P1.Frame\nCOPY P1.Frame,V1.Frame", False),
        ("COPY 1,V1.Frame\nCOPY V1.Frame,P1.A9", True),
        ("COPY 1,V1.Z\nCOPY V1.z,P1.rx", True),
        ("COPY 1,V1.Z\nCOPY V1.z,T1.x", True),
        ("COPY 1,V1.Z\nCOPY V1.z,V2.a3", False),
    ],
)
def test_groups(text: str, wrong: bool) -> None:
    assert steps(text, ALL).texts() == (["Wrong operand types!"] if wrong else [])


@pytest.mark.requirement("RSV-CPY-02", by="gateway.pure.languages.robotstar.access:copy")
@pytest.mark.requirement("RSV-CPY-06", by="gateway.pure.languages.robotstar.access:variable")
@pytest.mark.requirement("RSV-CPY-08", by="gateway.pure.languages.robotstar.access:_index")
@pytest.mark.parametrize(
    "text, said",
    [
        ("COPY P1,T1", "Wrong operand types!"),
        ("COPY 2.5,V1", "Wrong operand types!"),
        ("COPY V1,I1", "Wrong operand types!"),
        ('COPY "A",I1', "Wrong operand types!"),
        ("COPY 5,I_UNDEF", "Definition not found!"),
        ("COPY I_UNDEF,I1", "Definition not found!"),
        ("COPY 5,I_A", "Definition is an array!"),
        ("COPY 5,I1[3]", "Definition is no array!"),
        ("COPY 5,I_A[0]", "Index too big or too small!"),
        ("COPY 5,I_A[11]", "Index too big or too small!"),
        ("COPY 5,I_A[I_NONE]", "Index variable not found!"),
        ("COPY 5,I_A[I1]", "Index variable not initialized!"),
        ("COPY 5,V_A[1].X", "Wrong operand types!"),
        ('COPY "ABCDEF",S1', "the text has 6 characters, the variable holds 5"),
    ],
)
def test_messages_at_the_step(text: str, said: str) -> None:
    ran = steps(f"COPY 1,I2\n{text}", ALL)
    assert (ran.texts(), ran.state, ran.message()["step"], ran.value("I2")) == ([said], "error", 3, 1)


@pytest.mark.requirement("RSV-CPY-07", by="gateway.pure.languages.robotstar.operands:_index")
@pytest.mark.parametrize(
    "text, said",
    [
        ("COPY 5,I_A[3", "Syntax error in the index!"),
        ("COPY 5,I_A3]", "Syntax error in the index!"),
        ("COPY 5,I_A[[3]", "Syntax error in the index!"),
        ("COPY 5,I_A[3]]", "Syntax error in the index!"),
        ("COPY 5,I_A[I_V[5]]", "Nesting not allowed!"),
    ],
)
def test_the_index_as_written(text: str, said: str) -> None:
    ran = steps(text, ALL)
    assert ran.faults == [f"step 2: {said}"] and ran.texts() == [said] and ran.message()["step"] == 2


@pytest.mark.requirement("RSV-CPY-09", by="gateway.pure.languages.robotstar.values:SystemCell.write")
@pytest.mark.parametrize(
    "text, said",
    [
        ("COPY 5,IK", "The operand is no variable!"),
        ("COPY 5,6", "destination must be the name of a variable"),
        ("COPY 5,_RACC_MAX", "Writing not allowed!"),
        ("COPY 5,_IBIN_IN[1]", "Writing not allowed!"),
        ("COPY V1,_VNULL", "Writing not allowed!"),
        ("COPY _RMOUSE_T[1],R1", "Reading not allowed!"),
    ],
)
def test_what_is_not_for_reading_or_writing(text: str, said: str) -> None:
    assert said in str(steps(f"COPY 1,V1.X\n{text}", ALL).texts()[0])


@pytest.mark.requirement("RSV-CPY-10", by="gateway.pure.languages.robotstar.values:Array.at")
def test_validity_of_each_element() -> None:
    ran = steps("COPY 4,I_A[3]\nCOPY I_A[3],I1\nCOPY I_A[4],I1", ALL)
    assert (ran.texts(), ran.value("I1"), ran.step) == (["Variable not initialized!"], 4, 4)
    assert steps("COPY 1,V1.X\nCOPY V1.Y,R1", ALL).texts() == ["Variable not initialized!"]
    for index, said in ((0, ["Index too big or too small!"]), (1, []), (10, []), (11, ["Index too big or too small!"])):
        ran = steps(f"COPY 4,I_A[{index}]\nCOPY I_A[{index}],I1", ALL)
        assert (ran.texts(), ran.value("I1")) == (said, None if said else 4)


@pytest.mark.parametrize(
    "text, said",
    [
        ('COPY "ABCDEF",S1', "the text has 6 characters, the variable holds 5"),
        ('COPY "ABCDEF",S_TWO[2]', "the text has 6 characters, the variable holds 5"),
        ("COPY 101,_ISPL_TENS", "_ISPL_TENS 101 is outside 0 .. 100"),
        ("COPY -1,_IDEF_ACCTIM", "_IACC_TIME -1 is outside 0 .. 50"),
        ("COPY 5,_IBIN_IN[1]", "Writing not allowed!"),
        ('ADD "A",I1', "Wrong operand types!"),
        ("MUL 2,V1", "Wrong operand types!"),
        ("AND 1.5,I1", "Wrong operand types!"),
        ("COPY 1.0,R1\nOR R1,I1", "Wrong operand types!"),
    ],
)
def test_a_value_that_fits_no_variable_is_found_before_the_start_and_at_the_step(text: str, said: str) -> None:
    ran = steps(f"COPY 1,I1\nCOPY 1,V1.X\n{text}", f"{ALL}\nVAR S_TWO[2](5)")
    assert [fault.rpartition(": ")[2] for fault in ran.faults] == ran.texts() == [said]


def test_a_text_that_some_variable_of_the_name_takes_is_no_fault_before_the_start() -> None:
    files = {"P.MPR": "LOC_VAR SX(2)\nCALL Q", "Q.SPR": 'COPY "ABC",SX', "R.MPR": "LOC_VAR SX(9)\nCALL Q"}
    assert not run(files, "R").faults
    assert run(files).texts() == ["the text has 3 characters, the variable holds 2"]


@pytest.mark.parametrize(
    "text, said",
    [
        ("COPY 5,I_A[I_NONE]", "I_A: Index variable not found!"),
        ("COPY 5,I_A[R1]", "I_A: Wrong operand types!"),
        ("COPY 5,V_A[1].X", "V_A: Wrong operand types!"),
        ("COPY V1.FRAME,P1.A9", "Wrong operand types!"),
        ("COPY V1.Z,P1.B", "Wrong operand types!"),
        ("COPY T1.X,P1.X", "Wrong operand types!"),
    ],
)
def test_what_no_caller_can_mend_is_found_before_the_start(text: str, said: str) -> None:
    assert steps(text, ALL).faults == [f"step 2: {said}"]


def test_what_a_caller_may_bring_is_no_fault_before_the_start() -> None:
    assert not steps("COPY 5,I_A[I1]\nCOPY V1.X,P1.Y\nCOPY P1.A9,V1.A8\nCOPY V1.FRAME,P1.FRAME", ALL).faults
