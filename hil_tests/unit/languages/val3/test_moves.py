"""Moves of programs on the modelled arm in virtual time.  Source: VAL 3 reference 10."""

import math

import pytest

from gateway.files.robots import load_robot
from gateway.pure.languages.val3.machine import Machine
from gateway.pure.languages.val3.moves import Moves
from hil_tests.unit.languages.val3.apps import App, datum, disk, error_of, faults_of, run, value

V = "gateway.pure.languages.val3.builtin_moves:"
DATA = "".join(datum(name, "num") for name in ("n", "i", "j", "k")) + datum("a", "num", "12") + datum("b", "bool")
DATA += datum("q", "joint", "3", value("0", j1=30, j3=90, j5=90) + value("1", j1=60, j3=90, j5=90) + value("2", j1=0, j2=10, j3=90, j5=80))
DATA += (
    datum("m", "mdesc", values=value(vel=50))
    + datum("p", "point", "4")
    + datum("t", "tool", values=value(fatherId="flange[0]", otime=0.2, ctime=0.1, ioLink="valve1"))
)
DATA += datum("valve", "dio", values=value(link="valve1"))


def made(
    code: str, at: tuple[tuple[float, str], ...] = (), until: float = 10.0, **programs: str
) -> tuple[dict[str, object], list[dict[str, object]]]:
    """Data and moves."""
    found = run(App(data=DATA, programs={"start": code, **programs}), arm=True, at=at, until=until)
    data, moves = found["globals"], found["moves"]
    assert isinstance(data, dict) and isinstance(moves, list)
    assert "error" not in str(found["log"]), found["log"]
    return data, moves


@pytest.mark.requirement("VAL-MOV-01", by=V + "f_movej_joint")
def test_moves_queue_and_return_at_once() -> None:
    data, moves = made("for i=0 to 3\na[i]=movej(q[i%2],t,m)\nendFor\nn=clock()\nwaitEndMove()\nk=clock()\nb=isEmpty()")
    assert str(data["a"]).startswith("[0, 1, 2, 3, 0") and data["b"] is True
    assert isinstance(data["n"], float | int) and isinstance(data["k"], float) and data["n"] < 0.01 < 0.3 < data["k"]
    assert [move["id"] for move in moves] == [0, 1, 2, 3] and all(move["end_s"] for move in moves) and moves[0]["kind"] == "movej"


@pytest.mark.requirement("VAL-MOV-02", by="gateway.pure.languages.val3.expressions:Translator._choose")
def test_a_literal_as_target_is_ambiguous() -> None:
    assert faults_of("movej({0,0,0,0,0,0},flange,m)", DATA) == [(2, "'{0,0,0,0,0,0}' : Ambiguous expression")]
    data, _ = made("q[2]={0,0,0,0,0,0}\nq[2].j3=80\nmovej(q[2],flange,m)\nwaitEndMove()\nq[1]=herej()")
    assert isinstance(data["q"], list) and data["q"][1]["j3"] == pytest.approx(80)


@pytest.mark.requirement("VAL-MOV-03", by=V + "mdesc_in")
@pytest.mark.parametrize(
    ("change", "code"),
    [("vel=-1", 100), ("accel=0", 101), ("decel=-1", 102), ("tvel=0", 103), ("rvel=-1", 104), ("reach=-1", 105), ("leave=-1", 106)],
)
def test_an_invalid_mdesc_is_refused(change: str, code: int) -> None:
    assert error_of(f"m.{change}\nmovej(q[0],t,m)", DATA, arm=True) == code


@pytest.mark.requirement("VAL-MOV-04", by=V + "f_wait_end_move")
def test_blending_waits_at_leave_and_wait_end_move_goes_to_the_point() -> None:
    data, moves = made("movej(q[0],t,m)\ndelay(2)\nq[1]=herej()\nb=isEmpty()\nwaitEndMove()\nq[2]=herej()")
    assert isinstance(data["q"], list) and 10 < data["q"][1]["j1"] < 29.9 and data["q"][2]["j1"] == pytest.approx(30) and data["b"] is False
    assert isinstance(moves[0]["end_s"], float) and moves[0]["end_s"] > 2


@pytest.mark.requirement("VAL-MOV-06", "VAL-MOV-08", by=(V + "f_stop_move", V + "f_restart_move"))
def test_stop_and_restart_on_the_path() -> None:
    code = (
        "restartMove()\nm.vel=5\nmovej(q[1],t,m)\ndelay(0.3)\nstopMove()\ndelay(1)\nq[0]=herej()\n"
        "b=isSettled() and !isEmpty()\ndelay(1)\nq[2]=herej()\nrestartMove()\nwaitEndMove()\nn=herej().j1"
    )
    data, _ = made(code, until=20)
    assert isinstance(data["q"], list) and data["b"] is True and data["n"] == pytest.approx(60)
    assert data["q"][0] == data["q"][2] and 0 < data["q"][0]["j1"] < 55


@pytest.mark.requirement("VAL-MOV-07", "VAL-MID-02", by=(V + "f_reset_motion", V + "f_set_move_id"))
def test_reset_and_move_ids() -> None:
    code = (
        "movej(q[1],t,m)\ndelay(0.1)\nresetMotion()\nb=isEmpty()\ndelay(1)\na[0]=getMoveId()\n"
        "setMoveId(1000)\na[1]=getMoveId()\na[2]=movej(q[0],t,m)\na[3]=movej(q[1],t,m)\nwaitEndMove()\n"
        "a[4]=getMoveId()"
    )
    data, _ = made(code)
    assert isinstance(data["a"], list) and data["a"][:5] == [0, 0, 1000, 1001, 1002]


@pytest.mark.requirement("VAL-MID-01", by=V + "f_get_move_id")
def test_the_move_id_shows_the_progress() -> None:
    data, _ = made(
        "setMoveId(15)\nm.vel=10\nm.blend=off\nmovej(q[0],t,m)\nmovej(q[1],t,m)\n"
        "wait(getMoveId()>=15.8)\nn=herej().j1\nwait(getMoveId()>=16.5)\ni=herej().j1\n"
        "waitEndMove()\nj=getMoveId()"
    )
    assert data["n"] == pytest.approx(24, abs=1.5) and data["i"] == pytest.approx(45, abs=1.5) and data["j"] == 17


@pytest.mark.requirement("VAL-TOOL-01", by=(V + "f_open", V + "f_close"))
def test_the_gripper_waits_for_the_move() -> None:
    data, _ = made("movej(q[0],t,m)\nopen(t)\nn=herej().j1\nb=valve\ni=clock()\nclose(t)\nj=clock()-i\nif valve==false\nk=1\nendIf")
    assert data["n"] == pytest.approx(30) and data["b"] is True and data["j"] == pytest.approx(0.1, abs=0.002) and data["k"] == 1


def test_lines_arcs_and_the_way_back() -> None:
    code = (
        "movej(q[2],t,m)\nwaitEndMove()\np[0]=here(t,world)\np[1]=appro(p[0],{0,0,-50,0,0,0})\n"
        "p[2]=compose(p[0],world,{0,30,0,0,0,0})\nmovel(p[1],t,m)\nwaitEndMove()\np[3]=here(t,world)\n"
        "n=distance(p[1],p[3])\nmovec(p[2],p[0],t,m)\nwaitEndMove()\ni=distance(p[0],here(t,world))"
    )
    data, moves = made(code, until=30)
    assert data["n"] == pytest.approx(0, abs=1e-3) and data["i"] == pytest.approx(0, abs=1e-3)
    assert [move["kind"] for move in moves] == ["movej", "movel", "movec"]


def test_a_refused_move_is_154_and_its_cause_is_in_the_log() -> None:
    found = run(App(data=DATA, programs={"start": "p[0].trsf={5000,0,0,0,0,0}\nmovej(p[0],t,m)"}), arm=True)
    assert "'status': 154" in str(found["tasks"]) and "error 53" in str(found["log"])
    assert error_of("q[0].j1=500\nmovej(q[0],t,m)", DATA, arm=True) == 154
    assert error_of("movej(q[0],t,m)", DATA) == 153


def test_power_hold_and_speed_act_on_the_arm() -> None:
    code = "m.vel=5\nmovej(q[1],t,m)\nwaitEndMove()\nn=clock()"
    plain, _ = made(code, until=60)
    for events in (((0.1, "power=0"), (5.1, "power=1")), ((0.1, "hold=1"), (5.1, "hold=0"))):
        held, _ = made(code, at=events, until=60)
        assert held["n"] == pytest.approx(float(str(plain["n"])) + 5, abs=0.5)
    slow, _ = made(code, at=((0.0, "speed=50"),), until=60)
    assert slow["n"] == pytest.approx(2 * float(str(plain["n"])), rel=0.2)


@pytest.mark.requirement("VAL-ROB-01", by="gateway.pure.languages.val3.robot_state:RobotState.enable")
def test_power_by_program() -> None:
    code = (
        "disablePower()\nif !isPowered()\nn=1\nendIf\nenablePower()\nif watch(isPowered(),5)\ni=1\nendIf\n"
        "delay(1)\ndisablePower()\nenablePower()\nif watch(isPowered(),1)==false\nj=1\nendIf"
    )
    data, _ = made(code, at=((0.5, "mode=local"),))
    assert (data["n"], data["i"], data["j"]) == (1, 1, 1)


def test_power_off_in_motion_stops_on_the_path_before_the_next_line() -> None:
    """L4167-4169: at once, and the next line finds the arm at rest."""
    code = (
        "m.blend=off\nmovej(q[0],t,m)\nwait(getMoveId()>0.5)\na[0]=clock()\ndisablePower()\na[1]=clock()-a[0]\na[2]=herej().j1\ndelay(0.5)\n"
        "a[3]=herej().j1\nenablePower()\nwaitEndMove()\na[4]=herej().j1"
    )
    data, _ = made(code)
    found = data["a"]
    assert isinstance(found, list)
    taken, stopped, later, end = found[1:5]
    assert taken > 0.008 and stopped == later < 29 and end == pytest.approx(30)


def test_a_first_move_without_way_is_done_at_once() -> None:
    for before in ("", "movej(q[1],t,m)\nwaitEndMove()\nresetMotion()\nq[2]=q[1]\n"):
        data, _ = made(before + ("q[2]=herej()\n" if not before else "") + "movej(q[2],t,m)\nwaitEndMove()\nn=1")
        assert data["n"] == 1


def test_the_speed_is_that_of_the_tool_centre_point() -> None:
    code = (
        "q[0]=herej()\nq[0].j6=170\nm.vel=10\nm.blend=off\nt.trsf={100,0,0,0,0,0}\nmovej(q[0],t,m)\nwait(getMoveId()>0.5)\n"
        "n=getSpeed(t)\ni=getSpeed(flange)\na[0]=herej().j6\na[1]=clock()\ndelay(0.02)\na[2]=herej().j6\na[3]=clock()\nwaitEndMove()\n"
        "delay(0.01)\nj=getSpeed(t)"
    )
    data, _ = made(code)
    turned = data["a"]
    assert isinstance(turned, list)
    rate = (turned[2] - turned[0]) / (turned[3] - turned[1])  # deg/s of joint 6, with the tool 100 mm beside its axis
    assert data["n"] == pytest.approx(math.radians(rate) * 100, rel=0.1) and rate > 50
    assert data["i"] == pytest.approx(0, abs=1e-6) and data["j"] == 0


def test_reset_motion_empties_the_queue_at_once() -> None:
    data, _ = made("movej(q[1],t,m)\ndelay(0.1)\nresetMotion()\nb=isEmpty()\nn=getMoveId()")
    assert (data["b"], data["n"]) == (True, 0)


@pytest.mark.parametrize(("millimetres", "unit"), [(True, 1.0), (False, 25.4)])
def test_linear_axes_are_in_the_length_unit_of_the_application(millimetres: bool, unit: float) -> None:
    """L530, L4511: of a joint; from and to points, in moves and limits."""
    data = datum("q", "joint", "3", value("0", j1=10, j2=20, j3=-4, j4=5)) + datum("m", "mdesc", values=value(vel=50))
    data += datum("p", "point", "2") + datum("b", "bool", "3") + datum("c", "config")
    code = "movej(q[0],flange,m)\nwaitEndMove()\nq[1]=herej()\np[0]=here(flange,world)\np[1]=jointToPoint(flange,world,q[0])\n"
    code += "b[0]=pointToJoint(flange,q[0],p[1],q[2])\nb[1]=isInRange({0,0,-9.8,0})\nb[2]=isInRange({0,0,-9.9,0})\nc=config(q[0])"
    app = App(data=data, programs={"start": code}, millimetres=millimetres)
    on = Machine(disk(app), Moves(load_robot("sr60-like"), (0.0, 0.0, -1.0, 0.0)))
    found = run(app, on=on)["globals"]
    assert isinstance(found, dict)
    assert on.moves.joints() == pytest.approx((10, 20, -4 * unit, 5))
    for joint in found["q"]:
        assert joint["j3"] == pytest.approx(-4) and joint["j2"] == pytest.approx(20)
    assert found["p"][0]["trsf"]["z"] == pytest.approx(300 / unit - 4) == pytest.approx(found["p"][1]["trsf"]["z"])
    assert found["b"] == [True, True, millimetres]


@pytest.mark.parametrize("code", ["link(l_t,flange)\nopen(l_t)", "open(flange)"])
def test_a_local_tool_and_flange_have_the_output_valve1(code: str) -> None:
    """L4921-4923: a local one lacks its base tool alone."""
    app = App(data=DATA, programs={"start": (["tool l_t"], f"{code}\nb=valve")})
    found = run(app, arm=True)["globals"]
    assert isinstance(found, dict) and found["b"] is True
