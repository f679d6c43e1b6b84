"""alter from a synchronous task, connection moves and step mode on the modelled arm.  Source: VAL 3 reference 4.2, 10, 13.1."""

import itertools
import math

import pytest

from gateway.pure.languages.val3.virtual import Run
from hil_tests.unit.languages.val3.apps import App, datum, machine, run, value
from hil_tests.unit.languages.val3.test_moves import DATA

V = "gateway.pure.languages.val3.builtin_moves:"
M = "gateway.pure.languages.val3.moves:Moves."
MORE = DATA + datum("tr", "trsf") + datum("f", "frame") + datum("w", "bool") + datum("mA", "mdesc") + datum("st", "num")
READY = "movej(q[2],t,m)\nwaitEndMove()\np[0]=here(t,world)\np[1]=appro(p[0],{0,0,-80,0,0,0})\nm.vel=5\nm.blend=off\n"
SENSOR = "while true\ntr.y=min(tr.y+0.1,10)\na[8]=alter(tr)\ndelay(0)\nendWhile"


def data_of(code: str, at: tuple[tuple[float, str], ...] = (), until: float = 30.0, **programs: str) -> dict[str, object]:
    """Globals after a run without errors."""
    found = run(App(data=MORE, programs={"start": code, **programs}), arm=True, at=at, until=until)
    data = found["globals"]
    assert isinstance(data, dict) and found["tasks"] == {}, found
    return data


def numbers(found: dict[str, object]) -> list[float]:
    """The array a."""
    given = found["a"]
    assert isinstance(given, list)
    return given


@pytest.mark.requirement("VAL-ALT-01", "VAL-ALT-02", "VAL-ALT-03", by=(V + "f_alter", V + "f_alter_end", V + "f_alter_begin_frame"))
def test_alter_shifts_the_path_until_alter_end_and_the_standard_move_goes_on_from_there() -> None:
    code = (
        "a[0]=alter(tr)\nalterMovel(p[1],t,m)\ndelay(0.1)\na[1]=alterBegin(f,mA)\na[2]=alterBegin(f,mA)\n"
        'taskCreateSync "s",0.004,w,s()\nwaitEndMove()\na[3]=distance(here(t,world),p[1])\ntr.y=9\ndelay(0.5)\n'
        'a[4]=distance(here(t,world),p[1])\ntaskKill("s")\na[5]=alterEnd()\na[6]=alter(tr)\na[7]=alterBegin(f,mA)\n'
        "movel(p[0],t,m)\nwaitEndMove()\na[9]=distance(here(t,world),p[0])\na[10]=alterStopTime()"
    )
    found = numbers(data_of(READY + code, s=SENSOR))
    assert found[0] == -1 and found[1] == 1 and found[2] == -1, "before begin, begin, begun already"
    assert found[8] == 1 and found[3] > 1 and found[4] == pytest.approx(10, abs=0.01), "altered; and on, behind the end of the path"
    assert found[5:8] == [1, -1, -1], "ended; no second begin on the same path"
    assert found[9] == pytest.approx(0, abs=1e-3) and found[10] == 0


@pytest.mark.requirement("VAL-ALT-02", by="motion.sync.alter:Alter.begin")
def test_alter_begin_behind_a_queued_standard_move_is_for_the_next_path() -> None:
    code = (
        "a[0]=alterBegin(f,mA)\nalterMovel(p[1],t,m)\ndelay(0.1)\ntr.y=0.5\na[1]=alter(tr)\na[2]=alterEnd()\na[3]=alterBegin(f,mA)\n"
        "movel(p[0],t,m)\na[4]=alterBegin(f,mA)\nalterMovel(p[1],t,m)\na[5]=alter(tr)\nwaitEndMove()\ntr.y=-0.5\na[6]=alter(tr)\n"
        "delay(0.1)\na[7]=distance(here(t,world),p[1])\na[8]=alterEnd()\na[9]=alterBegin(f,mA)\nmovel(p[0],t,m)\nwaitEndMove()"
    )
    found = numbers(data_of(READY + code))
    assert found[:7] == [0, 1, 1, -1, 0, -1, 1], "no second one on the same path (L6294); behind a standard move it waits for the next"
    assert found[7] == pytest.approx(0.5, abs=1e-3) and found[8:10] == [1, -1]


@pytest.mark.requirement("VAL-ALT-01", by=M + "step")
def test_too_fast_an_alteration_locks_until_reset_motion_and_the_next_move_is_150() -> None:
    code = (
        "alterMovel(p[1],t,m)\na[0]=alterBegin(f,mA)\ndelay(0.1)\ntr.y=50\na[1]=alter(tr)\ndelay(0.1)\na[2]=alter(tr)\n"
        'taskCreate "m",10,more()\ndelay(0.1)\na[3]=taskStatus("m")\ntaskKill("m")\na[4]=alterBegin(f,mA)\nresetMotion()\n'
        "a[5]=alter(tr)\nmovel(p[0],t,m)\nwaitEndMove()\na[6]=distance(here(t,world),p[0])"
    )
    found = numbers(data_of(READY + code, more="movel(p[0],t,m)"))
    assert found[:6] == [0, 1, -3, 150, -3, -1] and found[6] == pytest.approx(0, abs=1e-3)


def test_a_program_repeats_alter_begin_until_its_path_begins() -> None:
    code = (
        "n=0\na[0]=alterBegin(f,mA)\na[1]=alterBegin(f,mA)\nalterMovel(p[1],t,m)\nwhile alterBegin(f,mA)!=1\nn=n+1\ndelay(0)\nendWhile\n"
        "a[2]=alter(tr)\na[3]=alterBegin(f,mA)\na[4]=alterEnd()\nwaitEndMove()"
    )
    found = data_of(READY + code)
    assert numbers(found)[:5] == [0, 0, 1, -1, 1], "0 waits, -1 has begun (L6388-6390)"


def test_alter_is_locked_after_the_stop_time_and_acts_again_after_the_stop() -> None:
    code = (
        "m.vel=1\nalterMovel(p[1],t,m)\ndelay(0.1)\nalterBegin(f,mA)\na[0]=alterStopTime()\nstopMove()\ndelay(0.05)\n"
        "a[1]=alterStopTime()\na[2]=alter(tr)\ndelay(0.6)\na[3]=alterStopTime()\na[4]=alter(tr)\nrestartMove()\ndelay(0.01)\n"
        "a[5]=alter(tr)\nresetMotion()"
    )
    found = numbers(data_of(READY + code))
    assert found[0] == -1 and 0 < found[1] < 0.5 and found[2:6] == [1, 0, 0, 1]


OFF = ((1.0, "power=0"), (2.0, "joints=5,20,90,0,90,0"), (3.0, "power=1"))
AWAY = "m.vel=10\nm.blend=off\nautoConnectMove({})\nmovej(q[1],t,m)\nwaitEndMove()\nn=herej().j1\nk=clock()"
WATCH = 'taskCreate "w",10,w9()\n' + AWAY + '\ntaskKill("w")'
SEEN = "delay(2.5)\na[0]=herej().j2\ni=workingMode(a[1])\ndelay(0.55)\ni=workingMode(a[2])\ndelay(0.2)\na[3]=herej().j2"


@pytest.mark.requirement("VAL-MOV-09", by=M + "_connect")
def test_a_path_left_by_jogging_is_met_again_by_a_connection_move() -> None:
    plain = data_of(AWAY.format("true"))
    found = data_of(WATCH.format("true"), OFF, w9=SEEN)
    seen = numbers(found)
    assert seen[0] == 20 and seen[2] == 1 and 0 < seen[3] < 20, "jogged; then on its way back"
    assert found["n"] == pytest.approx(60) and float(str(found["k"])) > float(str(plain["k"])) + 2.2, "two seconds off and the way back"


@pytest.mark.requirement("VAL-MOV-09", by="motion.val3.stack:MotionStack.connects")
def test_without_auto_connect_move_the_operator_confirms_it() -> None:
    waiting = run(App(data=MORE, programs={"start": AWAY.format("false")}), arm=True, at=OFF, until=10)
    assert isinstance(waiting["tasks"], dict) and waiting["tasks"]["demo~"]["status"] == 1, "it waits"
    confirmed = data_of(AWAY.format("false"), (*OFF, (5.0, "connect=1")))
    assert confirmed["n"] == pytest.approx(60) and float(str(confirmed["k"])) > 5.5
    back = data_of("m.vel=10\nmovej(q[1],t,m)\ndelay(4)\nresetMotion()\nmovej(q[0],t,m)\nwaitEndMove()\nn=herej().j1", OFF)
    assert back["n"] == pytest.approx(30), "resetMotion goes on from where the arm is"


def way(pauses: str) -> list[tuple[float, ...]]:
    """Tool positions, mm, of three blended moves at low speed, one a cycle."""
    data = DATA + datum("bEnd", "bool") + datum("mC", "mdesc", values=value(vel=100, blend="Cartesian", leave=30, reach=30))
    code = (
        "p[0]=here(flange,world)\np[1]=appro(p[0],{60,0,0,0,0,0})\np[2]=appro(p[0],{60,60,0,0,0,0})\n"
        f"movel(p[1],flange,mC)\n{pauses}\nmovel(p[2],flange,mC)\n{pauses}\nmovej(q[0],flange,m)\nwaitEndMove()\nbEnd=true"
    )
    made = machine(App(data=data, programs={"start": code}), arm=True, line_ns=20_000)
    made.robot.speed = 5
    own = made.instance("demo", "demo", "")
    assert own is not None and made.moves_or_none is not None
    going, seen = Run(made, own, 60_000_000_000, []), []
    made.start(own)
    while not made.ended and made.clock < going.until:
        made.run(made.clock + 4_000_000)
        seen.append(tuple(1e3 * each for each in made.moves.machine.forward(made.moves.position).position))
    assert made.ended
    return seen


def off_the_line(point: tuple[float, ...], line: list[tuple[float, ...]], near: int) -> tuple[float, int]:
    """Distance from the nearest of the stretches around one of them, and which."""
    best, where = math.inf, near
    for at in range(max(near - 5, 0), min(near + 60, len(line) - 1)):
        a, b = line[at], line[at + 1]
        ab = [y - x for x, y in zip(a, b, strict=True)]
        length = sum(x * x for x in ab)
        share = 0.0 if length == 0 else min(max(sum((p - x) * d for p, x, d in zip(point, a, ab, strict=True)) / length, 0.0), 1.0)
        distance = math.dist(point, [x + share * d for x, d in zip(a, ab, strict=True)])
        if distance < best:
            best, where = distance, at
    return best, where


@pytest.mark.requirement("VAL-MOV-05", by=V + "f_movel")
def test_step_mode_makes_the_path_of_the_normal_run() -> None:
    auto, stepped = way(""), way("delay(8)")
    assert len(stepped) > len(auto) + 1000
    still = sum(a == b for a, b in itertools.pairwise(stepped))
    assert still > 1000, "it halts at leave until the next move is stepped"
    near, worst = 0, 0.0
    for point in stepped:
        distance, near = off_the_line(point, auto, near)
        worst = max(worst, distance)
    assert worst < 1e-3, f"{worst * 1e3:.3f} um off the path"
