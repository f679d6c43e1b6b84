"""Numbers beyond what a num holds: refused in a program, never a traceback, no infinity in a result or a file."""

import json

import pytest

from hil_tests.unit.languages.val3.apps import App, datum, error_of, faults_of, run, value

DATA = datum("n", "num") + datum("m", "num") + datum("a", "num", "3") + datum("s", "string") + datum("d", "dio", "1", value(link="x"))
LARGE = "n=-1e308*10\nn=1e308*10\n"


def test_a_literal_that_is_too_large_is_a_compile_error() -> None:
    assert faults_of("n=1e308\nn=1e309", DATA) == [(3, "'1e309' : number too large")]


def test_a_block_word_out_of_place_is_named() -> None:
    assert faults_of("end") == [(2, "'end' : instruction expected")]
    assert faults_of("begin") == [(2, "'begin' : instruction expected")]


def test_a_result_with_infinity_is_json() -> None:
    result = run(App(data=DATA, programs={"start": LARGE + "m=n-n\na[1]=-n"}))
    found = json.loads(json.dumps(result, allow_nan=False))["globals"]
    assert (found["n"], found["m"], found["a"]) == ("inf", "nan", [0, "-inf", 0])


@pytest.mark.parametrize(
    "code",
    [
        *("m=round(n)", 's=toString(".3",n)', "m=bAnd(n,3)", "a[n]=1", "s=chr(n)", "m=dioSet(d,n)", 's=mid("abc",n,n)', "m=sin(n)"),
        'taskCreate "t",n,stop()',
    ],
)
def test_an_instruction_with_infinity_stops_its_task_or_goes_on(code: str) -> None:
    assert error_of(LARGE + code + "\nwait(false)", DATA) in (1, 10, 11, 20, 21, 70)


def test_what_is_saved_can_be_loaded() -> None:
    code = LARGE + 'm=libSave("Disk://kept")\na[0]=kept:libLoad("Disk://kept")\na[1]=sel(kept:n>1e308,1,0)'
    library = '<Library alias="kept" path="Disk://base/base.pjx" />'
    found = run(App(data=DATA, programs={"start": code}, libraries=library), App("base", DATA))
    assert isinstance(found["globals"], dict)
    assert found["globals"]["a"] == [0, 1, 0], found["log"]


@pytest.mark.parametrize("text", ["1e999 5", "-1e999", "\u0663 4"])
def test_a_text_that_no_num_holds_is_no_number(text: str) -> None:
    data = DATA + datum("b", "bool", values=value(value="true"))
    found = run(App(data=data, programs={"start": f'm=3\ns=toNum("{text}",m,b)'}))["globals"]
    assert isinstance(found, dict)
    assert (found["b"], found["m"], found["s"]) == (False, 3, text)
