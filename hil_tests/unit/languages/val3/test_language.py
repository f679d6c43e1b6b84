"""The language: statements, operators, containers, parameters.  Source: VAL 3 reference 2-3."""

from typing import Any

import pytest

from hil_tests.unit.languages.val3.apps import App, check, datum, error_of, faults_of, globals_of, run, value

NUMS = "".join(datum(name, "num") for name in ("n", "i", "j", "k", "m"))
T = "gateway.pure.languages.val3.translate:ProgramTranslator."
X = "gateway.pure.languages.val3.expressions:Translator."
DAYS = """
if sDay=="Monday"
  nDay=1
elseif sDay=="Tuesday"
  nDay=2
elseIf sDay=="Wednesday"
  nDay=3
else
  // Weekend !
  nDay=0
endif"""
MENU = """
switch nMenu
  case 271
    s = "Menu 1"
  break
  case 273, 274, 275, 276, 277, 278
    s = "Menu 3 to 8"
  break
  default
    s = "this key is not a menu key"
  break
endSwitch"""


@pytest.mark.requirement("VAL-LANG-01", by=T + "translate")
def test_comments_are_at_the_beginning_of_a_line() -> None:
    assert globals_of("// This is an example of a comment\n  // n=7\nn=1", NUMS)["n"] == 1
    assert faults_of('n=len("//")\nn=1 // x', NUMS) == [(3, "'// x' : comment not at the begin of the line")]


@pytest.mark.requirement("VAL-LANG-02", by=X + "parameters")
def test_arguments_are_evaluated_from_left_to_right_before_the_locals_are_made() -> None:
    data = NUMS + datum("a", "num", "4")
    app = App(
        data=data,
        programs={
            "start": "call p(i,i)\ncall p(j,k)\nm=a[1]",
            "p(num x_a, num x_b)": (["num l_n"], "a[0]=a[0]+l_n\nl_n=5\na[1]=a[1]+1"),
        },
    )
    found = run(app)["globals"]
    assert isinstance(found, dict) and found["m"] == 2 and found["a"] == [0, 2, 0, 0]


@pytest.mark.requirement("VAL-LANG-03", by=T + "_do_return")
def test_return_leaves_the_program() -> None:
    found = globals_of('call p()\nn=n+1\ntaskCreate "t", 10, p()\ndelay(0.1)\ni=taskStatus("t")', NUMS, p="n=n+10\nreturn\nn=1000")
    assert (found["n"], found["i"]) == (21, -1)


@pytest.mark.requirement("VAL-LANG-04", by=T + "_do_elseif")
@pytest.mark.parametrize(("day", "number"), [("Monday", 1), ("Wednesday", 3), ("Sunday", 0)])
def test_only_the_first_true_branch_runs(day: str, number: int) -> None:
    data = datum("sDay", "string", values=value(value=day)) + datum("nDay", "num", values=value(value=9))
    assert globals_of(DAYS, data)["nDay"] == number


@pytest.mark.requirement("VAL-LANG-05", by=T + "_do_until")
def test_while_tests_before_and_until_behind_the_body() -> None:
    found = globals_of("while false\ni=i+1\nendWhile\ndo\nj=j+1\nuntil true\nwhile k<3\nk=k+1\nendWhile", NUMS)
    assert (found["i"], found["j"], found["k"]) == (0, 1, 3)


@pytest.mark.requirement("VAL-LANG-06", "VAL-LANG-07", by=T + "_do_for")
def test_for_counts_up_and_down_and_may_run_no_pass() -> None:
    code = "for n = 90 to -90 step -10\nif i==0\nj=n\nendIf\nk=n\ni=i+1\nendFor\nfor m=5 to 1\ni=i+100\nendFor"
    found = globals_of(code, NUMS)
    assert (found["i"], found["j"], found["k"], found["n"], found["m"]) == (19, 90, -90, -100, 5)
    assert globals_of("for n=0 to 3\nendFor\nfor i=1 to 8\nj=j+1\nendFor", NUMS) | {"m": 0} == {"n": 4, "i": 9, "j": 8, "k": 0, "m": 0}
    assert error_of("for n=1 to 3 step i\nendFor", NUMS) == 70


@pytest.mark.requirement("VAL-LANG-08", "VAL-LANG-09", by=T + "_do_case")
@pytest.mark.parametrize(("key", "text"), [(271, "Menu 1"), (275, "Menu 3 to 8"), (300, "this key is not a menu key")])
def test_switch_takes_the_first_matching_case(key: int, text: str) -> None:
    data = datum("nMenu", "num", values=value(value=key)) + datum("s", "string")
    assert globals_of(MENU, data)["s"] == text
    strings = 'switch s\ncase "Menu"\nn=1\nbreak\ncase "Friday", "Saturday"\nn=5\nbreak\nendSwitch'
    assert globals_of(strings, datum("s", "string", values=value(value="Saturday")) + NUMS)["n"] == 5


def test_a_case_without_break_runs_on() -> None:
    assert globals_of("switch n\ncase 0\ni=1\ncase 1\nj=1\nbreak\ncase 2\nk=1\nbreak\nendSwitch", NUMS)["j"] == 1


@pytest.mark.requirement("VAL-LANG-10", "VAL-LANG-12", by="gateway.pure.languages.val3.value_expressions:ValueTranslator.assign")
def test_an_assignment_is_an_expression() -> None:
    data = NUMS + datum("tr", "trsf") + datum("b1", "bool") + datum("b2", "bool", values=value(value="true"))
    found = globals_of("n=5\ntr.rx = tr.ry = tr.rz = n\ni = j = 3\nif(b1=b2)\nk=1\nendIf", data)
    assert found["tr"] == {"x": 0, "y": 0, "z": 0, "rx": 5, "ry": 5, "rz": 5}
    assert (found["i"], found["j"], found["k"], found["b1"]) == (3, 3, 1, True)


@pytest.mark.requirement("VAL-LANG-11", by=X + "invoke")
def test_an_assignment_is_no_parameter() -> None:
    faults = faults_of('n=cos(i=30)\nn=len(s="hello wild world")', NUMS + datum("s", "string"))
    assert faults == [
        (2, "'i=30' : assignment not allowed in a parameter"),
        (3, "'s=\"hello wild world\"' : assignment not allowed in a parameter"),
    ]


@pytest.mark.requirement("VAL-LANG-13", by="gateway.pure.languages.val3.syntax:Expressions._binary")
def test_bool_operators_stop_early_and_keep_their_priorities() -> None:
    data = "".join(datum(f"b{at}", "bool") for at in range(5)) + datum("x", "num")
    code = "b0=(true) or (x[99]==0)\nb1=true or false and false\nb2=!true==false\nb3=true xor true\nb4=(false) and (x[99]==0)"
    found = globals_of(code, data)
    assert [found[f"b{at}"] for at in range(5)] == [True, True, True, False, False]


@pytest.mark.requirement("VAL-LANG-14", "VAL-LANG-15", by="gateway.pure.languages.val3.syntax:Expressions._binary")
def test_arithmetic_groups_to_the_left() -> None:
    found = globals_of("j=5\ni=2\nn=j-i+1\nk=-7%3\nm=2+3*4/2", NUMS)
    assert (found["n"], found["k"], found["m"]) == (4, -1, 8)
    assert globals_of("n=7%3", NUMS)["n"] == 1
    assert [error_of("n=1%0", NUMS), error_of("n=1/i", NUMS)] == [10, 10]


@pytest.mark.requirement("VAL-LANG-16", by="gateway.pure.languages.val3.tasks:Task.enter")
def test_programs_are_reentrant() -> None:
    program = (["num l_n"], "if x_n<=1\nx_r=1\nelse\nl_n=x_n\ncall f(x_n-1, x_r)\nx_r=x_r*l_n\nendIf")
    app = App(
        data=NUMS,
        programs={"start": 'taskCreate "t", 1, f(4, i)\ncall f(5, n)\nwait(taskStatus("t")==-1)', "f(num x_n, num& x_r)": program},
    )
    found = run(app)["globals"]
    assert isinstance(found, dict) and (found["n"], found["i"]) == (120, 24)


@pytest.mark.requirement("VAL-LANG-17", by="gateway.pure.languages.val3.scope:Scope.variable")
def test_a_local_hides_a_global() -> None:
    app = App(data=NUMS, programs={"start": (["num n"], "n=5\ni=n\ncall p()"), "p": "j=n"})
    found = run(app)["globals"]
    assert isinstance(found, dict) and (found["n"], found["i"], found["j"]) == (0, 5, 0)


STRINGS = datum("sMessage", "string", values=value(value="m")) + datum("sArray", "string", "30") + datum("sGrid", "string", "3,4")
STRINGS += datum("sColl", "string", "", value("k", value="c"))


@pytest.mark.requirement("VAL-LANG-18", "VAL-LANG-19", by=X + "_passed")
def test_values_are_copied_and_references_are_not() -> None:
    calls = 'call send(sArray[23])\ncall refer(sMessage)\ncall refer(sArray[24])\ncall refer(sGrid[1,2])\ncall refer(sColl["k"])'
    app = App(data=STRINGS, programs={"start": calls, "send(string x_s)": 'x_s="changed"', "refer(string& x_s)": 'x_s="new"'})
    found = run(app)["globals"]
    assert isinstance(found, dict)
    assert (found["sMessage"], found["sArray"][23:25], found["sGrid"][1], found["sColl"]) == (
        "new",
        ["", "new"],
        ["", "", "new", ""],
        {"k": "new"},
    )
    programs = {"start": 'call refer("Waiting")\ncall refer("a"+sMessage)', "refer(string& x_s)": ""}
    texts = [(fault.position.line, fault.text) for fault in check(App(data=STRINGS, programs=programs))]
    assert texts == [(2, "'\"Waiting\"' : variable expected as parameter"), (3, "'\"a\"+sMessage' : variable expected as parameter")]


@pytest.mark.requirement("VAL-LANG-20", by=X + "_container")
def test_part_of_an_array_and_containers_by_reference() -> None:
    data = STRINGS + datum("n", "num") + datum("i", "num")
    programs = {
        "start": "call one(sArray[23])\ncall two(sGrid)\ncall coll(sColl)\ncall one(sArray)",
        "one(string& x_s[])": 'x_s[0]="first"\nn=n+size(x_s)',
        "two(string& x_s[,])": 'x_s[2,3]="last"\ni=size(x_s,2)',
        'coll(string& x_s[""])': 'x_s["k"]="new"',
    }
    found = run(App(data=data, programs=programs))["globals"]
    assert isinstance(found, dict)
    assert (found["sArray"][0], found["sArray"][23], found["n"], found["i"]) == ("first", "first", 37, 4)
    assert (found["sGrid"][2][3], found["sColl"]) == ("last", {"k": "new"})


@pytest.mark.parametrize(
    ("call", "text"),
    [
        ('one("Waiting")', "array variable expected as parameter"),
        ("one(sColl)", "1d array variable expected"),
        ("one(sGrid[1,2])", "1d array variable expected"),
        ("coll(sMessage)", "collection variable expected"),
        ("two(sGrid[1,2])", "unexpected indices for the array"),
        ('coll(sColl["k"])', "unexpected indices for the collection"),
    ],
)
def test_containers_that_do_not_match_are_named(call: str, text: str) -> None:
    programs = {"start": f"call {call}", "one(string& x_s[])": "", "two(string& x_s[,])": "", 'coll(string& x_s[""])': ""}
    (fault,) = check(App(data=STRINGS, programs=programs))
    assert fault.text.endswith(f" : {text}") and fault.position.line == 2


@pytest.mark.requirement("VAL-LANG-21", by="gateway.pure.languages.val3.value_expressions:ValueTranslator._literal")
def test_structures_are_written_by_field() -> None:
    data = datum("p", "point") + datum("q", "point") + datum("j", "joint")
    found = globals_of("p={{100,-50,200,0,0,0},{sfree,efree,wfree}}\nq.trsf={100,-50,200, , ,}\nj={1,2,3,4,5,6}", data)
    assert found["p"] == {
        "trsf": {"x": 100, "y": -50, "z": 200, "rx": 0, "ry": 0, "rz": 0},
        "config": {"shoulder": "sfree", "elbow": "efree", "wrist": "wfree"},
    }
    assert isinstance(found["q"], dict) and found["q"]["trsf"]["z"] == 200 and isinstance(found["j"], dict) and found["j"]["j6"] == 6


@pytest.mark.requirement("VAL-LANG-22", by="gateway.pure.languages.val3.syntax:tokens")
def test_numbers_and_names() -> None:
    data = datum("n1_a", "num") + datum("m", "num", "4")
    found = globals_of("n1_a=1e3\nm[0]=1e-2\nm[1]=6.02214179e23\nm[2]=-3.141592653", data)
    assert (found["n1_a"], found["m"]) == (1000, [0.01, 6.02214179e23, -3.141592653, 0])
    assert faults_of("1a=1", data) == [(2, "'1a' : invalid name")] and faults_of("_a=1", data) == [(2, "'_a' : invalid name")]


CONTAINERS = NUMS + datum("a", "num", "10") + datum("g", "num", "6,8") + datum("c", "num", "", value("b", value=2) + value("a", value=1))


@pytest.mark.requirement("VAL-VAR-01", "VAL-VAR-03", by="gateway.pure.languages.val3.values:rounded")
def test_indices_are_rounded_and_an_element_is_an_array_of_one() -> None:
    found = globals_of("g[5.01, 6.99]=3\na[2.4]=7\na[1.5+0]=8\nn[0]=4\nm=a", CONTAINERS)
    assert isinstance(found["g"], list) and found["g"][5][7] == 3
    assert (found["a"], found["n"], found["m"]) == ([0, 0, 8, 0, 0, 0, 0, 0, 0, 0], 4, 0)


@pytest.mark.requirement("VAL-VAR-02", "VAL-VAR-10", by="gateway.pure.languages.val3.arrays:key")
@pytest.mark.parametrize(
    ("code", "error"),
    [
        ("n=a[10]", 20),
        ("n=a[i-1]", 21),
        ("a[10]=1", 20),
        ("n=g[0,8]", 20),
        ("g[6,0]=1", 20),
        ('n=c[""]', 23),
        ('n=c["missing"]', 25),
        ("a[i-1]=2", 21),
    ],
)
def test_an_index_or_key_that_is_not_there_is_an_error(code: str, error: int) -> None:
    assert error_of(code, CONTAINERS) == error


@pytest.mark.requirement("VAL-VAR-04", "VAL-VAR-05", by="gateway.pure.languages.val3.variable_expressions:VariableTranslator._on_size")
def test_a_place_that_is_not_there_stops_the_line_that_passes_it() -> None:
    data = datum("a", "num", "3") + datum("o", "dio", "2") + datum("n", "num")
    callee: dict[str, Any] = {"one(num& x)": "n=1", "part(num& x[])": "n=1", "on(num& x[], num y)": "call part(x[y])"}
    for call in ("call one(a[3])", "call part(a[3])", "call on(a[1],2)", "n=dioGet(o[2])", 'taskCreate "t",10,one(a[4])'):
        found = run(App(data=data, programs={"start": call, **callee}))
        assert isinstance(found["globals"], dict) and found["globals"]["n"] == 0, call
        tasks = found["tasks"]
        assert isinstance(tasks, dict)
        program, line = ("on", 2) if call.startswith("call on(") else ("start", 2)
        assert tasks["demo~"] == {"status": 20, "program": program, "line": line}, call
    assert globals_of("call on(a[1],1)", data, **callee)["n"] == 1


def test_sizes() -> None:
    data = CONTAINERS + datum("t", "num", "2,3,4")
    found = globals_of("n=size(a)\ni=size(a[3])\nj=size(t,3)\nk=size(t,4)\nm=size(n)+size(c)+size(a,1)", data)
    assert [found[name] for name in "nijkm"] == [10, 7, 4, 0, 13]
    faults = faults_of('n=size(c["b"])\nn=size(t[1,2,3],3)', data)
    assert [text for _, text in faults] == ["'c[\"b\"]' : unexpected key", "'t[1,2,3]' : unexpected indices"]


@pytest.mark.requirement("VAL-VAR-06", "VAL-VAR-07", "VAL-VAR-08", by="gateway.pure.languages.val3.arrays:f_insert")
def test_containers_grow_and_shrink() -> None:
    data = CONTAINERS + datum("b1", "bool") + datum("b2", "bool") + datum("e", "num")
    code = (
        "resize(g,2,5)\nn=size(g,2)\ninsert(a[size(a)])\nappend(a)\na[11]=5\ninsert(a[1])\n"
        'b1=insert(c["k"])\nb2=insert(c["k"])\ndelete(c["a"])\ndelete(a[0])'
    )
    found = globals_of(code, data)
    assert (found["n"], found["b1"], found["b2"], found["c"]) == (5, True, False, {"b": 2, "k": 0})
    assert found["a"] == [0] * 11 + [5]
    assert [error_of(line, data) for line in ("delete(e[0])", 'delete(c["x"])', "delete(a[10])", "resize(a,1,10000)")] == [70, 25, 20, 40]
    local = run(App(data=data, programs={"start": (["num l_a[3]"], "append(l_a)")}))["tasks"]
    assert isinstance(local, dict) and local["demo~"]["status"] == 71


@pytest.mark.requirement("VAL-VAR-07", by="gateway.pure.languages.val3.arrays:part_of")
@pytest.mark.parametrize(
    "line", ["append(x_a)", "insert(x_a[1])", "delete(x_a[0])", "resize(x_a,1,9)", "call grow(x_a[1])", "call grow(x_a)"]
)
def test_a_local_array_does_not_grow_in_a_program_it_is_passed_to(line: str) -> None:
    """L1141: also where it comes by reference; what was passed from the data grows."""
    data = datum("a", "num", "3") + datum("m", "num", "2,2")
    programs = {"take(num& x_a[])": line, "grow(num& x_b[])": "append(x_b)", "wide(num& x_m[,])": "resize(x_m,1,3)"}
    for code, status in (
        ("call take(l_a)", 71),
        ("call take(l_a[1])", 71),
        ("call take(a)", 0),
        ("call wide(l_m)", 71),
        ("call wide(m)", 0),
    ):
        app = App(data=data, programs={"start": (["num l_a[3]", "num l_m[2,2]"], code), **programs})
        tasks = run(app)["tasks"]
        assert isinstance(tasks, dict) and (tasks["demo~"]["status"] if tasks else 0) == status, code


@pytest.mark.requirement("VAL-VAR-09", by="gateway.pure.languages.val3.arrays:f_next")
def test_keys_come_in_alphabetical_order() -> None:
    data = datum("c", "num", "", value("b") + value("a") + value("c")) + datum("e", "num", "") + datum("s", "string", "7")
    found = globals_of('s[0]=first(c)\ns[1]=next(c["a"])\ns[2]=next(c["c"])\ns[3]=last(c)\ns[4]=prev(c["a"])\ns[5]=first(e)+last(e)', data)
    assert found["s"] == ["a", "b", "", "c", "", "", ""]


def test_is_defined_asks_without_an_error() -> None:
    found = globals_of('if isDefined(c["x"])==false and isDefined(a[9]) and !isDefined(a[10])\nn=1\nendIf', CONTAINERS)
    assert found["n"] == 1


@pytest.mark.parametrize(
    ("code", "text"),
    [
        ("jA[1]=3", "'jA' : data expected"),
        ("call nothing()", "'nothing' : undefined program"),
        ("call start", "'(' expected"),
        ("n=max(1,2", "')' expected"),
        ("n=m[1", "']' expected"),
        ("n=s", "'n=s' : Invalid binary operator for these types"),
        ('n=1+"a"', "'1+\"a\"' : Invalid binary operator for these types"),
        ("if n\nendIf", "'n' : invalid type"),
        ("n=", "data expected"),
        ("while true\nendFor\nendWhile", "endFor does not match for"),
        ("n=noSuch(1)", "'noSuch' : undefined instruction"),
        ("n=sin()", "'sin()' : invalid number of parameters"),
        ("n=sin(s)", "'s' : invalid type"),
        ("movej({0,0,0,0,0,0},flange,mD)", "'{0,0,0,0,0,0}' : Ambiguous expression"),
    ],
)
def test_compile_errors_in_the_words_of_the_controller(code: str, text: str) -> None:
    faults = faults_of(code, NUMS + datum("s", "string") + datum("mD", "mdesc"))
    assert [each for _, each in faults] == [text]


def test_a_switch_needs_a_type_that_can_be_compared() -> None:
    code = "switch {}\ncase {}\nbreak\ncase 1,2\nbreak\nendSwitch"
    data = NUMS + datum("ai", "aio", values=value(link="x")) + datum("si", "sio", values=value(link="y")) + datum("f", "frame")
    for name in ("ai", "si"):
        assert faults_of(code.format(name, name), data) == [(2, f"'{name}' : invalid type")]
    assert faults_of(code.format("nope", "n"), data) == [(2, "'nope' : data expected")], "one fault is one fault"
    assert faults_of("switch f\ncase f\nbreak\nendSwitch", data) == []


def test_an_open_block_is_named_with_its_line() -> None:
    assert faults_of("if true\nfor n=1 to 2\n", NUMS) == [(2, "endIf expected"), (3, "endFor does not match for")]


def test_an_add_on_loads_and_stops_with_250() -> None:
    assert error_of("n=1\n$trackOn(n)\nn=2", NUMS) == 250


def test_variables_that_are_named_as_statements_are() -> None:
    """An output `do[1]`, a counter `step`: an assignment, a field or an index makes it a variable."""
    found = globals_of(
        "do[1]=true\nstep = 3\nfor to=1 to step\nendFor\nend.x=to",
        datum("do", "bool", "2") + datum("step", "num") + datum("to", "num") + datum("end", "trsf"),
    )
    assert (found["do"], found["step"], found["to"]) == ([False, True], 3, 4)
