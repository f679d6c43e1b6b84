"""Return codes of brakeTest, hibernateRobot, wakeUpRobot, setProfile, setMonitorSpeed; esStatus; the guard of the first cycle."""

from typing import Any

import pytest

from gateway.pure.languages.val3.virtual_events import EventFault
from hil_tests.unit.languages.val3.apps import App, datum, run, value

DATA = (
    datum("n", "num", "8")
    + datum("nBrake", "num", "6", "".join(value(str(at), value=9) for at in range(6)))
    + datum("bGo", "bool")
    + datum("jTo", "joint", values=value(j1=60, j3=90, j5=90))
    + datum("mSlow", "mdesc", values=value(vel=20, blend="off"))
    + datum("nCycle", "num")
    + datum("sOutput", "string")
    + datum("nAt", "joint", "3")
)
OFF = "disablePower()\n"


def after(
    program: str, *events: tuple[float, str], arm: bool = True, until: float = 20.0, line_ns: int = 1_000, **programs: str
) -> dict[str, Any]:
    result = run(App(data=DATA, programs={"start": program, **programs}), at=events, arm=arm, until=until, line_ns=line_ns)
    found = result["globals"]
    assert isinstance(found, dict)
    return found


@pytest.mark.requirement("VAL-ROB-06", by="gateway.pure.languages.val3.builtin_robot:f_brake_test")
@pytest.mark.parametrize(
    ("events", "code", "each"),
    [
        ((), 0, [0] * 6),
        (((0, "brakes=0,0,2,0,1,0"),), 1, [0, 0, 2, 0, 1, 0]),
        (((0, "brakes=0,0,1,0,0,0"),), 0, [0, 0, 1, 0, 0, 0]),
        (((0, "brakes=none"),), -14, [-14] * 6),
        (((0, "brakes=at:0,0,90,0,90,0"),), 0, [0] * 6),
        (((0, "brakes=at:0,0,80,0,90,0"),), -3, [-3] * 6),
        (((0.0005, "mode=test"),), -1, [-1] * 6),
    ],
)
def test_brake_test_and_its_array(events: tuple[tuple[float, str], ...], code: int, each: list[int]) -> None:
    found = after(OFF + "delay(0.01)\nn[0]=brakeTest(nBrake)", *events)
    assert (found["n"][0], found["nBrake"]) == (code, each)


@pytest.mark.requirement("VAL-ROB-06", by="gateway.pure.languages.val3.builtin_robot:_no_brake_test")
def test_brake_test_needs_an_arm_at_rest_without_power() -> None:
    found = after("n[0]=brakeTest(nBrake)\nmovej(jTo,flange,mSlow)\ndelay(0.5)\nn[1]=brakeTest(nBrake)\nresetMotion()")
    assert found["n"][:2] == [-5, -2] and found["nBrake"] == [-2] * 6
    found = after(OFF + "n[0]=brakeTest(nBrake)", (0.25, "power=1"))
    assert found["n"][0] == -5 and found["nBrake"] == [0, 0, 0, -5, -5, -5], "power comes on while it is made"


def test_a_task_that_is_killed_in_its_brake_test_leaves_13_for_the_rest() -> None:
    code = OFF + 'taskCreate "t",10,test()\ndelay(0.25)\ntaskKill("t")\ndelay(0.1)'
    assert after(code, test="n[0]=brakeTest(nBrake)")["nBrake"] == [0, 0, -13, -13, -13, -13]


@pytest.mark.requirement("VAL-ROB-06", by="gateway.pure.languages.val3.builtin_robot:f_hibernate_robot")
@pytest.mark.parametrize("code", [0, -1, -2, -4])
def test_hibernate_robot(code: int) -> None:
    found = after("n[0]=hibernateRobot()\ndisablePower()\nn[1]=hibernateRobot()\nn[2]=wakeUpRobot()", (0, f"hibernate={code}"))
    assert found["n"][:3] == [-3, code, 0]


@pytest.mark.requirement("VAL-ROB-06", by="gateway.pure.languages.val3.builtin_robot:f_wake_up_robot")
@pytest.mark.parametrize("code", [0, -1, -2, -3])
def test_wake_up_robot(code: int) -> None:
    assert after("n[0]=wakeUpRobot()", (0, f"wakeup={code}"))["n"][0] == code


@pytest.mark.parametrize(
    "text", ["estop=7", "estop=2.5", "brakes=0,1", "brakes=0,0,3,0,0,0", "brakes=at:1", "hibernate=-3", "wakeup=-4", "ratio=0.5"]
)
def test_events_that_are_none(text: str) -> None:
    with pytest.raises(EventFault, match="expected"):
        after("delay(0.1)", (0, text))


@pytest.mark.requirement("VAL-ROB-03", by="gateway.pure.languages.val3.robot_state:RobotState.stop")
def test_es_status_is_the_state_of_the_safety_chain() -> None:
    steps = "\n".join(f"n[{at}]=esStatus()\ndelay(1)" for at in range(5)) + "\nenablePower()\nn[5]=esStatus()"
    events = [(0.5, "estop=3"), (1.5, "estop=0"), (2.5, "estop=2"), (3.5, "estop=0")]
    assert after(steps, *events)["n"] == [0, 3, 0, 2, 1, 0, 0, 0]


def test_a_program_gives_the_safe_restart() -> None:
    code = "setSafetyRestart()\nn[0]=esStatus()\nwait(esStatus()==1)\nsetSafetyRestart()\nn[1]=esStatus()\nn[2]=sel(isPowered(),1,0)"
    assert after(code, (0.0, "estop=1"), (0.5, "estop=0"))["n"][:3] == [2, 0, 0]


@pytest.mark.requirement("VAL-ROB-03", by="gateway.pure.languages.val3.builtin_robot:f_es_status")
def test_an_ss1_takes_the_power_an_ss2_holds_the_arm() -> None:
    code = "n[0]=sel(isPowered(),1,0)\nmovej(jTo,flange,mSlow)\ndelay(0.5)\nnAt[0]=herej()\ndelay(0.5)\nn[1]=esStatus()\n"
    code += "n[2]=sel(isPowered(),1,0)\nnAt[1]=herej()\ndelay(1)\nnAt[2]=herej()"
    for stop, powered in (("3", 1), ("1", 0)):
        found = after(code, (0.7, f"estop={stop}"))
        at = [each["j1"] for each in found["nAt"]]
        assert found["n"][:3] == [1, 3 if powered else 2, powered] and at[0] < at[1] == at[2]


@pytest.mark.requirement("VAL-ROB-05", by="gateway.pure.languages.val3.builtin_robot:f_get_monitor_speed")
def test_the_guard_of_the_first_cycle_holds_the_arm_until_the_speed_is_low() -> None:
    guard = """while true
if(nCycle < 2)
if (getMonitorSpeed()> 10)
stopMove()
sOutput="For the first cycle the monitor speed must remain at 10%"
wait(getMonitorSpeed( )<= 10)
endif
restartMove()
endif
delay(0)
endWhile"""
    code = 'taskCreate "guard",10,guard()\ndelay(0.1)\nmovej(jTo,flange,mSlow)\ndelay(2)\nnAt[0]=herej()\ndelay(2)\nnAt[1]=herej()\n'
    code += 'delay(1)\nnAt[2]=herej()\nnCycle=2\nwaitEndMove()\ntaskKill("guard")'
    found = after(code, (0, "speed=50"), (3, "speed=10"), (4.5, "speed=50"), until=60, line_ns=400_000, guard=guard)
    first, second, third = (each["j1"] for each in found["nAt"])
    assert found["sOutput"] == "For the first cycle the monitor speed must remain at 10%"
    assert first == 0 and second > 0 and second < third < second + 6, "it stands, moves slowly, stands again"


@pytest.mark.requirement("VAL-UI-07", by="gateway.pure.languages.val3.builtin_pages:f_set_profile")
def test_set_profile_and_its_codes() -> None:
    code = 'n[0]=setProfile("nobody","")\nn[1]=setProfile("service","wrong")\nn[2]=setProfile("staubli","x")\n'
    code += 'n[3]=setProfile("service","secret")\nsOutput=getProfile()\ndelay(1)\n'
    code += 'n[4]=setProfile("service","secret")\nn[5]=setProfile("default","")'
    found = after(code, (0, "profile=service:secret"), (0.5, "profile=staubli"))
    assert (found["n"], found["sOutput"]) == ([-1, -2, -3, 0, -4, -4, 0, 0], "service")


@pytest.mark.requirement("VAL-ROB-04", by="gateway.pure.languages.val3.robot_state:RobotState.set_speed")
def test_the_speed_is_lowered_always_and_raised_in_remote_mode_alone() -> None:
    code = "n[0]=setMonitorSpeed(40)\nn[1]=setMonitorSpeed(101)\nn[2]=setMonitorSpeed(60)\ndelay(1)\nn[3]=setMonitorSpeed(70)\n"
    assert after(code + "n[4]=setMonitorSpeed(30)\nn[5]=getMonitorSpeed()", (0.5, "mode=local"))["n"][:6] == [0, -3, 0, -1, 0, 30]
