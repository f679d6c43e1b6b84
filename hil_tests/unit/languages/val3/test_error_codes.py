"""Every run-time error of the manual (L3656-3698, L6607-6710): raised by VAL 3 source, or listed with its reason."""

import pytest

from gateway.pure.languages.val3.errors import TEXTS
from hil_tests.unit.languages.val3.apps import App, datum, run, value

DATA = "".join(datum(name, "num") for name in ("n", "i")) + datum("a", "num", "3") + datum("b", "bool") + datum("s", "string")
DATA += '<Data name="c" access="public" xsi:type="collection" type="num" />'
DATA += datum("di", "dio", values=value(link="UserIO\\%I0")) + datum("none", "dio") + datum("j", "joint", values=value(j3=90, j5=90))
DATA += datum("jRs", "jointRs") + datum("p", "point", values=value(x=9999, fatherId="world[0]"))
DATA += (
    datum("lost", "point", values=value(fatherId="nowhere[0]"))
    + datum("bare", "Bare")
    + datum("m", "mdesc")
    + datum("t", "tool", values=value(fatherId="flange[0]"))
)
DATA += datum("f", "frame", values=value(fatherId="world[0]")) + datum("g", "frame", values=value(fatherId="f[0]"))
TYPE = '<Type name="Bare" path="bare" />'
BARE = App("bare", datum("p", "point") + datum("f", "frame") + datum("t", "tool"))
LIBRARY = '<Library alias="lib" path="part" />'
PART = App("part", datum("nX", "num"))
CODES: dict[int, str] = {
    10: "n=1/n",
    11: "n=ln(-1)",
    20: "a[3]=1",
    21: "a[-1]=1",
    23: 'n=c[""]',
    25: 'n=c["no"]',
    29: 'taskCreate "a b", 10, sub()',
    30: 'taskSuspend("none")',
    31: 'taskCreate "x", 10, sub()\ntaskCreate "x", 10, sub()',
    32: 'taskCreateSync "x",0.004,b,sub()\ntaskCreateSync "y",0.008,b,sub()\ntaskCreateSync "z",0.012,b,sub()',
    40: "resize(a,1,10000)",
    41: "call deep()",
    45: "wdgRefresh()",
    70: 's=left("abc",-1)',
    80: "n=lib:nX",
    82: "n=distance(lost,lost)",
    81: "movej(jRs,t,m)",
    90: 'taskCreate "x", 10, sub()\ntaskSuspend("x")\ntaskResume("x",50)',
    100: "m.vel=-1\nmovej(j,t,m)",
    101: "m.accel=-1\nmovej(j,t,m)",
    102: "m.decel=-1\nmovej(j,t,m)",
    103: "m.tvel=-1\nmovej(j,t,m)",
    104: "m.rvel=-1\nmovej(j,t,m)",
    105: "m.reach=-1\nmovej(j,t,m)",
    106: "m.leave=-1\nmovej(j,t,m)",
    122: "di=true",
    123: "none=true",
    125: "wait(clock()>0.5)\nb=di",
    154: "movej(p,t,m)",
    160: "flange.trsf.x=1\np=here(t,world)",
    161: "world.trsf.x=1\np=here(t,world)",
    162: "n=distance(bare.p,bare.p)",
    163: "p=here(t,bare.f)",
    164: "p=here(bare.t,world)",
    165: "link(f,g)\np.trsf=position(f,world)",
    250: "$addOn()",
}
ELSEWHERE = {  # raised by tests of their own, or by programs of other files
    33: "test_tasks: 3000 lines in one cycle",
    71: "test_instructions: append of a local array",
    150: "vectors circle_and_stop, queued_moves: a move that fails later",
    153: "test_in_a_cell: resetTurn in a cell; a control without an arm",
}
REASONS = {
    -1: "a status, no error", 0: "a status, no error", 1: "a status, no error",
    34: "no instruction of this control is bound to one task", 60: "sio returns codes and 125; no instruction has another longest time",
    61: "an internal error of axisgate's interpreter",
    124: "the points of a cell have no protection of their own", 126: "an aio point takes fractions, or rounds them where it is whole",
    999: "log entries name their cause",
}  # fmt: skip
ADD_ONS = {170, 171, 270, 271, 290, 301, 560, 561, 562, 563, 564, 565, 571, 572, 573, 574, 580, 581, 582, 600, 610, 611}
GENERATOR = range(512, 769)  # causes: in the log behind 150 and 154 (tests of motion.val3)


@pytest.mark.parametrize("code", CODES)
def test_each_code_is_raised_by_source(code: int) -> None:
    programs = {"start": CODES[code], "sub": "delay(9)", "deep": "call deep()"}
    app = App(data=DATA, types=TYPE, libraries=LIBRARY, programs=programs)
    at = ((0.1, "io.UserIO\\%I0=fault"),) if code == 125 else ()
    result = run(app, BARE, PART, arm=True, at=at, until=2.0)
    tasks = result["tasks"]
    assert isinstance(tasks, dict) and tasks["demo~"]["status"] == code, result["log"]


def test_every_other_code_has_its_reason() -> None:
    known = CODES.keys() | ELSEWHERE.keys() | REASONS.keys() | ADD_ONS | set(GENERATOR)
    assert TEXTS.keys() <= known, sorted(TEXTS.keys() - known)
    assert not CODES.keys() & (ELSEWHERE.keys() | REASONS.keys() | ADD_ONS)
