"""Bindings, events and prompts of user pages by VAL 3 source (reference 4.1, L2817-3108), and what a page may not bind."""

import json
from typing import Any

import pytest

from gateway.pure.languages.val3.disk import Disk
from gateway.pure.languages.val3.machine import Machine
from gateway.pure.languages.val3.virtual import Run, declare_links
from gateway.pure.languages.val3.virtual_events import event_of
from hil_tests.unit.languages.val3.apps import App, datum, error_of, machine, run, value

DATA = (
    datum("nSpeed", "num", values=value(value=5))
    + datum("sList", "string", "3", value("0", value="one") + value("1", value="two") + value("2", value="three"))
    + datum("sCol", "string", "", value("a", value="x"))
    + datum("bLamp", "bool")
    + datum("doLamp", "dio", values=value(link="Board\\lamp"))
    + datum("aoLevel", "aio", values=value(link="Board\\level"))
    + datum("sState", "string")
    + datum("nState", "num")
    + datum("bYes", "bool", "4")
    + datum("nEntry", "num", values=value(value=3))
    + datum("sEntry", "string")
    + datum("jHere", "joint", values=value(j1=1.5))
)


class Played:
    """An application after its run: globals, what its pages show, its log."""

    def __init__(self, program: str, *events: tuple[float, str], until: float = 5.0, **programs: str) -> None:
        app = App(data=DATA, programs={"start": program, **programs})
        made = machine(app)
        own = made.instance("demo", "demo", "")
        assert own is not None, made.log
        declare_links(made, own.data.values())
        run = Run(made, own, round(until * 1e9), [event_of(str(at), what) for at, what in events])
        run.go()
        found = run.result()["globals"]
        assert isinstance(found, dict)
        self.globals: dict[str, Any] = found
        self.shown, self.log = made.pages.shown(), made.log
        self.tasks = {task.name: task.status for task in made.tasks}


CHANGES = "nSpeed=6\ndelay(1)\nnState=nSpeed\nnSpeed=7"


@pytest.mark.requirement("VAL-UI-02", by="gateway.pure.languages.val3.pages:PageBoard.bind")
@pytest.mark.parametrize(
    ("direction", "shown", "entry", "left"),
    [("r", "7", False, 7), ("w", "40", True, 7), ("rw", "7", True, 7), ("r1", "5", False, 7), ("rw1", "40", True, 7)],
)
def test_directions_of_a_binding(direction: str, shown: str, entry: bool, left: int) -> None:
    program = f'userPageBind("p","o","value",nSpeed,1,"{direction}",1)\n{CHANGES}'
    played = Played(program, (0.5, "page.p.o.value=40"))
    assert played.shown["p"]["o"]["value"] == shown and played.globals["nState"] == (40 if entry else 6)
    assert played.globals["nSpeed"] == left


@pytest.mark.requirement("VAL-UI-02", by="gateway.pure.languages.val3.pages:PageBoard.load")
def test_what_is_read_once_is_read_when_the_page_is_loaded() -> None:
    page = {"demo/interface/p.html": b'<p id="o"></p>'}
    app = App(data=DATA, programs={"start": 'userPageBind("p","o","innerHTML",nSpeed,1,"r1")\nnSpeed=6\nuserPage("p")\nnSpeed=7'})
    made = Machine(Disk({**app.files(), **page}))
    own = made.instance("demo", "demo", "")
    assert own is not None
    Run(made, own, 10**9, []).go()
    assert made.pages.shown()["p"]["o"]["innerHTML"] == "6"


@pytest.mark.requirement("VAL-UI-02", by="gateway.pure.languages.val3.pages:PageBoard._texts")
def test_several_elements_of_an_array_a_field_and_signals_are_bound() -> None:
    program = 'userPageBind("p","s","options",sList[1],2,"r")\nuserPageBind("p","j","innerHTML",jHere.j1,1,"r")\n'
    program += 'userPageBind("p","l","disabled",doLamp,1,"r")\nuserPageBind("p","a","innerHTML",aoLevel,1,"r")\n'
    program += "doLamp=true\naioSet(aoLevel,2.5)"
    assert Played(program).shown["p"] == {
        "s": {"options": "two,three"},
        "j": {"innerHTML": "1.5"},
        "l": {"disabled": "true"},
        "a": {"innerHTML": "2.5"},
    }


@pytest.mark.requirement("VAL-UI-02", by="gateway.pure.languages.val3.pages:PageBoard.bind")
@pytest.mark.parametrize(
    "call",
    [
        'userPageBind("p","o","value",nSpeed,1,"x",1)',
        'userPageBind("p","o","innerHTML",nSpeed,1,"w",1)',
        'userPageBind("p","o","value",sList,4,"r",1)',
        'userPageBind("p","o","value",sCol["a"],2,"r",1)',
        'userPageBind("p","o","value",nSpeed,2,"r",1)',
        'userPageBind("p","o","value",nSpeed,0,"r",1)',
        'userPageBind("p","o","value",nSpeed,1,"r",0)',
        'userPageBind("p","o","onclick",nSpeed,1,"r",1)',
        'userPageSet("p","o","style.left","4px")',
    ],
)
def test_a_binding_that_is_refused_stops_the_task_with_70(call: str) -> None:
    assert error_of(call, DATA) == 70


@pytest.mark.requirement("VAL-UI-02", by="gateway.pure.languages.val3.page_catalogue:doubt")
def test_an_attribute_is_looked_up_by_the_type_of_its_object() -> None:
    page = b'<p id="p1">x</p><input id="i" type="number"><input id="r" type="range"><img id="g"><SELECT id="s"></SELECT><a id="a">y</a>'
    calls = {
        "p1.innerHTML": "", "p1.disabled": "not supported for p", "i.value": "", "i.innerHTML": "not supported for input", "r.max": "",
        "r.style.color": "not supported for range", "g.src": "", "g.value": "not supported for img", "s.options": "", "s.max": "for select",
        "a.href": "", "a.dataset.x": "", "a.style.visibility": "", "none.value": "page p has no object none",
    }  # fmt: skip
    code = "\n".join(f'userPageSet("p","{each.partition(".")[0]}","{each.partition(".")[2]}","1")' for each in calls)
    made = Machine(Disk({**App(data=DATA, programs={"start": f"{code}\n{code}"}).files(), "demo/interface/p.html": page}))
    own = made.instance("demo", "demo", "")
    assert own is not None
    Run(made, own, 10**9, []).go()
    doubts = [line.partition("PAGE:")[2] for line in made.log if "PAGE:" in line]
    wanted = [words for words in calls.values() if words]
    assert len(doubts) == len(wanted), doubts
    assert all(words in doubt for words, doubt in zip(wanted, doubts, strict=True)), doubts


@pytest.mark.requirement("VAL-UI-03", by="gateway.pure.languages.val3.pages:PageBoard.happen")
def test_events_set_and_toggle_variables_of_each_type() -> None:
    program = """userPageBindMousedown("p","b",sState,"PUSHED")
userPageBindMouseup("p","b",sState,"RELEASED")
userPageBindClick("p","b",nState,4)
userPageBindClick("p","b",bLamp)
userPageBindClick("p","b",doLamp)
userPageBindClick("p","b",aoLevel,1.5)
userPageBindClick("q","b",bYes[0],true)
delay(1)
bYes[1]=userPageUnbindClick("p","b",bLamp)
bYes[2]=userPageUnbindClick("p","b",bLamp)
delay(1)"""
    down, click, up = (0.1, "page.p.b=mousedown"), (0.2, "page.p.b=click"), (0.3, "page.p.b=mouseup")
    found = Played(program, down).globals
    assert (found["sState"], found["nState"], found["bLamp"]) == ("PUSHED", 0, False)
    found = Played(program, down, click, up).globals
    assert (found["sState"], found["nState"], found["bLamp"], found["doLamp"], found["aoLevel"]) == ("RELEASED", 4, True, True, 1.5)
    found = Played(program, click, (0.5, "page.p.b=click"), (1.5, "page.p.b=click")).globals
    assert (found["bLamp"], found["doLamp"], found["bYes"]) == (False, True, [False, True, False, False])


@pytest.mark.requirement("VAL-UI-04", by="gateway.pure.languages.val3.pages:PageBoard.put")
def test_user_page_set_is_done_once() -> None:
    program = """sState="hidden"
userPageSet("index","o","style.visibility",sState)
sState="visible"
userPageSet("index","o","disabled",true)
userPageSet("index","o","innerHTML",12.25)
delay(1)"""
    assert Played(program).shown["index"]["o"] == {"style.visibility": "hidden", "disabled": "true", "innerHTML": "12.25"}


@pytest.mark.requirement("VAL-UI-05", by="gateway.pure.languages.val3.builtin_pages:f_user_page_confirm")
def test_prompts_wait_for_the_operator_and_return_his_answer() -> None:
    program = """bYes[0]=userPageConfirm("go on?")
nState=1
bYes[1]=userPageConfirm("really?")
bYes[2]=userPagePrompt("part",sEntry)
bYes[3]=userPagePrompt("number",nEntry)
nState=2"""
    found = Played(program, (1, "answer=ok"), (2, "answer=cancel"), (3, "answer=ok:part 7"), (4, "answer=cancel")).globals
    assert (found["bYes"], found["sEntry"], found["nEntry"], found["nState"]) == ([True, False, True, False], "part 7", 3, 2)
    assert Played(program, (9, "answer=ok"), until=0.5).globals["nState"] == 0, "it waits"


@pytest.mark.requirement("VAL-UI-05", by="gateway.pure.languages.val3.builtin_pages:f_user_page_prompt")
def test_an_entry_is_of_the_type_of_its_variable() -> None:
    program = 'bYes[0]=userPagePrompt("number",nEntry)\nnState=2'
    found = Played(program, (1, "answer=ok:many"), (2, "answer=ok:-12.5")).globals
    assert (found["nEntry"], found["nState"], found["bYes"][0]) == (-12.5, 2, True)
    found = Played(program, (1, "answer=ok:many"), (2, "answer=cancel")).globals
    assert (found["nEntry"], found["nState"], found["bYes"][0]) == (3, 2, False)


@pytest.mark.requirement("VAL-UI-05", by="gateway.pure.languages.val3.builtin_pages:f_user_page_prompt")
@pytest.mark.parametrize("entry", ["nan", "-inf", "1e999", "1_0", "\u0663"])
def test_an_entry_that_no_num_holds_is_asked_for_again(entry: str) -> None:
    found = Played('bYes[0]=userPagePrompt("number",nEntry)', (1, f"answer=ok:{entry}"), (2, "answer=ok:4")).globals
    assert (found["nEntry"], found["bYes"][0]) == (4, True)
    program = 'userPageBind("p","o","value",nSpeed,1,"rw",1)\nuserPageBind("p","t","value",sEntry,1,"w",1)\ndelay(1)'
    found = Played(program, (0.1, f"page.p.o.value={entry}"), (0.2, f"page.p.t.value={'x' * 200}")).globals
    assert (found["nSpeed"], len(found["sEntry"])) == (5, 128)


@pytest.mark.requirement("VAL-UI-03", by="gateway.pure.languages.val3.pages:PageBoard.ignore")
def test_events_of_each_type_are_unbound() -> None:
    program = """userPageBindMousedown("p","b",sState,"PUSHED")
userPageBindMouseup("p","b",nState,4)
userPageBindClick("p","b",aoLevel,1.5)
bYes[0]=userPageUnbindMousedown("p","b",sState)
bYes[1]=userPageUnbindMouseup("p","b",nState)
bYes[2]=userPageUnbindClick("p","b",aoLevel)
bYes[3]=userPageUnbindClick("p","b",aoLevel)
delay(1)"""
    found = Played(program, (0.1, "page.p.b=mousedown"), (0.2, "page.p.b=mouseup"), (0.3, "page.p.b=click")).globals
    assert (found["bYes"], found["sState"], found["nState"], found["aoLevel"]) == ([True, True, True, False], "", 0, 0)


@pytest.mark.requirement("VAL-UI-01", by="gateway.pure.languages.val3.builtin_pages:f_user_page")
def test_a_page_is_found_by_a_path_too() -> None:
    pages = dict.fromkeys(
        ("demo/interface/a.html", "demo/pages/b.html", "other/interface/c.html", "d.html", "demo/interface/sub/e.html"), b"<p></p>"
    )
    calls = {
        "a": 0, "./interface/a": 0, "./pages/b": 0, "../other/interface/c": -1, "./../other/interface/c": 0, "Disk://other/interface/c": 0,
        "Disk://d": 0, "sub/e": 0, "b": -1, "../../x": -1, "USB0://a": -1, "": -1,
    }  # fmt: skip
    code = "\n".join(f'n[{at}]=userPage("{name}")' for at, name in enumerate(calls))
    app = App(data=datum("n", "num", str(len(calls))), programs={"start": code})
    found = run(app, on=Machine(Disk({**app.files(), **pages})))["globals"]
    assert isinstance(found, dict) and found["n"] == list(calls.values())


@pytest.mark.requirement("VAL-UI-02", by="gateway.pure.languages.val3.pages:PageBoard.rows")
def test_what_cannot_be_read_or_written_any_more_is_shown_empty_and_logged() -> None:
    data = datum("dX", "dio") + datum("aX", "aio") + datum("diIn", "dio", values=value(link="BasicIO-1\\%I0"))
    binds = 'userPageBind("p","d","innerHTML",dX,1,"r")\nuserPageBind("p","a","value",aX,1,"rw")\n'
    binds += 'userPageBind("p","k","innerHTML",sCol["a"],1,"r")\nuserPageBind("p","s","options",sList,3,"r1")\n'
    binds += 'userPageBindClick("p","d",dX)\nuserPageBindClick("p","i",diIn,true)\nuserPageBindClick("p","e",sList[2],"x")\n'
    code = binds + 'delete(sCol["a"])\ndelete(sList[2])\nnState=1\ndelay(1)'
    app = App(data=DATA + data, programs={"start": code})
    made = machine(app)
    own = made.instance("demo", "demo", "")
    assert own is not None
    declare_links(made, own.data.values())
    events = ["page.p.d=click", "page.p.i=click", "page.p.e=click", "page.p.a.value=3"]
    Run(made, own, 10**9, [event_of("0.5", each) for each in events]).go()
    assert made.pages.rows("p") == [
        ["s", "options", "one"], ["s", "options", "two"], ["s", "options", "three"], ["d", "innerHTML", ""], ["a", "value", ""],
        ["k", "innerHTML", ""],
    ]  # fmt: skip
    logged = [line.partition("PAGE:")[2] for line in made.log if "PAGE:" in line]
    assert [line.rpartition(": ")[2].split(" (")[0] for line in logged] == [
        "variable not linked to a system input or output",
        "write to a system input",
        "the element does not exist any more",
        "the entry '3' is not taken",
    ]


@pytest.mark.requirement("VAL-UI-05", by="gateway.pure.languages.val3.builtin_pages:_asked")
def test_an_answer_is_that_of_the_prompt_which_is_shown() -> None:
    """Tasks take their turns in the order of their creation, prompts in the order in which they were asked."""
    late = 'delay(0.5)\nbYes[1]=userPagePrompt("B?",sEntry)\nnEntry=clock()'
    early = 'bYes[0]=userPageConfirm("A?")\nnState=clock()'
    answers = ((1.0, "answer=cancel"), (2.0, "answer=ok:xx"))
    found = Played('taskCreate "b",10,late()\ntaskCreate "a",10,early()', *answers, late=late, early=early).globals
    assert (found["bYes"][:2], found["sEntry"], found["nState"], found["nEntry"]) == ([False, True], "xx", 1, 2)


def test_bindings_in_the_file_beside_a_page() -> None:
    """As the editor of s8.15 writes it (AX-1852)."""

    def row(name: str, data: str, **more: object) -> dict[str, object]:
        return {"id": name, "attribute": "innerHTML", "data": data, "size": 1, "direction": "r", "refresh": 1, **more}

    rows = [row("speed", "nSpeed[0]"), row("second", "sList[1]"), row("col", "sCol[a]"), row("hand", "jHere.j1"), row("lib", "l:nOut[1]")]
    wrong = [row("gone", "nGone"), row("id", "nSpeed", attribute="id"), row("far", "sList[9]"), row("hidden", "l:nHidden"), 5]
    page = b"<p id='speed'></p><p id='second'></p>"
    lib = App("lib", datum("nOut", "num", "2", value("1", value=8)) + datum("nHidden", "num", access="private"))
    app = App(
        data=DATA,
        libraries='<Library alias="l" path="Disk://lib/lib.pjx" autoload="true" />',
        programs={"start": 'userPageBind("p","second","innerHTML",sState,1,"r")\nuserPage("p")\nnSpeed=6\nuserPage("p")'},
    )
    for text, shown, said in (
        (json.dumps({"version": "1.0", "bindings": [*rows, *wrong], "callbacks": [], "events": [{}]}), True, 5),
        ("{", False, 1),
        ('{"bindings": 5}', False, 1),
    ):
        files = {"demo/interface/p.html": page, "demo/interface/p.bindings.json": text.encode()}
        made = Machine(Disk({**app.files(), **lib.files(), **files}))
        own = made.instance("demo", "demo", "")
        assert own is not None
        Run(made, own, 10**9, []).go()
        found = {name: each["innerHTML"] for name, each in made.pages.shown()["p"].items()}
        assert found == {"second": ""} | ({"speed": "6", "col": "x", "hand": "1.5", "lib": "8"} if shown else {})
        assert sum("p.bindings.json" in line for line in made.log) == 2 * said, made.log
