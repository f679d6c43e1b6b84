"""The operator of an application in a cell: state, variables, user page, prompts (AX-993)."""

import pathlib
from dataclasses import replace
from typing import Any

import pytest

from gateway.web.val3_pages import clean, image_of, page_of
from hil_tests.lab.virtual.val3_cell_bench import Val3Cell
from hil_tests.unit.languages.val3.apps import App, datum, value

PAGE = '<html><body><p id="count">0</p><button id="go">Go</button><input id="wish"></body></html>'
DATA = datum("nCount", "num") + datum("bGo", "bool") + datum("nWish", "num", values=value(value=7)) + datum("sName", "string")
DATA += datum("bYes", "bool") + datum("bSure", "bool")
START = """userPageBind("menu","count","innerHTML",nCount,1,"r",1)
userPageBind("menu","wish","value",nWish,1,"rw",1)
userPageBindClick("menu","go",bGo)
userPage("menu")
popUpMsg("ready")
title("Menu")
put("press go")
wait(bGo)
nCount=nWish
bSure=userPageConfirm("Sure?")
bYes=userPagePrompt("Name?",sName)
wait(nCount==99)"""


def cell(*, operator: bool) -> Val3Cell:
    """The application runs and has shown its page."""
    files = App("menu", DATA, {"start": START}).files() | {"menu/interface/menu.html": PAGE.encode()}
    made = Val3Cell(files, "menu")
    made.language.setup = replace(made.language.setup, operator=operator)
    made.start()
    made.until(lambda: state(made).get("page") == "menu")
    return made


def state(made: Val3Cell) -> dict[str, Any]:
    """As the page is told."""
    rows = made.programs.answer({"do": "view"}, 0).get("val3")
    return rows[0] if isinstance(rows, list) and rows else {}


def seen(made: Val3Cell, what: str) -> list[Any]:
    found = made.programs.answer({"do": "view"}, 0).get(what)
    return found if isinstance(found, list) else []


def act(made: Val3Cell, **facts: object) -> dict[str, object]:
    return made.programs.answer({"do": "act", **facts}, 0)


@pytest.mark.requirement("VAL-UI-01", by="gateway.pure.languages.val3.cell_view:seen")
def test_a_user_page_shows_and_sets_variables_and_prompts_wait() -> None:
    made = cell(operator=True)
    found = state(made)
    assert (found["mode"], found["folder"], found["title"], found["kind"]) == ("remote", "menu", "Menu", "")
    assert seen(made, "popups") == ["ready"] and seen(made, "screen") == ["press go"]
    assert act(made, act="key", value="x") == {"ok": True} and act(made, act="key", value="no key") == {"ok": True}
    made.bench.run(0.05)
    assert made.language.machine is not None and list(made.language.machine.screen.keys) == [120.0]
    assert ["count", "innerHTML", "0"] in seen(made, "shown") and ["wish", "value", "7"] in seen(made, "shown")
    assert ["nWish", "num", "7"] in seen(made, "variables")
    assert act(made, act="enter", what="wish", value="12") == {"ok": True}
    made.until(lambda: ["wish", "value", "12"] in seen(made, "shown"))
    act(made, act="event", what="go", value="click")
    made.until(lambda: state(made)["kind"] == "confirm")
    assert state(made)["prompt"] == "Sure?" and made.value("nCount") == 12
    act(made, act="answer", value="ok")
    made.until(lambda: state(made)["kind"] == "prompt")
    act(made, act="answer", value="ok:Box 4")
    made.until(lambda: state(made)["kind"] == "")
    assert (made.value("sName"), made.value("bYes"), made.value("bSure")) == ("Box 4", True, True)
    run = made.hosted.run
    act(made, act="set", what="nCount", value="99")
    assert made.ends(run)[0] == "ended" and seen(made, "val3") == []


def test_values_are_written_as_val3_writes_them() -> None:
    joint = datum("jHome", "joint", "1", value(j1=0.123456789, j2=-40, j3=100, j5=60))
    point = datum("pPick", "point", "1", value(x=357.0927397080325, z=-0.00001, rz=150, shoulder="lefty", fatherId="world[0]"))
    more = (
        joint
        + point
        + datum("mSlow", "mdesc", "1", value(vel=30, blend="off"))
        + datum("sPart", "string", "2", values=value("0", value="a b"))
    )
    made = Val3Cell(App("menu", more, {"start": "wait(false)"}).files(), "menu")
    made.start()
    made.until(lambda: bool(seen(made, "variables")))
    shown = {name: text for name, _, text in seen(made, "variables")}
    assert shown["jHome"] == "{0.1235, -40, 100, 0, 60, 0}"
    assert shown["pPick"].startswith("{trsf = {357.0927, 0, 0, 0, 0, 150}, config = {lefty, ")
    assert "vel = 30, " in shown["mSlow"] and 'blend = "off"' in shown["mSlow"]
    assert shown["sPart"] == '["a b", ""]'


def test_without_an_operator_prompts_are_answered_at_once() -> None:
    made = cell(operator=False)
    act(made, act="event", what="go", value="click")
    made.until(lambda: made.value("bSure") is True)
    made.bench.run(0.1)
    assert (made.value("bYes"), state(made)["kind"]) == (False, "")


def test_hold_and_what_is_refused() -> None:
    made = cell(operator=True)
    act(made, act="hold", on=True)
    made.until(lambda: state(made)["hold"] is True)
    act(made, act="hold", on=False)
    made.until(lambda: state(made)["hold"] is False)
    for facts, words in (
        ({"act": "set", "what": "nothing", "value": "1"}, "there is no global of that name"),
        ({"act": "set", "what": "nCount", "value": "many"}, "a number, true or false is expected"),
        ({"act": "set", "what": "nCount", "value": "nan"}, "nCount=nan: a number"),
        ({"act": "enter", "what": "count", "value": "5"}, "is not taken"),
        ({"act": "answer", "value": "ok"}, "no prompt waits"),
        ({"act": "event", "what": "go", "value": "hover"}, "there are mouseup, mousedown, click"),
    ):
        act(made, **facts)
        made.bench.run(0.05)
        assert any(words in each for each in made.words), words
    assert "error" in act(made, act="jump") and made.value("nCount") == 0
    for _ in range(10_000):
        answer = act(made, act="event", what="go", value="mouseup")
    assert answer == {"error": "too many at once; try again"} and len(made.hosted.orders) <= 200


@pytest.mark.requirement("VAL-ROB-02", by="gateway.pure.languages.val3.cell_run:CellRun.hear")
def test_mode_and_monitor_speed_are_set_by_the_operator() -> None:
    data = DATA + datum("nMode", "num") + datum("nSpeed", "num") + datum("nCode", "num")
    loop = "enablePower()\nwhile true\nnMode=workingMode()\nnSpeed=getMonitorSpeed()\ndelay(0)\nendWhile"
    made = Val3Cell(App("menu", data, {"start": loop, "menu": ""}).files(), "menu")
    made.start()
    made.until(lambda: made.language.own is not None and made.value("nMode") == 4.0)
    for name, mode in (("manual", 1.0), ("test", 2.0), ("local", 3.0), ("remote", 4.0)):
        assert act(made, act="mode", value=name) == {"ok": True}
        made.bench.run(0.1)
        assert made.value("nMode") == mode
    made.until(lambda: made.value("nSpeed") == 100.0)
    assert act(made, act="speed", value="35") == {"ok": True}
    made.until(lambda: made.value("nSpeed") == pytest.approx(35.0), 2.0)
    made.until(lambda: state(made)["speed"] == pytest.approx(35.0), 1.0)
    for facts, words in (
        ({"act": "mode", "value": "fast"}, "manual, test, local, remote are known"),
        ({"act": "speed", "value": "101"}, "0 to 100 is expected"),
        ({"act": "speed", "value": "x"}, "0 to 100 is expected"),
        ({"act": "ratio", "value": "1.5"}, "1 to 250 is expected"),
    ):
        assert words in str(act(made, **facts)["error"])


def test_an_application_that_does_not_run_is_not_operated() -> None:
    made = Val3Cell(App("menu", DATA, {"start": START}).files(), "menu")
    assert act(made, act="connect") == {"error": "no application runs"} and state(made) == {}


@pytest.mark.parametrize(
    ("given", "kept"),
    [
        ('<p id="a" onclick="x()">1 &lt; 2</p>', '<p id="a">1 &lt; 2</p>'),
        ("<script>alert(1)</script><b>x</b>", "<b>x</b>"),
        ("<SCRIPT src=//evil></SCRIPT>y", "y"),
        ('<a href="https://elsewhere/">z</a><a href="#top">t</a>', '<a>z</a><a href="#top">t</a>'),
        ('<a href="java&#115;cript:x()">z</a>', "<a>z</a>"),
        ('<img src="http://elsewhere/a.png"><img src="a.png">', '<img><img src="data:image/png;base64,aW1n">'),
        ('<img src="../secret.png">', "<img>"),
        ('<div style="background:url(http://x)">d</div>', '<div style="">d</div>'),
        ("<style>@import 'http://x'; p{}</style>", "<style></style>"),
        ("<style>p{color:red}</style>", "<style>p{color:red}</style>"),
        ('<link rel="stylesheet" href="s.css"><link rel="stylesheet" href="http://x/s.css">', "<style>p{}</style>"),
        ('<iframe srcdoc="<script>1</script>">i</iframe><object data="x">o</object>q', "q"),
        ("<svg onload=x()><script>1</script></svg>r", "r"),
        ('<meta http-equiv="refresh" content="0;url=http://x"><base href="http://x">s', "s"),
        ("<form action='http://x'><input name='n' value='\"'></form>", '<form><input name="n" value="&quot;"></form>'),
        ("<!-- a --><script", "&lt;script"),
        ('<b style="background: URL( a.png ) no-repeat">x</b>', '<b style="background: url(data:image/png;base64,aW1n) no-repeat">x</b>'),
        ("<style>p{background:url('no.png');scroll-behavior:smooth}</style>", "<style>p{background:none;scroll-behavior:smooth}</style>"),
        ('<style>p{background:url("a.png), url(http://x)}</style>', "<style></style>"),
        ("<style>p{behavior:url(a.png)}</style><p style='background:image-set(\"//x\")'>", '<style></style><p style="">'),
        ('<link rel="stylesheet" href="css/t.css">', "<style>p{background:url(data:image/png;base64,aW1n)}</style>"),
    ],
)
def test_a_page_is_cleaned(given: str, kept: str) -> None:
    files = {"a.png": b"img", "s.css": b"p{}", "css/t.css": b"p{background:url('../a.png')}", "css/../a.png": b"img"}
    assert clean(given, files.get) == kept


def test_a_page_is_read_from_its_interface_folder_only(tmp_path: Any) -> None:
    interface = tmp_path / "usrapp" / "app" / "interface"
    interface.mkdir(parents=True)
    (interface / "menu.html").write_text('<img src="a.png"><img src="../../../x.png">')
    (interface / "a.png").write_bytes(b"img")
    (tmp_path / "x.png").write_bytes(b"no")
    (tmp_path / "x.html").write_text("no")
    assert page_of(tmp_path / "usrapp", "app", "menu") == '<img src="data:image/png;base64,aW1n"><img>'
    assert page_of(tmp_path / "usrapp", "app", "../../../x") is None and page_of(tmp_path / "usrapp", "../..", "x") is None
    assert page_of(tmp_path / "usrapp", "app", "none") is None


def test_a_page_named_by_a_path_is_shown(tmp_path: pathlib.Path) -> None:
    for path, text in (("menu/interface/a.html", "A"), ("menu/pages/b.html", "B"), ("shared/c.html", "C")):
        (tmp_path / "disk" / path).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / "disk" / path).write_text(text)
    (tmp_path / "out.html").write_text("secret")
    names = ("a", "./pages/b", "Disk://shared/c", "Disk://../out", "../out", "../../../out")
    assert [page_of(tmp_path / "disk", "menu", name) for name in names] == ["A", "B", "C", None, None, None]


def test_files_of_a_page_are_found_beside_it_in_any_case(tmp_path: pathlib.Path) -> None:
    """As on the controller, whose disk compares names without case; a page in a sub-folder has its images beside it."""
    for path in ("menu/interface/Main.html", "menu/interface/sub/e.html"):
        (tmp_path / path).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / path).write_text('<img src="My%20Lamp.PNG"><img src="../top.png">')
    for path in ("menu/interface/my lamp.png", "menu/interface/sub/my lamp.png", "menu/interface/top.png", "menu/top.png"):
        (tmp_path / path).write_bytes(path.encode()[-12:-4])
    beside, above = '<img src="data:image/png;base64,L215IGxhbXA=">', '<img src="data:image/png;base64,'
    assert page_of(tmp_path, "MENU", "main") == beside + "<img>", "nothing above the interface"
    assert (page_of(tmp_path, "menu", "sub/E") or "").startswith(beside + above)
    assert image_of(tmp_path, "menu", "main", "MY LAMP.png") == "data:image/png;base64,L215IGxhbXA="
    assert [image_of(tmp_path, "menu", "main", each) for each in ("../top.png", "main.html", "no.png", "http://x/a.png")] == [None] * 4
