"""What a data or program file declares wrongly is named at load, with its line; nothing is guessed (issue 24, bad input)."""

from collections.abc import Mapping
from typing import Any

import pytest

from gateway.files.robots import load_robot
from gateway.pure.languages.val3.disk import Disk
from gateway.pure.languages.val3.loader import Loader
from gateway.pure.languages.val3.machine import Machine
from gateway.pure.languages.val3.moves import Moves
from hil_tests.unit.languages.val3.apps import App, check, datum, disk, globals_of, run, value


def errors(app: App, *others: App) -> list[tuple[str, int, str]]:
    """File, line and text of each."""
    return [(fault.position.file, fault.position.line, fault.text) for fault in check(app, *others) if fault.severity.value == "error"]


WRONG: dict[str, tuple[dict[str, Any], str]] = {
    "num": ({"value": "abc"}, "'abc' is not a number"),
    "bool": ({"value": "maybe"}, "'maybe' is neither true nor false"),
    "mdesc": ({"blend": "round"}, "blend 'round': there are off, joint, Cartesian"),
    "jointRx": ({"j3": "1,5"}, "'1,5' is not a number"),
    "point": ({"x": 1, "shoulder": "leftish"}, "shoulder 'leftish': there are righty, lefty, ssame, sfree"),
    "tool": ({"otime": "soon"}, "'soon' is not a number"),
    "frame": ({"rz": "1e999"}, "'1e999' is not a number"),
}


@pytest.mark.parametrize("kind", WRONG)
def test_a_value_that_its_type_does_not_have(kind: str) -> None:
    given, text = WRONG[kind]
    assert errors(App(data=datum("n", "num") + datum("x", kind, "1", value(**given)))) == [("demo/demo.dtx", 5, f"'x' : {text}")]


def test_right_values_of_all_types_and_attributes_of_other_versions() -> None:
    parts = datum("b", "bool", "2", value("0", value="True") + value("1", value="0")) + datum("n", "num", "1", value(value=" 2.5 "))
    parts += datum("t", "tool", "1", value(fatherId="flange[0]", ioLink="ValveIO\\valve1", open="0.1", ctime=2, note="old"))
    parts += datum("m", "mdesc", "1", value(tmax=99999, rmax=99999, blend="cartesian")) + datum("j", "jointRx", "1", value(j1=-1e2))
    assert [(each.severity.value, each.text) for each in check(App(data=parts))] == [("warning", "'t' : the attribute note is not read")]


def test_a_string_that_is_too_long_is_cut_with_a_warning() -> None:
    found = list(check(App(data=datum("s", "string", "1", value(value="x" * 129)))))
    assert [(fault.severity.value, fault.text) for fault in found] == [
        ("warning", "'s' : a string has at most 128 bytes, the rest is cut off")
    ]


PART = App("part", datum("x", "num") + datum("list", "num", "2"))
USES = '<Type name="Part" path="Disk://part/part.pjx" />'


def _part(fields: str) -> App:
    return App(
        data=f'<Data name="u" access="public" xsi:type="array" type="Part" size="1"><Value key="0">{fields}</Value></Data>', types=USES
    )


def test_fields_of_a_user_type() -> None:
    good = '<Field name="x" xsi:type="array" type="num" size="1"><Value key="0" value="1" /></Field>'
    assert errors(_part(good), PART) == []
    assert errors(_part(good.replace('value="1"', 'value="one"')), PART) == [("demo/demo.dtx", 4, "'u' : 'one' is not a number")]
    wrong = errors(_part(good.replace('"num"', '"string"')), PART)
    assert wrong == [("demo/demo.dtx", 4, "'u' : field 'x' : invalid type (string), Part has num")]
    old = list(check(_part(good.replace('"x"', '"gone"')), PART))
    assert [(fault.severity.value, fault.text) for fault in old] == [
        ("warning", "'u' : the type Part has no field 'gone', its value is not used")
    ]


def _faults(files: Mapping[str, bytes]) -> list[tuple[str, str, int]]:
    found = Loader(Disk(dict(files))).load("demo", "demo")
    assert found is not None
    return [(fault.severity.value, fault.position.file, fault.position.line) for fault in found.faults]


def test_broken_files_of_a_type_and_of_a_library_are_named() -> None:
    files = dict(disk(_part(""), PART).files)
    files["part/part.dtx"] = files["part/part.dtx"][:-12]
    assert _faults(files) == [("error", "part/part.dtx", 6)]
    lib = App(libraries='<Library alias="part" path="Disk://part/part.pjx" />')
    files = dict(disk(lib, PART).files)
    files["part/part.dtx"] = files["part/part.dtx"][:-12]
    assert _faults(files) == [("warning", "part/part.dtx", 6)], "libLoad answers 12, the application runs"


def test_broken_files_of_a_type_are_named_in_each_application_that_uses_it() -> None:
    user = '<Data name="u" access="public" xsi:type="array" type="Part" size="1"></Data>'
    files = dict(disk(App("one", user, types=USES), App("two", user, types=USES), PART).files)
    files["part/part.dtx"] = files["part/part.dtx"][:-12]
    loader = Loader(Disk(files))
    for name in ("one", "two"):
        found = loader.load(name, name)
        assert found is not None and [fault.position.file for fault in found.faults] == ["part/part.dtx"]


def test_types_in_a_ring_are_named() -> None:
    one = App("one", datum("x", "Two"), types='<Type name="Two" path="Disk://two/two.pjx" />')
    two = App("two", datum("x", "One"), types='<Type name="One" path="Disk://one/one.pjx" />')
    found = errors(App(data=datum("u", "One"), types='<Type name="One" path="Disk://one/one.pjx" />'), one, two)
    assert ("two/two.pjx", 3, "'One' : the type is made of itself") in found


def test_start_and_stop_have_no_parameters_and_names_are_declared_once() -> None:
    found = errors(App(programs={"start(num x_n)": "", "stop": "", "sub(num x_n)": (["num x_n", "num l_a", "num l_a"], "")}))
    assert [(file, text) for file, _, text in found] == [
        ("demo/start.pgx", "'start' : the program cannot have parameters"),
        ("demo/sub.pgx", "'x_n' is declared twice"),
        ("demo/sub.pgx", "'l_a' is declared twice"),
    ]


@pytest.mark.parametrize(
    ("given", "text"), [("stackSize", "stackSize '-5'"), ("millimeterUnit", "millimeterUnit '-5' is neither true (mm)")]
)
def test_parameters_of_a_project(given: str, text: str) -> None:
    files = dict(disk(App()).files)
    project = files["demo/demo.pjx"].decode()
    old = {"stackSize": '"5000"', "millimeterUnit": '"true"'}[given]
    files["demo/demo.pjx"] = project.replace(f"{given}={old}", f'{given}="-5"').encode()
    found = Loader(Disk(files)).load("demo", "demo")
    assert found is not None and [fault.text[: len(text)] for fault in found.faults] == [text]


def test_start_that_needs_more_memory_than_a_task_has() -> None:
    assert run(App(stack=20))["tasks"] == {"demo~": {"status": 41, "program": "start", "line": 3}}


def test_default_is_taken_where_no_case_fits_wherever_it_is() -> None:
    code = "for n=0 to 3\nswitch n\ndefault\na[n]=9\nbreak\ncase 1\na[n]=1\nbreak\ncase 2,3\na[n]=2\nbreak\nendSwitch\nendFor"
    assert globals_of(code, datum("n", "num") + datum("a", "num", "4"))["a"] == [9, 1, 2, 2]


def test_the_configuration_of_a_scara_is_its_shoulder() -> None:
    data = datum("c", "configRs") + datum("p", "pointRs") + datum("j", "jointRs", values=value(j1=20, j2=-30))

    def faults(code: str, axes: int) -> list[str]:
        loaded = Loader(disk(App(data=data, programs={"start": code})), axes, family="").load("demo", "demo")
        assert loaded is not None
        return [each.text for each in loaded.faults]

    assert faults("c={lefty}\np={{1,2,3,0,0,0},{sfree}}\nc.shoulder=righty", 4) == []
    assert faults("c={lefty,efree,wfree}", 4) == ["'{lefty,efree,wfree}' : invalid number of fields, config has 1"]
    assert faults("c.elbow=efree", 4) == ["'elbow' : invalid name"]
    assert faults("c={lefty}", 6) == ["'{lefty}' : invalid number of fields, config has 3"]
    app = App(data=data, programs={"start": "c=config(j)\np.config={righty}"})
    scara = Machine(disk(app), Moves(load_robot("sr60-like")))
    found = run(app, on=scara)["globals"]
    assert isinstance(found, dict) and (found["c"], found["p"]["config"]) == ({"shoulder": "lefty"}, {"shoulder": "righty"})


@pytest.mark.parametrize(
    ("file", "old", "new", "text"),
    [
        ("sub.pgx", 'use="reference"', 'use="copy"', "'x_n' : use 'copy'; there are value and reference"),
        ("sub.pgx", 'xsi:type="array" use', 'xsi:type="list" use', "'x_n' : the container 'list' is unknown"),
        ("sub.pgx", 'dimensions="2"', 'dimensions="4"', "'x_n' : dimensions '4'; 1, 2 or 3 are expected"),
        ("sub.pgx", "Code>", "Text>", "the program 'sub' has no <Code>"),
        ("demo.dtx", 'key="k"', "", "'c' : there is no value with the key ''"),
    ],
)
def test_what_a_parameter_a_program_and_a_collection_cannot_be(file: str, old: str, new: str, text: str) -> None:
    app = App(data=datum("c", "num", "", value("k", value=1)), programs={"sub(num& x_n[,])": ""})
    files = dict(disk(app).files)
    before = files[f"demo/{file}"].decode()
    files[f"demo/{file}"] = before.replace(old, new).encode()
    assert before.replace(old, new) != before
    found = Loader(Disk(files)).load("demo", "demo")
    assert found is not None
    assert text in [fault.text[: len(text)] for fault in found.faults if fault.severity.value == "error"]


def test_a_key_that_is_there_twice() -> None:
    twice = value("a", value=1) + value("b") + value("a", value=2)
    found = errors(App(data=datum("c", "num", "", twice) + datum("g", "num", "2,2", value("0,1", value=1) + value("0, 1", value=2))))
    assert found == [
        ("demo/demo.dtx", 4, "'c' : there are two values with the key 'a'"),
        ("demo/demo.dtx", 5, "'g' : there are two values with the key '0,1'"),
    ]


def test_each_fault_of_a_line_is_named() -> None:
    app = App(data=datum("m", "mdesc", "1", value(vel="fast", blend="round")) + datum("p", "point", "1", value(x="1,5", wrist="up")))
    assert [text for _, _, text in errors(app)] == [
        "'m' : 'fast' is not a number",
        "'m' : blend 'round': there are off, joint, Cartesian",
        "'p' : '1,5' is not a number",
        "'p' : wrist 'up': there are wpositive, wnegative, wsame, wfree",
    ]
    files = dict(disk(App()).files)
    head = (
        files["demo/demo.pjx"].replace(b'stackSize="5000"', b'stackSize="many"').replace(b'millimeterUnit="true"', b'millimeterUnit="inch"')
    )
    files["demo/demo.pjx"] = head.replace(b'<Program file="start.pgx" />', b'<Program file="one.pgx" /><Program file="two.pgx" />')
    found = Loader(Disk(files)).load("demo", "demo")
    assert found is not None and [fault.text for fault in found.faults] == [
        "stackSize 'many'; a whole number of bytes above 0 is expected",
        "millimeterUnit 'inch' is neither true (mm) nor false (inch)",
        "the file one.pgx is missing",
        "the file two.pgx is missing",
    ]


def test_arrays_in_arrays_of_types_are_counted_together() -> None:
    inner = App("inner", datum("n", "num", "9999"))
    outer = App("outer", datum("i", "Inner", "9999"), types='<Type name="Inner" path="Disk://inner/inner.pjx" />')
    app = App(data=datum("o", "Outer", "9999"), types='<Type name="Outer" path="Disk://outer/outer.pjx" />')
    assert ("demo/demo.dtx", 4, f"'o' : {9999**3} values with those of its components, 1000000 at most") in errors(app, outer, inner)
    assert not errors(App(data=datum("i", "Inner", "99"), types=outer.types), inner)
