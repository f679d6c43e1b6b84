"""Tasks, life cycle, synchronisation.  Source: VAL 3 reference 2.1, 5."""

import pytest

from hil_tests.unit.languages.val3.apps import App, check, datum, error_of, globals_of, machine, run, value

M = "gateway.pure.languages.val3.machine:Machine."
B = "gateway.pure.languages.val3.builtin_tasks:"
DATA = "".join(datum(name, "num") for name in ("n", "i", "j", "k")) + datum("b", "bool") + datum("a", "num", "20") + datum("s", "string")
SYNCHRO = "n = n + 1\nwait((n==nN) or (bSynch==true))\nbSynch = true\nn = n - 1\nwait((n==0) or (bSynch == false))\nbSynch = false"


def tasks_of(*apps: App, at: tuple[tuple[float, str], ...] = (), until: float = 10.0) -> dict[str, dict[str, object]]:
    """Tasks at the end."""
    found = run(*apps, at=at, until=until)["tasks"]
    assert isinstance(found, dict)
    return found


@pytest.mark.requirement("VAL-APP-02", "VAL-APP-03", by=M + "_life")
def test_an_application_ends_with_its_last_task() -> None:
    app = App(
        data=DATA,
        programs={
            "start": 'n=taskStatus("demo~")\ntaskCreate "t1", 10, work()',
            "work": "delay(2)\ni=1",
            "stop": 'j=clock()\nk=taskStatus("~demo")',
        },
    )
    found = run(app)
    assert found["tasks"] == {} and found["end_s"] == pytest.approx(2.0, abs=0.01)
    data = found["globals"]
    assert isinstance(data, dict) and (data["n"], data["i"], data["k"]) == (1, 1, 1) and data["j"] == 2


@pytest.mark.requirement("VAL-APP-04", by=M + "stop")
def test_the_operator_stops_an_application() -> None:
    programs = {
        "start": 'taskCreate "t1", 10, work()\nwhile true\ndelay(0.1)\ni=i+1\nendWhile',
        "work": "while true\ndelay(0.1)\nj=j+1\nendWhile",
        "stop": "n=j\ndelay(1)\nk=j-n",
    }
    found = run(App(data=DATA, programs=programs), at=[(1.0, "app=stop")])
    data = found["globals"]
    assert isinstance(data, dict) and found["tasks"] == {} and found["end_s"] == pytest.approx(2.0, abs=0.01)
    assert data["k"] >= 9 and data["i"] <= 10


@pytest.mark.requirement("VAL-APP-05", by=M + "_life")
def test_stop_can_be_called_and_changes_nothing() -> None:
    assert globals_of("call stop()\ni=5", DATA, stop="n=n+1") | {"a": 0} == {"n": 2, "i": 5, "j": 0, "k": 0, "b": False, "a": 0, "s": ""}


@pytest.mark.requirement("VAL-APP-08", by="gateway.pure.languages.val3.tasks:Task.enter")
def test_the_memory_of_a_task_ends() -> None:
    deep = {"start": "call f(0)", "f(num x_n)": "n=x_n\ncall f(x_n+1)"}
    small = run(App(data=DATA, programs=deep))
    large = run(App(data=DATA, programs=deep, stack=20000))
    assert "'status': 41" in str(small["tasks"]) and "'status': 41" in str(large["tasks"])
    assert isinstance(small["globals"], dict) and isinstance(large["globals"], dict)
    assert large["globals"]["n"] > 3 * small["globals"]["n"] > 300


@pytest.mark.requirement("VAL-TASK-01", by=M + "_slice")
def test_turns_have_as_many_lines_as_the_priority() -> None:
    programs = {
        "start": 'taskCreate "t1", 10, one()\ntaskCreate "t2", 30, two()\ndelay(0.1)\ni=n\nj=k',
        "one": "while true\nn=n+1\nendWhile",
        "two": "while true\nk=k+1\nendWhile",
    }
    found = run(App(data=DATA, programs=programs), until=0.2)["globals"]
    assert isinstance(found, dict) and found["j"] / found["i"] == pytest.approx(3, rel=0.01) and found["i"] > 10_000


@pytest.mark.requirement("VAL-TASK-03", "VAL-TASK-04", by=(B + "f_watch", B + "f_delay"))
def test_waiting_takes_time() -> None:
    code = (
        "n=clock()\nif watch(b==true,20)==false\nj=1\nendIf\ni=clock()-n\nif watch(true,0)\nk=1\nendIf\n"
        "n=clock()\ndelay(-1)\na[0]=clock()-n\ndelay(1.5)\na[1]=clock()-n"
    )
    found = run(App(data=DATA, programs={"start": code}), until=30)["globals"]
    assert isinstance(found, dict) and (found["i"], found["j"], found["k"]) == (pytest.approx(20, abs=0.002), 1, 1)
    assert found["a"][0] == 0 and found["a"][1] == pytest.approx(1.5, abs=0.002)
    seen = run(App(data=DATA, programs={"start": "wait(b==true)\nn=clock()"}), at=[(2.0, "b=true")])["globals"]
    assert isinstance(seen, dict) and seen["n"] == pytest.approx(2.0, abs=0.005)


@pytest.mark.requirement("VAL-TASK-05", by=B + "_named")
@pytest.mark.parametrize(
    ("line", "code"),
    [
        ('taskCreate "a234567890123456", 10, w()', 29),
        ('taskCreate "demo~", 10, w()', 29),
        ('taskCreate "t", 0, w()', 70),
        ('taskCreate "t", 101, w()', 70),
        ('taskCreate "t", 1, w()\ntaskCreate "t", 1, w()', 31),
    ],
)
def test_a_task_that_cannot_be_created(line: str, code: int) -> None:
    assert error_of(line, DATA, w="delay(1)") == code


@pytest.mark.requirement("VAL-TASK-06", by="gateway.pure.languages.val3.expressions:Translator.parameters")
def test_no_local_goes_to_a_task_by_reference() -> None:
    app = App(data=DATA, programs={"start": (["num l_n"], 'taskCreate "t", 10, w(l_n)\ntaskCreate "u", 10, w(n)'), "w(num& x_n)": ""})
    assert [fault.text for fault in check(app)] == ["'l_n' : local variable not allowed as a reference parameter of a task"]


@pytest.mark.requirement("VAL-TASK-07", "VAL-TASK-08", by=B + "f_task_status")
def test_status_of_tasks() -> None:
    code = (
        'taskCreate "t1", 10, ok()\nn=taskStatus("t1")\nwait(taskStatus("t1") == -1)\n'
        'taskCreate "t2", 10, bad()\ndelay(0.1)\ni=taskStatus("t2")\ntaskKill("t2")\nj=taskStatus("t2")\n'
        'k=taskStatus("x")'
    )
    found = globals_of(code, DATA, ok="delay(0.5)", bad="n=1/0")
    assert [found[name] for name in "nijk"] == [1, 10, -1, -1]


@pytest.mark.requirement("VAL-TASK-09", "VAL-TASK-10", "VAL-TASK-11", by=(B + "f_task_resume", B + "f_task_suspend", B + "f_task_kill"))
def test_suspending_resuming_and_killing() -> None:
    code = (
        'taskCreate "t", 10, w()\ndelay(0.1)\na[0]=taskStatus("t")\nk=2\ntaskResume("t",0)\ndelay(0.1)\n'
        'a[1]=n\na[2]=taskStatus("t")\ntaskResume("t",1)\ndelay(0.1)\na[3]=j\ntaskSuspend("t")\n'
        'a[4]=taskStatus("t")\ntaskKill("t")\na[5]=taskStatus("t")'
    )
    found = globals_of(code, DATA, w="n=1/k\ni=1/0\nj=7\nwhile true\ndelay(1)\nendWhile")["a"]
    assert found == [10, 0, 0.5, 10, 7, 0, -1] + [0] * 13 or found == [10, 0.5, 10, 7, 0, -1] + [0] * 14
    assert [
        error_of(line, DATA, w="delay(9)")
        for line in ('taskSuspend("x")', 'taskResume("x",0)', 'taskCreate "t",1,w()\ntaskSuspend("t")\ntaskResume("t",50)')
    ] == [30, 30, 90]
    assert globals_of('taskKill("x")\nn=1', DATA)["n"] == 1


@pytest.mark.requirement("VAL-TASK-13", by=B + "f_set_mutex")
def test_a_mutex_is_held_by_one_task() -> None:
    program = "for i=1 to 5\nsetMutex(b)\nn=n+1\nif n>1\nk=99\nendIf\ndelay(0.01)\nn=n-1\nb=false\nendFor"
    found = globals_of(
        'taskCreate "t1", 10, w()\ntaskCreate "t2", 3, w()\nwait(taskStatus("t1")==-1 and taskStatus("t2")==-1)', DATA, w=program
    )
    assert (found["k"], found["n"], found["b"]) == (0, 0, False)


@pytest.mark.requirement("VAL-TASK-14", by=B + "f_wait")
def test_rendezvous_of_three_tasks() -> None:
    data = datum("n", "num") + datum("bSynch", "bool") + datum("nEnd", "num") + datum("late", "num")
    programs = {
        "start": 'taskCreate "t1", 10, w(0.1)\ntaskCreate "t2", 5, w(0.5)\ntaskCreate "t3", 1, w(1)\nwait(nEnd==3)',
        "w(num x_s)": "delay(x_s)\ncall synchro(n,bSynch,3)\nif clock()<1\nlate=1\nendIf\nnEnd=nEnd+1",
        "synchro(num& n, bool& bSynch, num nN)": SYNCHRO,
    }
    found = run(App(data=data, programs=programs))["globals"]
    assert found == {"n": 0, "bSynch": False, "nEnd": 3, "late": 0}


@pytest.mark.requirement("VAL-SYNC-01", by=B + "f_task_create_sync")
def test_synchronous_tasks_run_once_a_period() -> None:
    code = 'taskCreateSync "s1", 0.02, b, one()\ntaskCreateSync "s2", 0.019, b, two()\ndelay(1)\ni=n\nj=k'
    found = run(
        App(
            data=DATA,
            programs={"start": code, "one": "while true\nn=n+1\ndelay(0)\nendWhile", "two": "while true\nk=k+1\ndelay(0)\nendWhile"},
        ),
        until=1.1,
    )["globals"]
    assert isinstance(found, dict) and found["i"] in (49, 50) and found["j"] in (62, 63)


@pytest.mark.requirement("VAL-SYNC-02", "VAL-SYNC-03", by=M + "_cycle")
def test_two_periods_and_3000_lines() -> None:
    create = "\n".join(f'taskCreateSync "s{ms}{at}", 0.0{ms:02}, b, w()' for at, ms in enumerate((4, 8, 8, 12)))
    assert error_of(create, DATA, w="delay(1)") == 32
    found = tasks_of(App(data=DATA, programs={"start": 'taskCreateSync "s", 0.004, b, w()\ndelay(1)', "w": "while true\nn=n+1\nendWhile"}))
    assert found["s"]["status"] == 33


@pytest.mark.requirement("VAL-SYNC-04", by=M + "_cycle")
def test_an_overrun_drops_the_next_cycle() -> None:
    programs = {
        "start": 'taskCreateSync "s", 0.004, b, w()\ndelay(0.1)\nk=n',
        "w": "while true\nn=n+1\nfor i=1 to 1000\nendFor\ndelay(0)\nendWhile",
    }
    found = run(App(data=DATA, programs=programs), until=0.2, line_ns=6_000)["globals"]
    assert isinstance(found, dict) and found["b"] is True and found["k"] in (12, 13)


@pytest.mark.requirement("VAL-SYNC-04", by=M + "_cycle")
def test_cycles_begin_on_the_grid_again_behind_one_that_lasts_more_than_two_periods() -> None:
    """8.4 ms of 4: the starts at 4 and 8 ms are left out, that at 12 ms is on time, and other tasks run between (L3386-3397)."""
    data = DATA + datum("jA", "joint", values=value(j1=60, j3=90, j5=90)) + datum("m", "mdesc", values=value(vel=20, blend="off"))
    busy = "while true\na[0]=a[0]+1\na[a[0]]=clock()\nfor j=1 to 1400\ni=j\nendFor\ndelay(0)\nendWhile"
    code = 'movej(jA,flange,m)\n{}waitEndMove()\nk=clock()\ntaskKill("s")'
    sync = 'taskCreateSync "s",0.004,b,busy()\ndelay(0.1)\nn=a[0]\ntaskSuspend("s")\n'
    plain = run(App(data=data, programs={"start": code.format(""), "busy": busy}), arm=True)["globals"]
    found = run(App(data=data, programs={"start": code.format(sync), "busy": busy}), arm=True, line_ns=3_000)["globals"]
    assert isinstance(plain, dict) and isinstance(found, dict) and isinstance(found["a"], list)
    assert found["n"] == 9 and found["b"] is True
    assert [round(each, 3) for each in found["a"][1:10]] == [round(0.012 * at + 0.004, 3) for at in range(9)]
    assert found["k"] == pytest.approx(plain["k"], abs=0.009), "the arm goes on with the clock"


@pytest.mark.requirement("VAL-SYNC-05", by=M + "_slice")
def test_synchronous_tasks_come_between_lines() -> None:
    programs = {
        "start": 'taskCreateSync "s", 0.004, b, w()\nwhile clock()<0.1\nn=1\nn=n+1\nif n!=2 and n!=102 and n!=101\nk=1\nendIf\nendWhile',
        "w": "while true\nn=n+100\nj=j+1\ndelay(0)\nendWhile",
    }
    found = run(App(data=DATA, programs=programs), until=0.2)["globals"]
    assert isinstance(found, dict) and found["k"] == 0 and found["j"] >= 24


@pytest.mark.requirement("VAL-WDG-01", by="gateway.pure.languages.val3.robot_state:RobotState.refresh_watchdog")
def test_the_watchdog() -> None:
    assert error_of("b=wdgRefresh()", DATA) == 45
    made = machine(
        app := App(
            data=DATA,
            programs={
                "start": (
                    "b=wdgRefresh()\nif wdgRefresh()\nn=1\nendIf\nenablePower()\ni=esStatus()\ndelay(1)\n"
                    "j=esStatus()\nb=wdgRefresh()\nk=esStatus()"
                )
            },
        )
    )
    made.robot.watchdog_ns = 500_000_000
    found = run(app, on=made)["globals"]
    assert isinstance(found, dict) and (found["n"], found["i"], found["j"], found["k"], found["b"]) == (1, 0, 2, 0, False)


@pytest.mark.parametrize(
    ("period", "code", "event", "powered", "stop"),
    [
        (0.5, "b=wdgRefresh()\ndelay(0.2)\ndisablePower()\ndelay(1)\nenablePower()", "n=0", False, 0),
        (0.5, "b=wdgRefresh()\ndelay(0.2)\ndisablePower()\ndelay(1)\nb=wdgRefresh()\nenablePower()", "n=0", True, 0),
        (0.5, "delay(2)\nb=wdgRefresh()", "estop=1", False, 2),
        (0.0, 'taskCreate "w",1,refresh()\ndelay(2)', "power=1", False, 0),
    ],
)
def test_power_needs_an_active_watchdog(period: float, code: str, event: str, powered: bool, stop: int) -> None:
    """L3555, L3570-3572: also where it expired without power; it clears its own stop only; after error 45 there is no power."""
    programs = {"start": code + "\nb=isPowered()\nk=esStatus()", "refresh": "b=wdgRefresh()"}
    made = machine(app := App(data=DATA, programs=programs))
    made.robot.watchdog_ns = round(period * 1e9)
    found = run(app, on=made, at=[(1.0, event)])["globals"]
    assert isinstance(found, dict) and (found["b"], found["k"]) == (powered, stop)


def test_the_same_input_gives_the_same_result() -> None:
    app = App(
        data=DATA,
        programs={
            "start": 'taskCreate "t", 7, w()\nfor n=1 to 5000\nlogMsg(toString("",i))\nendFor',
            "w": "while true\ni=i+1\ndelay(0)\nendWhile",
        },
    )
    assert run(app, until=0.1) == run(app, until=0.1)


def test_events_from_outside_reach_globals() -> None:
    data = DATA + datum("c", "num", "", value("k")) + datum("p", "point") + datum("g", "num", "2,2")
    at = [(0.1, "n=5"), (0.1, "a[3]=7"), (0.1, "c[k]=8"), (0.1, "p.trsf.x=9"), (0.1, "g[1,1]=4"), (0.1, "s=text")]
    found = run(App(data=data, programs={"start": "delay(1)"}), at=at)["globals"]
    assert isinstance(found, dict) and (found["n"], found["a"][3], found["c"], found["p"]["trsf"]["x"], found["g"], found["s"]) == (
        5,
        7,
        {"k": 8},
        9,
        [[0, 0], [0, 4]],
        "text",
    )


@pytest.mark.requirement("VAL-APP-06", by=M + "start")
def test_a_second_application_is_refused() -> None:
    other = App("other", DATA, {"start": "n=1"})
    made = machine(App(data=DATA, programs={"start": "delay(1)"}), other)
    first, second = made.instance("demo", "demo", ""), made.instance("other", "other", "")
    assert first is not None and second is not None
    assert made.start(first) and not made.start(second)
    assert "other is not started: demo is running" in made.log[-1]
    made.run(2_000_000_000)
    assert made.ended and made.start(second)


@pytest.mark.requirement("VAL-TASK-02", by=B + "f_delay")
def test_instructions_that_wait_give_the_turn_away() -> None:
    data = DATA + datum("port", "sio", values=value(link="Serial\\1"))
    programs = {
        "start": 'taskCreate "t1", 100, reader()\ntaskCreate "t2", 1, other()\ndelay(0.1)\ni=taskStatus("t1")\nj=n\n'
        'taskKill("t1")\ntaskKill("t2")',
        "reader": "wait(true)\nk=n\ndelay(0)\na[0]=n\nsioGet(port,a)",
        "other": "while true\nn=n+1\nendWhile",
    }
    found = run(App(data=data, programs=programs))["globals"]
    assert isinstance(found, dict)
    assert found["k"] == 0 and found["a"][0] in (0, 1) and found["i"] == 1 and found["j"] > 1000


def test_a_run_ends_when_all_tasks_are_stopped_and_nothing_is_to_come() -> None:
    parts, code = datum("n", "num"), "delay(0.5)\nn=1/n"
    found = run(App(data=parts, programs={"start": code}))
    assert found["tasks"] == {"demo~": {"status": 10, "program": "start", "line": 3}} and found["end_s"] == pytest.approx(0.5, abs=0.005)
    late = run(App(data=parts, programs={"start": code}), at=[(3.0, "n=2")])
    assert late["globals"] == {"n": 2} and late["end_s"] == 3.0
