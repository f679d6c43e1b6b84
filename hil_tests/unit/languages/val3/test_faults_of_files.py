"""Faults of application files: their line and column, what nothing reads, and their German (issue 24, bad input)."""

import pytest

from gateway.files.texts import spoken
from gateway.pure.languages.val3.disk import Disk
from gateway.pure.languages.val3.loader import Loader
from hil_tests.unit.languages.val3.apps import App, datum, disk, value

DATA, PROJECT, START, SUB = "demo/demo.dtx", "demo/demo.pjx", "demo/start.pgx", "demo/sub.pgx"
Q = datum("n", "num") + "  " + datum("q", "mdesc", "1", "\n    " + value(vel=50))  # lines 4, 5 and 6 of the data file
PART = '<Type name="Part" path="Disk://part/part.pjx" />'
LIBRARY = '<Library alias="lib" path="Disk://lib/lib.pjx" />'
OTHERS = (App("part", datum("x", "num")), App("lib", datum("x", "num"), libraries='<Library alias="two" path="Disk://two/two.pjx" />'))
APP = App(data=Q, programs={"start": "n=1", "sub(num& x)": (["num l_a"], "x=l_a")}, libraries=LIBRARY, types=PART)
Found = list[tuple[str, int, int, str, str]]


def found(file: str, old: str, new: str, *others: App) -> Found:
    """File, line, column, severity and text of each fault, with one text of one file replaced by another."""
    files = disk(APP, *OTHERS, App("two"), *others).files
    assert old.encode() in files[file]
    loaded = Loader(Disk({**files, file: files[file].replace(old.encode(), new.encode())})).load("demo", "demo")
    assert loaded is not None
    return [
        (each.position.file.rpartition("/")[2], each.position.line, each.position.column, each.severity.value, each.text)
        for each in loaded.faults
    ]


def column_of(file: str, old: str, new: str) -> int:
    """Where the element begins in its line."""
    text = disk(APP).files[file].replace(old.encode(), new.encode()).decode()
    begin = text.rindex("<", 0, text.index(new) + 1)
    return begin - text.rindex("\n", 0, begin)


CASES: list[tuple[str, str, str, tuple[str, int, int, str, str] | None]] = [  # column 0: where the element begins
    (DATA, 'type="mdesc"', 'type="mdsc"', ("demo.dtx", 5, 3, "error", "'q' : invalid type (mdsc)")),
    (DATA, 'vel="50"', 'vel="50%"', ("demo.dtx", 6, 5, "error", "'q' : '50%' is not a number")),
    (DATA, 'key="0"', 'key="1"', ("demo.dtx", 6, 5, "error", "'q' : there is no value with the key '1'")),
    (DATA, 'name="q"', "", ("demo.dtx", 5, 3, "error", "<Data> without the attribute name")),
    (
        DATA,
        'vel="50" />',
        'vel="50" >',
        ("demo.dtx", 6, 30, "error", "not well-formed XML: mismatched tag, <Value> of line 6 is not closed"),
    ),
    (DATA, 'vel="50"', 'vel="5&0"', ("demo.dtx", 6, 27, "error", "not well-formed XML: invalid token")),
    (DATA, "</Database>", "", ("demo.dtx", 7, 9, "error", "not well-formed XML: no element found, <Database> of line 3 is not closed")),
    (DATA, 'vel="50"', 'vell="50"', ("demo.dtx", 6, 5, "warning", "'q' : the attribute vell is not read")),
    (DATA, "<Value ", "<Valeu ", ("demo.dtx", 6, 5, "warning", "<Valeu> in <Data> is not read; known: <Value>")),
    (DATA, "Datas>", "Data>", ("demo.dtx", 3, 0, "warning", "<Data> in <Database> is not read; known: <Datas>")),
    (DATA, 'access="public"', 'access="pubic"', None),
    (PROJECT, "<Library ", "<Libary ", ("demo.pjx", 3, 0, "error", "<Libary> in <Libraries> is not read; known: <Library>")),
    (PROJECT, 'alias="lib"', 'name="lib"', ("demo.pjx", 3, 0, "error", "<Library> without the attribute alias")),
    (PROJECT, 'name="Part"', 'name="num"', ("demo.pjx", 3, 0, "error", "'num' : invalid name")),
    (SUB, "<Local ", "<Locl ", ("sub.pgx", 3, 0, "error", "<Locl> in <Locals> is not read; known: <Local>")),
    (SUB, 'use="reference"', 'use="ref"', ("sub.pgx", 3, 0, "error", "'x' : use 'ref'; there are value and reference")),
]


@pytest.mark.parametrize(("file", "old", "new", "expected"), CASES)
def test_a_fault_has_its_line_and_column(file: str, old: str, new: str, expected: tuple[str, int, int, str, str] | None) -> None:
    faults = found(file, old, new)
    if expected is not None and expected[2] == 0:
        expected = (*expected[:2], column_of(file, old, new), *expected[3:])
    if expected is None:
        text = "access 'pubic' is read as private; there are public and private"
        assert faults == [("demo.dtx", line, column, "warning", f"'{name}' : {text}") for name, line, column in (("n", 4, 1), ("q", 5, 3))]
    else:
        assert expected in faults and sum(each[3] == "error" for each in faults) <= 1, faults


def test_the_files_as_they_are_have_no_fault() -> None:
    assert found(DATA, "<Datas>", "<Datas>") == []


def test_libraries_in_a_ring_below_the_application_are_named_where_they_use_each_other() -> None:
    back = App("two", libraries='<Library alias="one" path="Disk://lib/lib.pjx" />')
    (only,) = found(DATA, "<Datas>", "<Datas>", back)
    assert only[0] == "lib.pjx" and only[3:] == (
        "warning",
        "library 'lib': libraries in a ring: lib/lib.pjx -> two/two.pjx -> lib/lib.pjx",
    )


SENTENCES = [
    "the application was written by s6.3; s7 and s8 are read, s6 and older are not",
    "stackSize 'big'; a whole number of bytes above 0 is expected",
    "'q' : size '0'; 1 to 3 sizes from 1, 99999 values at most",
    "'q' : blend 'smooth': there are off, joint, Cartesian",
    "'q' : fatherId 'fX[0]': there is no frame of that name",
    "library 'lib': Foo://lib/lib.pjx: the root Foo is unknown; known are Disk, Floppy and USB0",
    "library 'lib': 'x' : '1,5' is not a number",
    "'Part' : there is no application Disk://part/part.pjx",
    "library 'lib': its length unit is inch, that of demo is mm",
    "not well-formed XML: a control character, 00h, in column 1",
    *(each[3][4] for each in CASES if each[3] is not None and ": invalid" not in each[3][4]),
]


@pytest.mark.parametrize("sentence", SENTENCES)
def test_a_fault_of_a_file_has_its_german(sentence: str) -> None:
    german = spoken("val3-files").german(sentence)
    english = {"is", "are", "there", "not", "the", "read", "known", "without", "expected", "closed", "there's", "written"}
    assert german != sentence and not english & set(german.replace(";", " ").replace(",", " ").split()), german


@pytest.mark.parametrize(
    "sentence", ["'n' : data expected", "'jA[1]' : invalid type", "endFor does not match for", "'q' : undefined program"]
)
def test_the_words_of_a_controller_stay(sentence: str) -> None:
    assert spoken("val3-files").german(sentence) == sentence


@pytest.mark.parametrize(
    ("code", "line", "column", "text"),
    [
        ("b=(n=1)", 2, 1, "'b=(n=1)' : Invalid binary operator for these types"),
        ("n=(n+1)*s", 2, 3, "'(n+1)*s' : Invalid binary operator for these types"),
        ("b=!(n+1)", 2, 3, "'!(n+1)' : Invalid unary operator for this type"),
        ("link(p,t)", 2, 8, "'t' : invalid type"),
        ("n=distance(p,t)", 2, 14, "'t' : invalid type"),
        ("switch n\n// remark\nn=3\nn=4\ncase 1\nbreak\nendSwitch", 4, 1, "'n=3' : case expected"),
        ("switch n\ncse 1\nn=3\nbreak\nendSwitch", 3, 5, "'1' : end of line expected"),
    ],
)
def test_a_fault_of_a_line_has_its_column_and_all_its_text(code: str, line: int, column: int, text: str) -> None:
    data = "".join(datum(name, kind) for name, kind in (("n", "num"), ("b", "bool"), ("s", "string"), ("p", "point"), ("t", "tool")))
    loaded = Loader(disk(App(data=data, programs={"start": code}))).load("demo", "demo")
    assert loaded is not None
    assert [(each.position.line, each.position.column, each.text) for each in loaded.faults] == [(line, column, text)]
