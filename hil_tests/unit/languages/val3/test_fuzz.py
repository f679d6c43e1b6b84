"""No text is more than a list of faults, no file an exception."""

from hypothesis import given
from hypothesis import strategies as st

from gateway.pure.languages.val3.disk import Disk
from gateway.pure.languages.val3.loader import Loader
from gateway.pure.languages.val3.machine import Machine
from gateway.pure.languages.val3.virtual import Run
from hil_tests.unit.languages.val3.apps import App, datum, disk

WORDS = (
    "n a[1] a[n] s c[s] g[1,2] if while for to step endFor endIf endWhile else elseIf do until switch case break default endSwitch "
    'call return = == + - * / % ( ) [ ] { } , . : ! 1 -1 1e3 "x" true wait( delay( size( insert( toNum( movej( taskCreate "t" start() '
    "$x(1) and or xor begin end"
).split()
DATA = datum("n", "num") + datum("a", "num", "4") + datum("s", "string") + datum("c", "num", "") + datum("g", "num", "2,3")
LINES = st.lists(st.lists(st.sampled_from(WORDS), max_size=9).map(" ".join), max_size=8)


@given(LINES)
def test_any_program_is_checked_and_what_passes_runs(lines: list[str]) -> None:
    made = Machine(disk(App(data=DATA, programs={"start": "\n".join(lines)})))
    own = made.instance("demo", "demo", "")
    if own is not None:
        Run(made, own, 2_000_000, []).go()
        assert not any(task.status == 61 for task in made.tasks), made.log


@given(st.text(max_size=80).map(lambda text: text.replace("]]>", "")))
def test_any_text_is_checked(text: str) -> None:
    made = disk(App(data=DATA))
    made.write(
        "demo/start.pgx",
        f"<Programs><Program name='start'><Code><![CDATA[begin\n{text}\nend]]></Code></Program></Programs>".encode("utf-8", "replace"),
    )
    assert Loader(made).load("demo", "demo") is not None


@given(st.binary(max_size=200), st.sampled_from(["demo.pjx", "demo.dtx", "start.pgx"]))
def test_any_bytes_are_a_fault(data: bytes, file: str) -> None:
    files = disk(App(data=DATA)).files
    found = Loader(Disk({**files, f"demo/{file}": data})).load("demo", "demo")
    assert found is not None and found.faults.errors
