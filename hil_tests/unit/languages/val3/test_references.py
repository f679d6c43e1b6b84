"""What frames, tools and points of files hang on: elements of arrays, data of libraries, nothing (L3674-3676, L4811-4829)."""

import re
from typing import Any

import pytest

from gateway.pure.languages.val3.disk import Disk
from gateway.pure.languages.val3.machine import Machine
from gateway.pure.languages.val3.references import element
from gateway.pure.languages.val3.values import FrameV, PointV, UserV
from hil_tests.unit.languages.val3.apps import App, check, datum, globals_of, machine, run, value

GRID = '<Data name="fGrid" access="public" xsi:type="array" type="frame" size="2,2">' + value("1,0", x=7, fatherId="world[0]") + "</Data>"
NAMED = '<Data name="fOf" access="public" xsi:type="collection" type="frame">' + value("left side", x=9, fatherId="world[0]") + "</Data>"
CELL = App(
    "cell",
    datum("fBase", "frame", "2", value("0", x=100, fatherId="world[0]") + value("1", x=50, fatherId="fBase[0]"))
    + datum("tHand", "tool", values=value(z=70, fatherId="flange[0]"))
    + datum("fOwn", "frame", values=value(fatherId="world[0]"), access="private"),
)
OTHER = App("other", datum("fBase", "frame", "2", value("1", x=2, fatherId="world[0]")) + datum("tHand", "tool"))
USES = '<Library alias="lib" path="Disk://cell/cell.pjx" />'
DATA = (
    GRID
    + NAMED
    + datum("n", "num", "12")
    + datum("pGrid", "point", values=value(x=1, fatherId="fGrid[1,0]"))
    + datum("pNamed", "point", values=value(x=1, fatherId='fOf["left side"]'.replace('"', "&quot;")))
    + datum("pLib", "point", values=value(x=1, fatherId="lib:fBase[1]"))
    + datum("tLib", "tool", values=value(z=5, fatherId="lib:tHand[0]"))
)


def numbers(code: str, *others: App, data: str = DATA) -> tuple[list[float], int, list[str]]:
    """n, the status of start(), the log."""
    result: Any = run(App(data=data, libraries=USES, programs={"start": code}), *(others or (CELL, OTHER)), arm=True)
    return [round(each, 9) for each in result["globals"]["n"]], result["tasks"].get("demo~", {"status": -1})["status"], result["log"]


def test_points_hang_on_elements_of_arrays_and_collections() -> None:
    found, status, log = numbers("n[0]=position(pGrid,world).x\nn[1]=position(pNamed,world).x")
    assert (found[:2], status) == ([8, 10], -1), log


def test_points_and_tools_hang_on_data_of_a_library_once_it_is_loaded() -> None:
    code = 'n[0]=lib:libLoad("cell")\nn[1]=position(pLib,world).x\nn[2]=position(tLib,flange).z\nlib:fBase[0].trsf.x=200\n'
    found, status, log = numbers(code + "n[3]=position(pLib,world).x")
    assert (found[:4], status) == ([0, 151, 75, 251], -1), log


def test_another_library_in_its_place_moves_the_points() -> None:
    code = 'n[0]=lib:libLoad("cell")\nn[1]=position(pLib,world).x\nn[2]=lib:libLoad("other")\nn[3]=position(pLib,world).x\n'
    found, status, log = numbers(code + 'link(pLib,world)\nn[4]=lib:libLoad("cell")\nn[5]=position(pLib,world).x')
    assert (found[:6], status) == ([0, 151, 0, 3, 0, 1], -1), (log, "what a program has linked stays")


@pytest.mark.parametrize(
    ("father", "code", "words"),
    [
        ("lib:fBase[1]", 80, ""),
        ("lib:fOwn[0]", 82, "there is no public frame of that name"),
        ("lib:fBase[2]", 82, "it has no such element"),
        ("none:fBase[0]", 82, "there is no library none"),
        ("fGone[0]", 82, "there is no frame of that name"),
        ("n[0]", 82, "there is no frame of that name"),
        ("flange[0]", 82, "there is no frame of that name"),
        ("fGrid[2,0]", 82, "it has no such element"),
        ("fGrid[1]", 82, "it has no such element"),
        ("f G", 82, "the name of a frame is expected"),
    ],
)
def test_a_reference_that_is_not_there_is_never_world(father: str, code: int, words: str) -> None:
    data = DATA + datum("p", "point", values=value(x=1, fatherId=father))
    load = "" if code == 80 else 'n[0]=lib:libLoad("cell")\n'
    found, status, log = numbers(load + "n[1]=9\nn[1]=position(p,world).x", data=data)
    assert (found[1], status) == (9, code) and any(father in line for line in log), log
    faults = check(App(data=data, libraries=USES), CELL)
    named = [fault.text for fault in faults if fault.id == "val3-reference"]
    assert named == ([f"'p' : fatherId {father!r}: {words}"] if words else [])
    assert faults.errors == 0, "it runs until the point is used"


def test_a_global_linked_to_a_local_is_165() -> None:
    app = App(
        data=datum("p", "point", values=value(fatherId="world[0]")) + datum("n", "num"),
        programs={"start": (["frame l_f", "point l_p"], "link(l_f,world)\nlink(l_p,l_f)\nn=1\nlink(p,l_f)")},
    )
    result: Any = run(app)
    assert (result["globals"]["n"], result["tasks"]["demo~"]["status"], result["tasks"]["demo~"]["line"]) == (1, 165, 5)


LOCALS = ["frame l_f", "frame l_g", "point l_p", "point l_q", "tool l_t"]
HANGS = {
    "link(l_g,l_f)\nf=l_g": 165,
    "link(l_p,l_f)\np=l_p": 165,
    "p=here(flange,l_f)": 165,
    "p=jointToPoint(flange,l_f,j)": 165,
    "link(l_p,l_f)\np=appro(l_p,{1,0,0,0,0,0})": 165,
    "link(l_p,l_f)\ncall put(p,l_p)": 165,
    "link(l_p,l_f)\ncall byValue(l_p)": 165,
    "call under(l_f)": 165,
    "link(l_t,flange)\nt=l_t": -1,
    "link(l_g,f)\nf2=l_g": -1,
    "link(l_p,l_f)\nl_q=l_p\nl_q=appro(l_q,{1,0,0,0,0,0})\nl_p=here(flange,l_g)": -1,
    "call seen(l_p,l_f)": -1,
}
HANGING_ON = {
    "put(point& x_a, point x_b)": "x_a=x_b",
    "byValue(point x_p)": "x_p.trsf.x=1\np=x_p",
    "under(frame& x_f)": "link(p,x_f)",
    "seen(point& x_p, frame& x_f)": "x_p=here(flange,x_f)",
}


def test_a_global_takes_no_local_reference_with_any_assignment() -> None:
    """Each in a task of its own: = copies the reference, too (L4846, L5054), so it is 165 as link() is (L3697)."""
    data = "".join(datum(name, "frame", values=value(fatherId="world[0]")) for name in ("f", "f2"))
    data += datum("p", "point", values=value(fatherId="world[0]")) + datum("t", "tool") + datum("j", "joint", values=value(j3=90, j5=90))
    data += datum("n", "num", str(len(HANGS)))
    programs: dict[str, Any] = {f"v{at}": (LOCALS, f"link(l_f,world)\nlink(l_g,world)\n{code}") for at, code in enumerate(HANGS)}
    lines = [f'taskCreate "t{at}",10,v{at}()' for at in range(len(HANGS))] + ["delay(0.1)"]
    lines += [f'n[{at}]=taskStatus("t{at}")' for at in range(len(HANGS))]
    result: Any = run(App(data=data, programs={"start": "\n".join(lines), **programs, **HANGING_ON}), arm=True, until=1.0)
    assert dict(zip(HANGS, result["globals"]["n"], strict=True)) == HANGS


BODY = App(
    "body",
    datum("f", "frame") + datum("aP", "point", "2") + datum("cP", "point", "") + datum("pGrid", "point", "1,1"),
    programs={"start": ""},
)
GROWN = {
    "append(l_u.aP)\nlink(l_u.aP[2],l_f)": -1,
    "insert(l_u.aP[0])\nlink(l_u.aP[0],l_f)": -1,
    "resize(l_u.aP,1,4)\nlink(l_u.aP[3],l_f)": -1,
    "resize(l_u.pGrid,2,2)\nlink(l_u.pGrid[0,1],l_f)": -1,
    'insert(l_u.cP["a"])\nlink(l_u.cP["a"],l_f)': -1,
    'append(u.aP)\ninsert(u.cP["a"])\nl_u=u\nlink(l_u.aP[2],l_f)\nlink(l_u.cP["a"],l_f)\ncall given(u,l_f)': -1,
    "append(u.aP)\nlink(u.aP[2],l_f)": 165,
    "append(u.aP)\nn=position(u.aP[2],world).x": 162,
    "link(l_u.aP[1],l_f)\nu=l_u": 165,
    "append(l_u.aP)\nlink(l_u.aP[2],l_f)\nu=l_u": 165,
    "link(l_u.f,l_f)\naU[1]=l_u": 165,
    "link(l_u.aP[0],f)\nu=l_u\nn=position(u.aP[0],world).x": -1,
    "link(l_p,l_f)\nn=setFrame(l_p,l_q,l_r,u.f)": 165,
    "link(l_p,l_f)\nn=setFrame(l_p,l_q,l_r,l_u.f)": -1,
    "n=setFrame(l_p,l_q,l_r,u.f)\nn=position(u.f,world).x": -1,
    "link(l_p,l_f)\nn=setFrame(l_p,l_q,l_r,f)": -1,
}


def test_what_grows_in_a_user_type_lives_as_long_as_its_variable() -> None:
    """Containers inside local user types grow, too (L4123, L4147); setFrame gives a frame without a reference that of the origin."""
    data = datum("f", "frame", values=value(fatherId="world[0]")) + datum("n", "num") + datum("nCodes", "num", str(len(GROWN)))
    data += "".join(datum(f"u{at}", "Body") for at in range(len(GROWN))) + datum("aU", "Body", "2")
    locals_ = ["frame l_f", "Body l_u", "point l_p", "point l_q", "point l_r"]
    head = "link(l_f,world)\nlink(l_p,f)\nlink(l_q,f)\nlink(l_r,f)\nl_q.trsf.x=10\nl_r.trsf.y=10\n"
    programs: dict[str, Any] = {
        f"v{at}": (locals_, head + re.sub(r"(?<![\w_])u(?=[.=,)]|$)", f"u{at}", code, flags=re.MULTILINE)) for at, code in enumerate(GROWN)
    }
    lines = [f'taskCreate "t{at}",10,v{at}()' for at in range(len(GROWN))] + ["delay(0.1)"]
    lines += [f'nCodes[{at}]=taskStatus("t{at}")' for at in range(len(GROWN))]
    programs["given(Body x_u,frame& x_f)"] = "link(x_u.aP[2],x_f)"
    types = '<Type name="Body" path="body" />'
    result: Any = run(App(data=data, types=types, programs={"start": "\n".join(lines), **programs}), BODY, arm=True, until=1.0)
    assert "globals" in result, result
    assert dict(zip(GROWN, result["globals"]["nCodes"], strict=True)) == GROWN, result["log"]


def test_what_is_saved_hangs_on_the_same_data() -> None:
    lost = datum("p", "point", values=value(fatherId="fGone[0]"))
    app = App(data=DATA + lost, libraries=USES, programs={"start": 'lib:libLoad("cell")\nn=libSave("copy")'})
    made = machine(app, CELL)
    run(app, on=made)
    saved = (made.disk.read("copy/copy.dtx") or b"").decode()
    for father in ("fGrid[1,0]", "fOf[left side]", "lib:fBase[1]", "lib:tHand[0]", "fGone[0]"):
        assert f'fatherId="{father}"' in saved, father
    again = Machine(Disk(dict(made.disk.files)))
    own = again.instance("copy", "copy", "")
    assert own is not None
    point, frame = element(own.data["pGrid"], "0"), element(own.data["fGrid"], "1,0")
    assert isinstance(point, PointV) and point.father is frame is not None


def test_frames_inside_user_types_are_named_and_saved() -> None:
    """What hangs on nothing hangs on nothing again, too, never on world."""
    body = App("body", datum("fBase", "frame") + datum("pAt", "point"))
    inside = "".join(
        f'<Field name="{name}" xsi:type="array" type="{kind}" size="1">{given}</Field>'
        for name, kind, given in (
            ("fBase", "frame", value(x=5, fatherId="world[0]")),
            ("pAt", "point", value(y=2, fatherId="u[1].fBase[0]")),
        )
    )
    data = datum("p", "point", "3", value("0", z=1, fatherId="u[1].fBase[0]") + value("1", fatherId="u[1].pAt[0]"))
    data += datum("u", "Body", "2", f'<Value key="1">{inside}</Value>') + datum("tr", "trsf", "2") + datum("n", "num")
    code = "tr[0]=position(p[0],world)\ntr[1]=position(u[1].pAt,world)\nlink(u[0].fBase,u[1].fBase)\nlink(p[0],u[0].fBase)\np[2]=l_p\n"
    app = App(data=data, types='<Type name="Body" path="body" />', programs={"start": (["point l_p"], code + 'n=libSave("copy")')})
    assert [fault.text for fault in check(app, body)] == ["'p' : fatherId 'u[1].pAt[0]': there is no frame of that name"]
    made = machine(app, body)
    found: Any = run(app, on=made)["globals"]
    assert [(each["x"], each["y"], each["z"]) for each in found["tr"]] == [(5, 0, 1), (5, 2, 0)]
    own = Machine(Disk(dict(made.disk.files))).instance("copy", "copy", "")
    assert own is not None
    points, values = [element(own.data["p"], str(at)) for at in range(3)], [element(own.data["u"], str(at)) for at in range(2)]
    first, second = (element(vars(each)["u_fBase"], "0") for each in values if isinstance(each, UserV))
    assert isinstance(points[0], PointV) and points[0].father is first and isinstance(first, FrameV) and first.father is second
    assert isinstance(points[2], PointV) and points[2].father is None
    lost = points[1]
    assert isinstance(lost, PointV) and lost.father is not None and lost.father.lost == (82, "u[1].pAt[0]")


def test_frames_that_hang_on_each_other_are_named_at_load() -> None:
    ring = "\n".join(value(str(at), fatherId=father) for at, father in enumerate(("f[1]", "g[0]", "f[0]")))
    data = (
        datum("f", "frame", "3", ring) + datum("g", "frame", values=value(fatherId="f")) + datum("t", "tool", values=value(fatherId="t[0]"))
    )
    data += datum("flange", "tool", values=value(fatherId="flange[0]")) + datum("n", "num")
    app = App(data=data, programs={"start": "n=1\nn=position(f[0],world).x"})
    faults = check(app)
    rings = [f"'{name}' : {name}[{key}] refers to itself; using it is error 165" for name, key in (("f", 0), ("f", 1), ("g", 0), ("t", 0))]
    assert [fault.text for fault in faults] == rings and faults.errors == 0, "f[2] hangs on a ring, and is not in it"
    result: Any = run(app)
    assert (result["globals"]["n"], result["tasks"]["demo~"]["status"]) == (1, 165)


def test_a_copy_of_world_or_flange_hangs_on_it() -> None:
    """A frame that is selected with `fUser=world`, and a bare hand with `tHand=flange` (L4844, L4936)."""
    data = datum("f", "frame", "2", value("0", x=5, fatherId="world[0]")) + datum("t", "tool", "1", value(z=9, fatherId="flange[0]"))
    data += datum("p", "point", "1", value(x=1, fatherId="f[0]")) + datum("tr", "trsf", "3") + datum("b", "bool", "3") + datum("n", "num")
    code = (
        "f[0]=world\nf[1]=f[0]\nt=flange\nb[0]=f[1]==world\nb[1]=t==flange\ntr[0]=position(p,world)\ntr[1]=position(f[1],world)\n"
        'tr[2]=position(t,flange)\nlink(f[1],world)\nlink(f[0],f[1])\nn=libSave("copy")'
    )
    found = globals_of(code, data)
    assert found["b"] == [True, True, False]
    transformations = found["tr"]
    assert isinstance(transformations, list)
    assert [(each["x"], each["z"]) for each in transformations] == [(1, 0), (0, 0), (0, 0)]
    assert found["n"] == 0
