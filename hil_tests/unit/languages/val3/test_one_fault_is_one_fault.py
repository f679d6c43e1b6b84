"""A mistake is named once: what follows from it in other lines and files is not a mistake of theirs (issue 24, bad input)."""

from collections.abc import Callable

import pytest

from gateway.pure.languages.val3.disk import Disk
from gateway.pure.languages.val3.loader import Loader
from hil_tests.unit.languages.val3.apps import App, datum, disk, faults_of

CODE = """n=n+1
call sub(n)
call lib:go(n)
n=lib:x
v.part=3
insert(v.parts[3])
for n=1 to v.part
endFor
if v.ready
n=nope
else
n=2
endIf"""
APP = App(
    data=datum("n", "num") + datum("v", "Part"),
    programs={"start": CODE, "sub(num& x)": "x=1", "use(Part& x_v)": "x_v.part=1"},
    libraries='<Library alias="lib" path="Disk://lib/lib.pjx" />',
    types='<Type name="Part" path="Disk://part/part.pjx" />',
)
GOOD = (
    App("lib", datum("x", "num"), {"go(num& x_n)": ""}),
    App("part", datum("part", "num") + datum("parts", "num", "3") + datum("ready", "bool")),
)
NOPE = ("start.pgx", 11, "'nope' : data expected")


def found(change: Callable[[str, bytes], bytes | None]) -> list[tuple[str, int, str]]:
    """File, line and text of the errors, with files changed; None: it is missing."""
    files = {path: change(path, data) for path, data in disk(APP, *GOOD).files.items()}
    loaded = Loader(Disk({path: data for path, data in files.items() if data is not None})).load("demo", "demo")
    assert loaded is not None
    errors = [fault for fault in loaded.faults if fault.severity.value == "error"]
    return [(each.position.file.rpartition("/")[2], each.position.line, each.text) for each in errors]


def test_as_it_is() -> None:
    assert found(lambda path, data: data) == [NOPE]


@pytest.mark.parametrize("ending", ["demo.dtx", "sub.pgx", "lib.pjx", "part.pjx", "part.dtx"])
def test_a_missing_file(ending: str) -> None:
    errors = found(lambda path, data: None if path.endswith(f"/{ending}") else data)
    (only,) = [each for each in errors if each != NOPE]
    assert only[0].endswith(".pjx") and (NOPE in errors) == (ending != "demo.dtx"), errors


@pytest.mark.parametrize("ending", ["demo.dtx", "sub.pgx", "part.dtx"])
def test_half_a_file(ending: str) -> None:
    errors = found(lambda path, data: data[: len(data) // 2] if path.endswith(f"/{ending}") else data)
    (only,) = [each for each in errors if each != NOPE]
    assert only[0] == ending and (NOPE in errors) == (ending != "demo.dtx"), errors


def test_a_declaration_that_cannot_be_read() -> None:
    errors = found(lambda path, data: data.replace(b'name="n" access="public" xsi:type="array" type="num" size="1"', b'name="n" size="0"'))
    assert [file for file, _, _ in errors] == ["demo.dtx"], errors
    errors = found(lambda path, data: data.replace(b'name="x" type="num"', b'name="x" type="numb"'))
    assert [file for file, _, _ in errors] == ["start.pgx", "sub.pgx"] and errors[0] == NOPE, errors


def test_a_file_without_its_name() -> None:
    errors = found(lambda path, data: data.replace(b'file="sub.pgx"', b'path="sub.pgx"'))
    assert [text for file, _, text in errors if file == "demo.pjx"] == [
        "<Program> without the attribute file, which names a file of the application"
    ]
    assert len(errors) == 2, errors


@pytest.mark.parametrize(
    ("code", "line", "text"),
    [
        ("if n==1\nn=2\nendWhile\nn=3", 4, "endWhile does not match while"),
        ("while n<3\nif n==1\nn=2\nendWhile\nendWhile", 5, "endWhile does not match while"),
        ("if n==1\nwhile n<3\nn=n+1\nendIf", 5, "endIf does not match if"),
        ("if n==1\nendWhile\nendIf", 3, "endWhile does not match while"),
        ("switch n\ncase 1\nif n==2\nn=3\nbreak\ndefault\nbreak\nendSwitch", 7, "default does not match switch"),
    ],
)
def test_words_that_close_another_block(code: str, line: int, text: str) -> None:
    faults = faults_of(code, datum("n", "num"))
    assert faults == [(line, text)]


def test_text_behind_the_last_line() -> None:
    errors = found(lambda path, data: data.replace(b"x=1\nend]", b"x=1\nend\n// remark\nx=2]"))
    assert errors == [NOPE, ("sub.pgx", 4, "text after end")]


ELSE_IF = "'else if' : elseIf expected"


@pytest.mark.parametrize(
    ("code", "lines"),
    [
        ("if n==1\nn=2\nelse if n==2\nn=3\nendIf", [4]),
        ("if n==1\nn=2\nelse if n==2\nn=3\nendIf\nendIf", [4]),
        ("while n<3\nif n==1\nelse if n==2\nendIf\nendWhile", [4]),
        ("while n<3\nif n==1\nelse if n==2\nendIf\nendIf\nendWhile", [4]),
        ("if n>0\nif n==1\nelse if n==2\nendIf\nelse\nn=4\nendIf", [4]),
        ("if n>0\nif n==1\nelse if n==2\nendIf\nendIf\nendIf", [4]),
        ("if n==1\nelse if n==2\nelse if n==3\nelse\nn=4\nendIf", [3, 4]),
        ("if n==1\nelse if n==2\nelse if n==3\nendIf\nendIf\nendIf", [3, 4]),
        ("switch n\ncase 1\nif n==1\nelse if n==2\nendIf\nbreak\ncase 2\nbreak\nendSwitch", [5]),
    ],
)
def test_else_if_in_two_words_is_one_fault_with_one_end_and_with_two(code: str, lines: list[int]) -> None:
    assert faults_of(code, datum("n", "num")) == [(line, ELSE_IF) for line in lines]


@pytest.mark.parametrize(
    ("code", "line", "text"),
    [
        ("if n==1\nn=2\nend if\nn=3", 4, "'end if' : endIf expected"),
        ("while n<3\nn=n+1\nEnd  While", 4, "'End While' : endWhile expected"),
        ("while n<3\nn=n+1\nendWile", 4, "'endWile' : instruction expected"),
        ("for n=0 to 3\nif n==1\nn=2\nendiff\nendFor", 5, "'endiff' : instruction expected"),
        ("do\nn=n+1\nuntill n>3", 4, "'n' : end of line expected"),
        ("whlie (n<3)\nn=n+1\nendWhile", 2, "'whlie' : undefined instruction"),
        ("fro n=0 to 3\nfor n=1 to 2\nendFor\nendFor", 2, "'n' : end of line expected"),
        ("for n=0 to 3\nfort(n)\nendFor", 3, "'fort' : undefined instruction"),
        ("if n==1\nfi n==2\nn=3\nendIf\nelse\nn=4\nendIf", 3, "'n' : end of line expected"),
        ("swich n\ncase 1\nbreak\nendSwitch", 2, "'n' : end of line expected"),
    ],
)
def test_a_misspelt_word_of_a_block_is_one_fault(code: str, line: int, text: str) -> None:
    assert faults_of(code, datum("n", "num")) == [(line, text)]
