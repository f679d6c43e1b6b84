"""Random PLC programs run alike as interpreted commands and as generated functions: memory, cells, accumulators, commands counted."""

from collections.abc import Sequence

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gateway.pure.languages.plc.commands import Program
from gateway.pure.languages.plc.generated import Generated
from gateway.pure.languages.plc.interpreter import Interpreter
from gateway.pure.languages.plc.plc import LAYOUT
from gateway.pure.languages.plc.state import State, TimeError
from gateway.pure.languages.plc.translation import Translation

BITS = st.sampled_from(["E0.0", "E0.1", "E0.7", "A0.0", "A0.1", "M5.0", "M5.1", "M5.2", "M6.3", "M1020.5"])
CELL = st.sampled_from(["T1", "T2", "Z1", "Z2"])
BYTES = st.sampled_from(["E0", "A0", "M5", "M6", "M7", "M2008", "A36"])
NUMBERS = st.one_of(st.integers(0, 300), st.sampled_from([-1, -2, 2147483647, -2147483648, 99, 65536, 100000000]))
LOGIC = st.builds("{} {}".format, st.sampled_from(["U", "UN", "O", "ON", "XO", "XON"]), BITS | CELL)
WRITES = st.builds("{} {}".format, st.sampled_from(["S", "R", "="]), BITS)
LOADS = st.one_of(
    st.builds("{} {}".format, st.sampled_from(["L", "LD", "T", "TD"]), BYTES.filter(lambda name: name != "A39")),
    st.builds("L {}".format, NUMBERS),
)
CELLS = st.sampled_from(
    ["ST I,T1", "ST V,T2", "ST E,T1", "ST A,T2", "ZV Z1,1", "ZR Z1,1", "S Z2", "R Z1", "R T1", "R T2", "ZV ACCU,7", "ZR ACCU,255"]
)
ALONE = st.sampled_from("=?|><|>=|>|<=|<|+|-|MU|DI|K E|K Z|TA|HD|DH|U ACCU|O ACCU|XO ACCU|SH R,3|SH L,31|RO R,1|RO L,17|SH L,0".split("|"))
CALLS = st.sampled_from(["SU ONE", "SU ONE,1", "SU TWO,0"])
JUMP = st.tuples(st.sampled_from(["SP {}", "SP {},1", "SP {},0"]), st.integers(0, 3))
PLAIN = st.one_of(LOGIC, LOGIC, WRITES, LOADS, CELLS, ALONE)


@st.composite
def programs(draw: st.DrawFn, calls: bool = True) -> str:
    """Commands, brackets that hold commands, labels anywhere outside of brackets, jumps to any of them, forwards and backwards."""
    lines: list[str] = []
    labels = draw(st.integers(0, 4))
    for _ in range(draw(st.integers(1, 14))):
        kind = draw(st.integers(0, 9))
        if kind == 0 and labels:
            form, target = draw(JUMP)
            lines.append(form.format(f"L{target % labels}"))
        elif kind == 1:
            lines += [draw(st.sampled_from(["U(", "O(", "XO("])), *draw(bracketed()), ")"]
        elif kind == 2 and calls:
            lines.append(draw(CALLS))
        else:
            lines.append(draw(PLAIN))
    for label in range(labels):
        depths = [at for at in range(len(lines) + 1) if not sum((line[-1] == "(") - (line == ")") for line in lines[:at])]
        lines.insert(draw(st.sampled_from(depths)), f"M L{label}")
    return "\n".join(lines)


@st.composite
def bracketed(draw: st.DrawFn, depth: int = 0) -> list[str]:
    lines = draw(st.lists(PLAIN if draw(st.booleans()) else LOGIC, min_size=1, max_size=5))
    if depth < 3 and draw(st.booleans()):
        lines += [draw(st.sampled_from(["U(", "O(", "XO("])), *draw(bracketed(depth + 1)), ")", draw(PLAIN)]
    return lines


def program_of(main: str, one: str, two: str) -> Program:
    translation = Translation({"MAIN": f"{main}\nEND", "ONE": f"{one}\nSU TWO,1\nEND", "TWO": f"{two}\nEND"})
    program = translation.run("MAIN")
    assert program is not None, [str(fault) for fault in translation.faults]
    return program


def too_long(routine: str, line: int) -> int:
    raise TimeError(routine, line)


Outcome = tuple[object, ...]


def outcome(state: State, result: object) -> Outcome:
    return bytes(state.memory), bytes(state.written), state.cells.kept(), result


def interpreted(program: Program, scans: Sequence[tuple[int, int]]) -> list[Outcome]:
    state = State(LAYOUT)
    interpreter = Interpreter(program, state, too_long)
    found: list[Outcome] = []
    for now, inputs in scans:
        state.memory[LAYOUT.inputs], state.cells.now = inputs, now
        interpreter.begin(400)
        try:
            interpreter.run()
            left = interpreter.allowance
            found.append(outcome(state, (interpreter.result, interpreter.accu1, interpreter.accu2, left)))
        except TimeError as error:
            found.append(outcome(state, str(error)))
    return found


def generated(program: Program, scans: Sequence[tuple[int, int]]) -> list[Outcome]:
    state = State(LAYOUT)
    functions = Generated(program, state, too_long)
    found: list[Outcome] = []
    for now, inputs in scans:
        state.memory[LAYOUT.inputs], state.cells.now = inputs, now
        try:
            found.append(outcome(state, functions.scan(400)))
        except TimeError as error:
            found.append(outcome(state, str(error)))
    return found


@pytest.mark.requirement("RSV-PLC-04", by="gateway.pure.languages.plc.generated:Generated.scan")
@settings(max_examples=300, deadline=None)
@given(programs(), programs(calls=False), programs(calls=False), st.lists(st.integers(0, 255), min_size=1, max_size=5))
def test_both_executors_do_the_same(main: str, one: str, two: str, inputs: list[int]) -> None:
    program = program_of(main, one, two)
    scans = [(number * 700_000_000, value) for number, value in enumerate(inputs)]
    assert generated(program, scans) == interpreted(program, scans)


@settings(max_examples=300, deadline=None)
@given(st.text(alphabet="UNOXELTSPMRDIHKAZ 0123456789.,;()=<>+-\\\n\"'#:", max_size=120))
def test_any_text_is_a_program_or_a_list_of_faults(text: str) -> None:
    translation = Translation({"MAIN": text, "PART": "END"})
    program = translation.run("MAIN")
    assert (program is None) == (translation.faults.errors > 0)
    if program is not None:
        generated(program, [(0, 1), (1, 0)])
