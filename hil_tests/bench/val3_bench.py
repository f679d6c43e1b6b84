"""VAL 3 applications: lines a second in virtual time, and how long a large application takes to load."""

import time
from collections.abc import Iterable, Mapping

from gateway.pure.languages.val3.disk import Disk
from gateway.pure.languages.val3.machine import Machine
from hil_tests.bench import val3_cell_figures
from hil_tests.bench.figure_row import EMPTY_LOOP, Figure, loop_turns, row

SPACE = "http://www.staubli.com/robotics/VAL3/"
XSI = 'xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"'
PROGRAMS, LINES, POINTS = 300, 100, 5_000  # 30,000 lines
FAST, MIXED, QUICK_S = 3e6, 500e3, 3.0
COUNT, TURNS = 1_500_000, 20_000
MIX = """i=0
while i<{turns}
i=i+1
a[i%10]=a[(i+3)%10]+i
s=left("text "+toString("",i),12)
n=n+len(s)
t=t*tStep
t.x=t.x%100
u.count=u.count+1
u.value[1]=u.count*2
call add(n,i)
if a[2]>n
n=0
endIf
endWhile"""
INSIDE = 14  # lines of a turn, those of add() too


def files(name: str, data: str, programs: Mapping[str, tuple[str, str, str]], types: str = "") -> dict[str, bytes]:
    """An application.  programs: name -> parameters, locals, code."""
    listed = "".join(f'<Program file="{each}.pgx" />' for each in programs)
    made = {
        f"{name}/{name}.pjx": f'<Project xmlns="{SPACE}Project/3"><Parameters version="s8.12.2" stackSize="5000" millimeterUnit="true" />'
        f'<Programs>{listed}</Programs><Database><Data file="{name}.dtx" /></Database><Libraries /><Types>{types}</Types></Project>',
        f"{name}/{name}.dtx": f'<Database {XSI} xmlns="{SPACE}Data/2"><Datas>{data}</Datas></Database>',
    }
    for each, (parameters, own, code) in programs.items():
        made[f"{name}/{each}.pgx"] = (
            f'<Programs {XSI} xmlns="{SPACE}Program/2"><Program name="{each}"><Parameters xmlns="{SPACE}Param/1">{parameters}</Parameters>'
            f"<Locals>{own}</Locals><Code><![CDATA[begin\n{code}\nend]]></Code></Program></Programs>"
        )
    return {path: text.encode() for path, text in made.items()}


def datum(name: str, kind: str, size: str = "1", values: Iterable[str] = ()) -> str:
    """A Data element."""
    return f'<Data name="{name}" access="public" xsi:type="array" type="{kind}" size="{size}">{"".join(values)}</Data>'


def seconds(found: Mapping[str, bytes]) -> float:
    """Of a run of the application `bench` to its end."""
    machine = Machine(Disk(dict(found)))
    own = machine.instance("bench", "bench", "")
    assert own is not None, machine.log
    machine.start(own)
    began = time.perf_counter()
    machine.run(10**12)
    took = time.perf_counter() - began
    assert machine.ended, machine.log
    return took


def lines_s() -> float:
    """n=n+1 in a while."""
    data = datum("n", "num")
    code = f"while n<{COUNT}\nn=n+1\nendWhile"
    return 2 * COUNT / seconds(files("bench", data, {"start": ("", "", code), "stop": ("", "", "")}))


def mix_s() -> float:
    """Arrays, strings, transformations, calls, user types."""
    data = datum("i", "num") + datum("n", "num") + datum("a", "num", "10") + datum("s", "string") + datum("t", "trsf")
    data += datum("tStep", "trsf", "1", ['<Value key="0" x="1" rz="1" />']) + datum("u", "Part")
    add = '<Parameter name="x_n" type="num" xsi:type="element" use="reference" /><Parameter name="x_i" type="num" xsi:type="element" />'
    own = '<Local name="l_n" type="num" xsi:type="array" size="1" />'
    programs = {
        "start": ("", "", MIX.format(turns=TURNS)),
        "stop": ("", "", ""),
        "add": (add, own, "l_n=x_i*2\nx_n=x_n+l_n"),
    }
    found = files("bench", data, programs, '<Type name="Part" path="Disk://part/part.pjx" />')
    found |= files("part", datum("count", "num") + datum("value", "num", "4"), {})
    return TURNS * INSIDE / seconds(found)


def load_s() -> float:
    """300 programs, 30,000 lines, 5,000 points: read, checked and ready to start."""
    points = [f'<Value key="{at}" x="{at}" y="1.5" z="2" fatherId="world[0]" />' for at in range(POINTS)]
    data = datum("p", "point", str(POINTS), points) + datum("n", "num") + datum("a", "num", "100") + datum("s", "string")
    part = (
        'n=n+1\nif n>a[n%100]\na[1]=n*2.5\ns="n = "+toString("",n)\nendIf\np[n%10].trsf.x=n\nfor n=1 to 3\na[n]=a[n]+1\nendFor\ndelay(0)\n'
    )
    programs = {f"p{at}": ("", "", part * (LINES // 10)) for at in range(PROGRAMS)}
    found = files("bench", data, {"start": ("", "", ""), "stop": ("", "", ""), **programs})
    began = time.perf_counter()
    assert Machine(Disk(found)).instance("bench", "bench", "") is not None
    return time.perf_counter() - began


def run(seconds: float = val3_cell_figures.SYNC_S) -> list[Figure]:
    """The anchor is an empty loop of Python in the same run."""
    anchor, beside = loop_turns(), EMPTY_LOOP
    return [
        row("val3.lines", lines_s(), "1/s", FAST, beside, anchor, at_least=True),
        row("val3.mix", mix_s(), "1/s", MIXED, beside, anchor, at_least=True),
        row("val3.load_s", load_s(), "s", QUICK_S, beside, anchor),
        *val3_cell_figures.run(beside, anchor, seconds),
    ]
