"""PALLET: counters, offsets, formats."""

import pytest

from hil_tests.unit.languages.robotstar.memory import checked, run

ZERO = "POSITION #N, X:0, Y:0, Z:100, A:0, B:0, C:0"


def pattern(counts: tuple[int, int, int], corners: str = "", behind: str = "", front: str = "", integers: int = 4) -> str:
    places = corners or "\n".join(
        f"POSITION #N, X:{x}, Y:{y}, Z:{z}, A:0, B:0, C:0" for x, y, z in ((0, 0, 0), (200, 0, 0), (0, 300, 0), (0, 0, 50))
    )
    names = "\n".join(f"VAR name:{name}" for name in ("ITOTAL", "ACTVALUE1", "ACTVALUE2", "ACTVALUE3")[:integers])
    vectors = "\n".join(f"LOC_VAR name:V_ZP_EP{n}" for n in (1, 2, 3))
    parts = "\n".join(f"LOC_CONST name:I_PARTS{n},value:{count}" for n, count in enumerate(counts, 1))
    return f"{names}\n{vectors}\nC Constants\n{parts}\n{front}\nTOOL variable:T\n{places}\n{behind}".replace("\n\n", "\n")


def files(body: str, *args: object, corners: str = "", behind: str = "", front: str = "", integers: int = 4) -> dict[str, str]:
    counts = args[0] if args else (3, 3, 2)
    assert isinstance(counts, tuple)
    return {"P.MPR": body, "PAT.MPR": pattern(counts, corners, behind, front, integers)}


ON = f'PALLET "PAT",#ON\n{ZERO}'


@pytest.mark.requirement("RSV-PAL-01", by="gateway.pure.languages.robotstar.pallet:_init")
@pytest.mark.requirement("RSV-PAL-06", by="gateway.pure.languages.robotstar.pallet:_init")
@pytest.mark.parametrize("counts, total", [((3, 3, 2), 18), ((3, 3, 0), 9), ((5, 0, 0), 5)])
def test_init(counts: tuple[int, int, int], total: int) -> None:
    ran = run(files('PALLET "PAT",#INIT', counts))
    assert [ran.value(name) for name in ("ITOTAL", "ACTVALUE1", "ACTVALUE2", "ACTVALUE3")] == [total, 0, 0, 0]


@pytest.mark.requirement("RSV-PAL-02", by="gateway.pure.languages.robotstar.pallet:_on")
@pytest.mark.requirement("RSV-PAL-04", by="gateway.pure.languages.robotstar.pallet:_off")
def test_on_and_off() -> None:
    ran = run(files(f'TOOL T\nPALLET Prog_name:"PAT",#INIT\n{ON}\n{ON}\n{ON}\nPALLET "PAT",#OFF\n{ZERO}'))
    assert [target[0] for target in ran.targets()] == [0, 100, 200, 0] and ran.value("ITOTAL") == 15


@pytest.mark.requirement("RSV-PAL-03", by="gateway.pure.languages.robotstar.pallet:_count")
def test_carry() -> None:
    ran = run(files("TOOL T\nPALLET PAT #INIT\n" + "\n".join([ON] * 5), (5, 8, 0)))
    assert (ran.value("ACTVALUE1"), ran.value("ACTVALUE2"), ran.value("ACTVALUE3")) == (0, 1, 0)


@pytest.mark.requirement("RSV-PAL-05", by="gateway.pure.languages.robotstar.pallet:_on")
def test_on_before_init() -> None:
    ran = run(files(f"TOOL T\n{ON}"))
    assert (ran.texts(), ran.state, ran.step) == (["Variable not initialized!"], "error", 3)


@pytest.mark.requirement("RSV-PAL-07", by="gateway.pure.languages.robotstar.pallet:_count")
def test_a_row_is_left_out() -> None:
    body = f'TOOL T\nPTP_SPEED 100\nPALLET "PAT",#INIT\nLABEL CYCLE\n{ON}\nPALLET "PAT",#OFF'
    body += "\nTEST #VARIABLE,Op_1:ACTVALUE2,#<>,Op_2:6,label:NEXT\nTEST #VARIABLE,ACTVALUE1,#<>,0,NEXT"
    body += "\nADD 1,ACTVALUE2\nSUB 5,ITOTAL\nLABEL NEXT\nTEST #VARIABLE,ITOTAL,#>,0,CYCLE\nSTOP"
    ran = run(files(body, (5, 8, 0)))
    rows = sorted({round(target[1] * 7 / 300) for target in ran.targets()})
    assert (len(ran.targets()), rows, ran.value("ITOTAL"), ran.state) == (35, [0, 1, 2, 3, 4, 5, 7], 0, "stopped")


SKEW = "\n".join(f"POSITION #N, X:{x}, Y:{y}, Z:{z}, A:0, B:0, C:0" for x, y, z in ((0, 0, 0), (200, 0, 0), (20, 300, 0), (5, 5, 50)))
REALS = "LOC_CONST name:R_ABST1,value:50.0\nLOC_CONST name:R_ABST2,value:60.0\nLOC_CONST name:R_ABST3,value:70.0"


@pytest.mark.requirement("RSV-PAL-08", by="gateway.pure.languages.robotstar.pallet:_rectangular")
def test_right_angles() -> None:
    body = "TOOL T\nPALLET PAT #INIT\n" + "\n".join([ON] * 4)
    fourth = run(files(body, corners=SKEW, behind="LOC_CONST name:I_STEUER,value:1")).targets()[3]
    assert fourth == (0, 150, 100)
    assert run(files(body, corners=SKEW)).targets()[3] == (10, 150, 100)


@pytest.mark.requirement("RSV-PAL-09", by="gateway.pure.languages.robotstar.pallet:_write_delta")
def test_distances() -> None:
    body = "TOOL T\nPALLET PAT #INIT\n" + "\n".join([ON] * 4)
    ran = run(files(body, behind=f"LOC_CONST name:I_STEUER,value:2\n{REALS}"))
    assert ran.targets() == [(0, 0, 100), (50, 0, 100), (100, 0, 100), (0, 60, 100)]


@pytest.mark.requirement("RSV-PAL-10", by="gateway.pure.languages.robotstar.pallet:pattern_of")
@pytest.mark.parametrize(
    "given", [{"integers": "3"}, {"front": "VAR P1\nVAR P2"}, {"behind": "LOC_CONST name:I_STEUER,value:0\nLOC_CONST name:R_X,value:1.0"}]
)
def test_the_format_is_checked(given: dict[str, str]) -> None:
    memory = files("PALLET PAT #INIT", integers=int(given.pop("integers", "4")), **given)
    ran = run(memory)
    assert "PAT: syntax error" in str(ran.texts()[0]) and ran.step == 2
    assert any("syntax error" in fault.text for fault in checked(memory)[1])


@pytest.mark.requirement("RSV-PAL-11", by="gateway.pure.languages.robotstar.pallet:_corner")
def test_position_variables() -> None:
    front = "VAR P_ZP\nVAR P_EP1\nVAR P_EP2\nVAR P_EP3"
    corners = "VAR_POS variable:P_ZP\nPOSITION variable:P_EP1\nPOSITION variable:P_EP2\nVAR_POS P_EP3"
    body = f"TOOL T\n{ZERO}\nACT_POS P_ZP\nACT_POS P_EP1\nACT_POS P_EP2\nACT_POS P_EP3\nCOPY 80,P_EP1.X\nPALLET PAT #INIT\n{ON}\n{ON}"
    ran = run(files(f"{body}\nCOPY 40,P_EP1.X\nPALLET PAT #INIT\n{ON}\n{ON}", corners=corners, front=front))
    assert [target[0] for target in ran.targets()] == [0, 0, 40, 0, 20]


def test_position_variables_are_defined_in_the_pattern_itself() -> None:
    corners = "VAR_POS P_ELSEWHERE\n" + "\n".join(["POSITION #N, X:0, Y:0, Z:0, A:0, B:0, C:0"] * 3)
    memory = files("PALLET PAT #INIT", corners=corners) | {"W.MPR": "VAR P_ELSEWHERE"}
    said = "position variable P_ELSEWHERE is not one of four that are defined in the pattern itself"
    assert run(memory).texts() == [f"pallet program PAT: syntax error: step 14: {said}"]
    assert [said in fault.text for fault in checked(memory)[1]] == [True]


FOUR = "one TOOL and four positions are needed"
KINDS = "four integers, three vectors, three part counts and no or four position variables are needed, not"
BEHIND = "the positions must be followed by no constant, one integer, or one integer and three reals"


@pytest.mark.parametrize(
    ("given", "step", "text"),
    [
        ({"TOOL variable:T\n": ""}, 13, FOUR),
        ({"TOOL variable:T": "TOOL variable:T\nTOOL variable:T"}, 14, FOUR),
        ({"X:0, Y:0, Z:50, A:0, B:0, C:0": "X:0, Y:0, Z:50, A:0, B:0, C:0\nPOSITION #N, X:0, Y:0, Z:0, A:0, B:0, C:0"}, 18, FOUR),
        ({"POSITION #N, X:0, Y:0, Z:50, A:0, B:0, C:0": "LOC_CONST I_STEUER,0"}, 17, FOUR),
        ({"POSITION #N, X:200": "WAIT 1\nPOSITION #N, X:200"}, 15, "TOOL must be followed by four positions"),
        ({"POSITION #N, X:200": "LOC_CONST I_STEUER,0\nPOSITION #N, X:200"}, 15, "no definition is allowed between the positions"),
        ({"VAR name:ACTVALUE3\n": ""}, 5, f"{KINDS} IIIVVVIII"),
        ({"LOC_CONST name:I_PARTS3,value:2\n": ""}, 12, f"{KINDS} IIIIVVVII"),
        ({"VAR name:ACTVALUE3": "VAR name:R_ACT3"}, 5, f"{KINDS} IIIRVVVIII"),
        ({"TOOL variable:T": "VAR P1\nVAR P2\nTOOL variable:T"}, 15, f"{KINDS} IIIIVVVIIIPP"),
        ({"VAR name:ITOTAL": "CONST ITOTAL,9"}, 2, "counters and vectors are variables"),
        ({"Z:50, A:0, B:0, C:0": "Z:50, A:0, B:0, C:0\nLOC_CONST R_ABST1,1.0"}, 18, BEHIND),
        ({"Z:50, A:0, B:0, C:0": "Z:50, A:0, B:0, C:0\nLOC_CONST I_STEUER,2\nLOC_CONST R_ABST1,1.0"}, 20, BEHIND),
    ],
)
def test_a_mistake_in_a_pattern_is_one_fault_at_its_step(given: dict[str, str], step: int, text: str) -> None:
    memory = files("PALLET PAT #INIT\nPALLET PAT #ON\nPALLET PAT #OFF")
    memory["PAT.PAL"] = memory.pop("PAT.MPR")
    for old, new in given.items():
        assert old in memory["PAT.PAL"]
        memory["PAT.PAL"] = memory["PAT.PAL"].replace(old, new)
    found = [(fault.position.file, fault.position.line, fault.text) for fault in checked(memory)[1]]
    assert found == [("PAT.PAL", step, f"step {step}: pallet program PAT: syntax error: {text}")]
    assert run(memory).texts() == [f"pallet program PAT: syntax error: step {step}: {text}"]


@pytest.mark.parametrize(
    ("name", "text", "hint"),
    [
        ("PTA", "pallet program PTA not found", "did you mean PAT?; also at step 3"),
        ("P", "program P is not a pallet program", "also at step 3"),
    ],
)
def test_a_wrong_name_of_a_pattern_is_one_fault(name: str, text: str, hint: str) -> None:
    (fault,) = checked(files(f"PALLET {name} #INIT\nPALLET {name} #ON"))[1]
    assert (fault.position.line, fault.text, fault.hint) == (2, f"step 2: {text}", hint)
