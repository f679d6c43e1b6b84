"""Numbers, logic, vectors, branches, waits: the language rows of the requirements."""

import pytest

from gateway.pure.languages.base.faults import Faults
from gateway.pure.languages.robotstar.faults import StepFault
from gateway.pure.languages.robotstar.memory import Memory, Source
from gateway.pure.languages.robotstar.operands import Number, Ref
from gateway.pure.languages.robotstar.values import Cell
from hil_tests.unit.languages.robotstar.memory import WORDS, checked, run, steps

I1 = "VAR name:I1\nVAR name:I2"


@pytest.mark.requirement("RSV-LNG-01", by="gateway.pure.languages.robotstar.words:Words.from_data")
@pytest.mark.requirement("RSV-LNG-20", by="gateway.pure.languages.robotstar.words:Words.from_data")
@pytest.mark.parametrize(
    "spellings",
    [
        ("WRITE_BIT #AUSGANG, Pegel: 1, Byte: 5, Bit_Nr: 3", "SCHR_BIT #AUSGANG, level: 1, Byte-Nr: 5, Bit: 3", "WRITE_BIT #OUTPUT,1,5,3"),
        ("PATH_SPEED [mm/s]: 200.0000", "PATH_VELOC 200.0", "BAHN_GESCHW 200.0", "GESCH_CP: 200.0"),
        ("UEBERSCHL #EIN", "ÜBERSCHL #ON"),
        ("COPY Source: 5, Variable: I1", "KOPIERE Quelle: 5, Ziel_Var: I1", "KOPIERE source:5,destination:I1", "copy 5,i1"),
        ("BEWEG_ART: #LINEAR", "INTERPOL #CP_LIN", "MOVE_MODE #LINEAR"),
        ("BAHN_RADIUS 20.0", "BAHN RADIUS [mm]: 20.0", "Bahn Radius 20.0", "PATH_RADIUS[mm]:20.0"),
        ("PTP_GESCHW 50", "PTP GESCHW: 50"),
    ],
)
def test_spellings_are_one_command(spellings: tuple[str, ...]) -> None:
    found = []
    for text in spellings:
        memory, faults = checked({"P.MPR": text, "V.MPR": I1})
        assert not list(faults)
        step = memory.programs["P"][0].steps[1]
        found.append((step.word, dict(step.slots)))
    assert found == [found[0]] * len(found)


def test_pallet_is_printed_as_pal_too() -> None:
    memory, faults = checked({"P.MPR": 'C pattern\nPAL "X", #INIT'})
    assert memory.programs["P"][0].steps[2].word == "PALLET"
    assert ["pallet program X not found" in text for text in map(str, faults)] == [True]


@pytest.mark.requirement("RSV-LNG-02", by="gateway.pure.languages.robotstar.data_steps:invert")
def test_integers_have_32_bits() -> None:
    ran = steps("COPY 2147483647,I1\nINVERT I1\nCOPY 0,I2\nINVERT I2", I1)
    assert (ran.value("I1"), ran.value("I2")) == (-2147483648, -1)
    assert any("outside the range of an integer" in text for text in steps("COPY 2147483648,I1", I1).faults)


@pytest.mark.requirement("RSV-LNG-03", by="gateway.pure.languages.robotstar.memory:Memory.kind_of")
def test_first_letter_is_the_type() -> None:
    memory, faults = checked({"V.MPR": "VAR VX\nVAR TX\nVAR S_A(20)\nVAR QX"})
    assert [fault.text for fault in faults] == ["step 5: QX: the first letter of a variable is its type: I R V P T S"]
    assert {name: getattr(variable, "kind", "") for name, variable in memory.globals.items()} == {"VX": "V", "TX": "T", "S_A": "S"}
    assert getattr(memory.globals["S_A"], "length", 0) == 20


@pytest.mark.requirement("RSV-LNG-04", by="gateway.pure.languages.robotstar.memory:Memory.add")
def test_a_global_name_is_unique() -> None:
    _, faults = checked({"A.MPR": "VAR I123", "B.MPR": "VAR I123"})
    assert [(fault.position.file, fault.text) for fault in faults] == [("B.MPR", "step 2: I123 is defined twice in the memory (in A)")]


@pytest.mark.requirement("RSV-LNG-05", by="gateway.pure.languages.robotstar.machine:Machine.call")
def test_locals_reach_into_called_programs() -> None:
    files = {"A.MPR": "LOC_VAR IABC\nCOPY 7,IABC\nCALL B", "B.SPR": "COPY IABC,I1", "C.MPR": "CALL B", "V.MPR": "VAR I1"}
    assert run(files, "A", until=1).value("I1") == 7
    ran = run(files, "C", until=1)
    assert (ran.texts(), ran.end["program"], ran.step) == (["Definition not found!"], "B", 2)


@pytest.mark.requirement("RSV-LNG-06", by="gateway.pure.languages.robotstar.values:Cell.read")
def test_reading_before_writing_is_an_error() -> None:
    assert Cell("I", 5).read() == 5
    with pytest.raises(StepFault, match="not initialized"):
        Cell("I").read()
    ran = steps("COPY I1,I2", I1)
    assert (ran.texts(), ran.state, ran.step) == (["Variable not initialized!"], "error", 2)


@pytest.mark.requirement("RSV-LNG-07", by="gateway.pure.languages.robotstar.data_steps:math_step")
@pytest.mark.parametrize(
    "text, value",
    [
        ("ADD 3,I1", 13),
        ("SUB 3,I1", 7),
        ("MUL 4,I1", 40),
        ("DIV 3,I1", 3),
        ("MODULO 4,I1", 2),
        ("ADD 2.5,I1", 13),
        ("SUB Op_1:5,Ziel_Var:I1", 5),
    ],
)
def test_mathematics(text: str, value: int) -> None:
    assert steps(f"COPY 10,I1\n{text}", I1).value("I1") == value


@pytest.mark.parametrize("text, value", [("DIV 2,I1", -3), ("MODULO 2,I1", -1), ("DIV -2,I1", 3)])
def test_division_goes_towards_0(text: str, value: int) -> None:
    assert steps(f"COPY -7,I1\n{text}", I1).value("I1") == value


@pytest.mark.parametrize(
    "text, said",
    [("DIV 0,I1", "division by zero"), ("MODULO 0,I1", "division by zero"), ("MUL 2147483647,I1", "value 21474836470")],
)
def test_what_cannot_be_calculated_stops(text: str, said: str) -> None:
    ran = steps(f"COPY 10,I1\n{text}", I1)
    assert str(ran.texts()[0]).startswith(said) and ran.value("I1") == 10


@pytest.mark.requirement("RSV-LNG-08", by="gateway.pure.languages.robotstar.data_steps:negate")
def test_neg_and_invert() -> None:
    ran = steps("COPY 5,I1\nNEG I1\nCOPY 5,I2\nINVERT I2", I1)
    assert (ran.value("I1"), ran.value("I2")) == (-5, -6)


@pytest.mark.requirement("RSV-LNG-09", by="gateway.pure.languages.robotstar.data_steps:logic_step")
@pytest.mark.requirement("RSV-LNG-10", by="gateway.pure.languages.robotstar.data_steps:logic_step")
@pytest.mark.parametrize(
    "first, text, value",
    [
        ("255", "AND 0FH,I1", 15),
        ("0", "OR 101B,I1", 5),
        ("15", "EXCL_OR 10,I1", 5),
        ("0", "OR 80000000H,I1", -(2**31)),
        ("-1", "AND 4294967295,I1", -1),
        ("3", "SHIFT_L 2,I1", 12),
        ("40000000H", "SHIFT_L 2,I1", 0),
        ("-1", "SHIFT_R 28,I1", 15),
        ("-1", "SHIFT_R 32,I1", 0),
    ],
)
def test_logic(first: str, text: str, value: int) -> None:
    assert steps(f"COPY {first},I1\n{text}", I1).value("I1") == value


VALUES = (("VEC1", (150, -30, 10)), ("VEC2", (200, 100, 30)))
VECTORS = "\n".join(f"COPY {value},{name}.{axis}" for name, row in VALUES for axis, value in zip("XYZ", row, strict=True))


@pytest.mark.requirement("RSV-LNG-11", by="gateway.pure.languages.robotstar.data_steps:vector_step")
def test_vectors_add_and_subtract() -> None:
    definitions = "VAR VEC1\nVAR VEC2"
    ran = steps(f"{VECTORS}\nVEC_ADD VEC1,VEC2", definitions)
    assert [ran.value(f"VEC2.{axis}") for axis in "XYZ"] == [350, 70, 40]
    assert [ran.value(f"VEC1.{axis}") for axis in "XYZ"] == [150, -30, 10]
    ran = steps(f"{VECTORS}\nVEC_ADD VEC1,VEC2\nVEC_SUB VEC1,VEC2", definitions)
    assert [ran.value(f"VEC2.{axis}") for axis in "XYZ"] == [200, 100, 30]


@pytest.mark.requirement("RSV-LNG-12", by="gateway.pure.languages.robotstar.data_steps:vector_value")
def test_length_of_a_vector() -> None:
    assert steps("COPY 80,V.X\nCOPY 60,V.Y\nCOPY 0,V.Z\nVEC_VALUE V,R1", "VAR V\nVAR R1").value("R1") == 100.0


@pytest.mark.requirement("RSV-LNG-13", by="gateway.pure.languages.robotstar.control_steps:test_value")
@pytest.mark.parametrize("relation, holds", [("=", "0"), ("<>", "-+"), ("<", "-"), (">", "+"), ("<=", "-0"), (">=", "0+")])
def test_relations(relation: str, holds: str) -> None:
    for sign, value in (("-", 9), ("0", 10), ("+", 11)):
        text = f'COPY {value},I1\nTESTE #VARIABLE, Op_1: I1, #{relation}, Op_2 10, Marke: "ABC"\nCOPY 1,I2\nLABEL ABC'
        assert (steps(text, I1).value("I2") is None) == (sign in holds)


@pytest.mark.requirement("RSV-LNG-14", by="gateway.pure.languages.robotstar.control_steps:test_value")
def test_bytes_compare_with_the_number() -> None:
    text = "WRITE_BIT #AUSGANG,1,1,0\nWRITE_BIT #AUSGANG,1,1,2\nTESTE #AUSGANG, Op_1: {}, #{}, Byte: 1, Marke: X\nCOPY 1,I1\nLABEL X"
    assert steps(text.format(5, "="), I1).value("I1") is None
    assert steps(text.format(4, "="), I1).value("I1") == 1
    assert steps(text.format(4, "<"), I1).value("I1") is None  # operand 1 is the number (L718)


@pytest.mark.requirement("RSV-LNG-15", by="gateway.pure.languages.robotstar.control_steps:test_bit")
def test_bits_of_variables_and_markers() -> None:
    text = 'COPY {},I1\nSCHR_BIT #MERKER, Pegel:1, Byte-Nr:52, Bit-Nr:5\nTEST_BIT {}, Marke: "ABC"\nCOPY 1,I2\nMARKE "ABC"'
    assert steps(text.format(32, "#VARIABLE, #=1, Variable: I1, Bit_Nr: 5"), I1).value("I2") is None
    assert steps(text.format(0, "#VARIABLE, #=1, Variable: I1, Bit_Nr: 5"), I1).value("I2") == 1
    assert steps(text.format(0, "#MERKER, #=1, Byte: 52, Bit_Nr: 5"), I1).value("I2") is None
    assert steps(text.format(0, "#MERKER, #=0, Byte: 52, Bit_Nr: 5"), I1).value("I2") == 1


@pytest.mark.requirement("RSV-LNG-16", by="gateway.pure.languages.robotstar.control_steps:wait_bit")
def test_waiting_for_ever() -> None:
    text = "WAIT_BIT #EINGANG, Pegel: 1, Byte: 0, Bit_Nr: 5, Max_Zeit: 0.0, Marke: X\nCOPY 1,I1"
    ran = steps(text, I1, until=60)
    assert (ran.state, ran.step, ran.value("I1")) == ("waiting", 2, None)
    assert steps(text, I1, at=("61 E0.5=1",)).value("I1") == 1


@pytest.mark.requirement("RSV-LNG-17", by="gateway.pure.languages.robotstar.robot:Robot._due")
def test_waiting_for_a_time() -> None:
    text = (
        "WAIT_BIT #EINGANG, Pegel: 1, Byte: 0, Bit_Nr: 5, Max_Zeit: 10.0, Marke: ABC\nCOPY 1,I1\nSTOP\nLABEL ABC\nWRITE_BIT #AUSGANG,1,0,0"
    )
    ran = steps(text, I1)
    assert ran.when("A0") == [(10.0, 1)] and ran.value("I1") is None
    ran = steps(text, I1, at=("5 E0.5=1",))
    assert ran.value("I1") == 1 and not ran.when("A0")


@pytest.mark.requirement("RSV-LNG-18", by="gateway.pure.languages.robotstar.control_steps:wait")
def test_wait() -> None:
    ran = steps("WRITE_BIT #AUSGANG,1,0,0\nWAIT 2.0\nWRITE_BIT #AUSGANG,1,0,1")
    assert ran.when("A0") == [(0.0, 1), (2.0, 3)]


@pytest.mark.requirement("RSV-LNG-19", by="gateway.pure.languages.robotstar.reader:_labels")
def test_labels_are_unique_and_local() -> None:
    _, faults = checked({"A.MPR": "LABEL X\nLABEL X", "B.MPR": "BRANCH X"})
    assert [fault.id for fault in faults] == ["rsv.label_twice", "rsv.label_lost"]
    ran = run({"A.MPR": "LABEL X", "B.MPR": "COPY 1,I1\nBRANCH X", "V.MPR": I1}, "B")
    assert (ran.state, ran.message()["at"], ran.message()["step"], ran.value("I1")) == ("error", 0.0, 3, None)


@pytest.mark.requirement("RSV-LNG-21", by="gateway.pure.languages.robotstar.data_steps:copy_offsets")
def test_components_by_number() -> None:
    text = "COPY 1,V1.X\nCOPY 2,V1.Y\nCOPY 3,V1.Z\nCOPY 9,V2.A\nCOPY_OFFSETS Quellindex: 2, Quelle: V1, Zielindex: 2, Ziel: V2, Anzahl: 3"
    ran = steps(f"{text}\nCOPY_OFFSETS 1,100.0,12,T1,1\nCOPY T1.Z,R1", "VAR V1\nVAR V2\nVAR T1\nVAR R1")
    assert [ran.value(f"V2.{name}") for name in ("Frame", "X", "Y", "Z", "A")] == [None, 1, 2, 3, 9]
    assert (ran.value("T1.Z"), ran.value("R1")) == (100.0, 100.0)
    ran = steps(f"{text}\nCOPY_OFFSETS 3,V1,1,R1,1\nCOPY_OFFSETS 3,V1,1,R1,2", "VAR V1\nVAR V2\nVAR R1")
    assert (ran.value("R1"), ran.texts()) == (2, ["Index too big or too small!"]), "one component goes to a number, two do not"


@pytest.mark.requirement("RSV-LNG-22", by="gateway.pure.languages.robotstar.checker:_position")
def test_a_position_needs_a_tool() -> None:
    position = "POSITION #N, X:1, Y:2, Z:3, A:0, B:0, C:0"
    assert "TOOL is needed" in steps(position).faults[0] and not steps(position).targets()
    ran = steps(f"COPY 0,T1.X\nTOOL T1\n{position}", "VAR T1")
    assert not ran.faults and ran.targets() == [(1, 2, 3)]


def test_a_descriptor_may_be_printed_in_two_words() -> None:
    """L3251."""
    memory, faults = checked({"P.MPR": 'VAR I1\nTRAFO_6D Ref source: A, Ref destination: B, Source: "C", Destination: D, Control word: I1'})
    step = memory.programs["P"][0].steps[2]
    assert step.valid and step.slots["control"] == Ref("I1") and all("descriptor" not in fault.text for fault in faults)


def test_literals() -> None:
    memory, _ = checked({"P.MPR": "COPY 0FFFFFFFFH,I1"})
    assert memory.programs["P"][0].steps[1].slots["source"] == Number(-1, bits=True)


def test_an_analog_input_is_read_in_volts() -> None:
    text = "LOK_VAR RDRUCK\nMARKE WIEDERHOLE\nANA_EING 2,RDRUCK\nTESTE #VARIABLE, RDRUCK, #<, 5.0, WIEDERHOLE"
    text += "\nSCHR_BIT #AUSGANG, 1, 0, 4\nANA_OUTP -5.0, 3"
    ran = steps(text, at=("1.5 EA2=4.5", "2.5 EA2=5.5"))
    assert ran.when("A0") == [(2.5, 16)]
    assert ran.cell.image[1924:1926] == (-16384).to_bytes(2, "little", signed=True)


def test_outputs_and_markers_are_words_too() -> None:
    ran = steps("COPY 2048,_IBIN_OUT[2]\nKOPIERE 7,_SPS[54]\nCOPY _SPS[54],I1", I1)
    assert ran.when("A5") == [(0.0, 8)] and ran.when("M212") == [(0.0, 7)] and ran.value("I1") == 7


def test_a_loop_of_tests_gives_its_time_away() -> None:
    ran = steps("LABEL L\nTEST_BIT #EINGANG,#=0,1,0,L\nWRITE_BIT #AUSGANG,1,0,0", at=("300 E1.0=1",))
    assert ran.when("A0") == [(300.0, 1)]


def test_a_misspelt_definition_is_one_fault_and_a_macro_in_front_of_definitions_another() -> None:
    _, faults = checked({"P.MPR": "VRA I1\nVAR I2\nCOPY 1,I2"})
    assert [fault.text for fault in faults] == ["step 2: VRA is neither a command nor a macro of this memory"]
    memory, faults = checked({"P.MPR": "MAK\nMAK\nVAR I2\nCOPY 1,I2", "MAK.MAC": "WAIT 1"})
    assert [fault.text for fault in faults] == ["step 4: definitions belong at the beginning, before step 2"]
    assert memory.programs["P"][0].refused


def test_a_pattern_that_nobody_calls_is_checked() -> None:
    _, faults = checked({"P.PAL": "VAR I1"})
    assert [(fault.position.line, fault.text) for fault in faults] == [
        (3, "step 3: pallet program P: syntax error: one TOOL and four positions are needed")
    ]


@pytest.mark.parametrize("text", ["COPY 1.0e308,R1\nADD 1.0e308,R1", "COPY 1.0e200,R1\nMUL R1,R1", "COPY -1.0e300,R1\nDIV 1.0e-10,R1"])
def test_a_result_that_no_real_takes_stops(text: str) -> None:
    """`end` is JSON, which has no infinity."""
    ran = steps(text, "VAR R1")
    assert ran.texts() == ["value is outside the range of a real variable"]
    assert abs(float(str(ran.value("R1")))) in (1e308, 1e200, 1e300)


def test_the_length_of_a_huge_vector() -> None:
    ran = steps("COPY 1.0e200,V1.X\nVEC_VALUE V1,R1", "VAR R1\nVAR V1")
    assert (ran.texts(), ran.value("R1")) == ([], 1e200)


@pytest.mark.parametrize(
    ("value", "said"),
    [
        ("0", "value 0 must be above 0 and at most 1000000"),
        ("-5", "value -5 must be above 0 and at most 1000000"),
        ("2000000", "value 2000000 must be above 0 and at most 1000000"),
        ("1.0e-10", "value 1e-10 is outside 1e-06 .. 1000000"),
    ],
)
def test_a_speed_that_is_none_is_named_with_its_range(value: str, said: str) -> None:
    assert steps(f"PATH_SPEED {value}").faults == [f"step 2: PATH_SPEED: {said}"]
    if "above" in said:  # the same words where a variable has the value
        assert steps("PATH_SPEED IV", f"VAR IV, value:{value}").texts() == [said.replace("value", "PATH_SPEED")]


@pytest.mark.parametrize(("head", "said"), [("MPR Q", "the head names Q, the file P"), ("SPR P", "the head names SPR, the file MPR")])
def test_a_foreign_head_is_a_fault_of_step_1(head: str, said: str) -> None:
    faults = Faults()
    Memory.read([Source("P.MPR", f"{head}\nEND")], WORDS, faults)
    assert [fault.text for fault in faults] == [f"step 1: {said}"]


def test_an_element_of_a_system_variable_is_assigned_as_one_that_has_no_index() -> None:
    assert steps("_SPS[6] = 77\nCOPY _SPS[6],I1", I1).value("I1") == 77
