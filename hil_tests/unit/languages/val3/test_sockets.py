"""Sockets, serial lines and options by VAL 3 source, with partners played by events.  Source: VAL 3 reference 3.7, 13."""

import pytest

from gateway.pure.controllers.val3.sio.calls import AnyCall
from gateway.pure.controllers.val3.sio.variable import Sio
from hil_tests.unit.languages.val3.apps import App, datum, machine, run, value

IO = "gateway.pure.languages.val3.builtin_io:"
S = "gateway.pure.languages.val3.virtual_sio:VirtualSio."
DATA = (
    datum("si", "sio", values=value(link="Socket\\client"))
    + datum("si2", "sio", values=value(link="Socket\\client"))
    + datum("srv1", "sio", values=value(link="Socket\\server"))
    + datum("srv2", "sio", values=value(link="Socket\\server"))
    + datum("line", "sio", values=value(link="Serial\\1"))
    + datum("n", "num", "12")
    + datum("d", "num", "3")
    + datum("s", "string", "4")
    + datum("i", "num")
)
UP = ((0.0, "sio.client=connect"),)


def played(
    code: str, at: tuple[tuple[float, str], ...] = (), until: float = 20.0, **programs: str
) -> tuple[list[object], dict[str, bytes]]:
    """The array n, and what was sent."""
    app = App(data=DATA, programs={"start": code, **programs})
    made = machine(app)
    data = run(app, on=made, at=at, until=20.0)["globals"]
    assert isinstance(data, dict) and isinstance(data["n"], list)
    return [*data["n"], *data["s"]], made.sio.sent


@pytest.mark.requirement("VAL-SIO-01", "VAL-SIO-03", "VAL-SIO-04", by=IO + "f_sio_get")
def test_reading_waits_as_its_time_out_says() -> None:
    code = (
        'sioCtrl(si,"timeout",0)\ntaskCreate "r",10,reader()\ndelay(1)\nn[0]=taskStatus("r")\ndelay(2)\n'
        'sioCtrl(si,"timeout",-1)\nn[4]=sioGet(si,d)\nn[5]=sioGet(si,d)'
    )
    found, _ = played(code, (*UP, (2.0, "sio.client=hex:0102030405")), reader="n[1]=sioGet(si,d)\nn[2]=d[2]\nn[3]=clock()")
    assert found[:6] == [1, 3, 3, pytest.approx(2.0, abs=0.01), 2, 0]


@pytest.mark.requirement("VAL-SIO-04", by=IO + "f_sio_get")
def test_a_poll_of_a_synchronous_task_takes_its_line_and_no_cycle() -> None:
    """Without a partner, with one that says nothing, and with one that goes: a cycle ends at delay alone."""
    code = 'sioCtrl(srv1,"timeout",-1)\ntaskCreateSync "p",0.004,b,poll()\ndelay(3)\ntaskKill("p")'
    poll = "while true\nn[0]=sioGet(srv1,d)+2\nn[n[0]]=n[n[0]]+1\ndelay(0)\nendWhile"
    app = App(data=DATA + datum("b", "bool"), programs={"start": code, "poll": poll})
    at = ((1.0, "sio.server=connect"), (2.0, "sio.server=disconnect"))
    data = run(app, at=at, until=5.0)["globals"]
    assert isinstance(data, dict)
    assert data["n"][1] == pytest.approx(500, abs=2) and data["n"][2] == pytest.approx(250, abs=2)


@pytest.mark.requirement("VAL-SIO-04", by=IO + "f_sio_get")
def test_bytes_that_are_there_are_read_without_the_network(monkeypatch: pytest.MonkeyPatch) -> None:
    code = 'sioCtrl(srv1,"timeout",-1)\nn[0]=sioGet(srv1,d)\nwait(clock()>1)\ntaskCreateSync "p",0.004,b,read()\ndelay(0.1)'
    read = "while sioGet(srv1,d[2])==1\nn[1]=n[1]+d[2]\nendWhile\nwait(false)"
    app = App(data=DATA + datum("b", "bool"), programs={"start": code, "read": read})
    made = machine(app)
    looks: list[int] = []
    settle = made.sio.settle

    def look() -> None:
        looks.append(made.clock)
        settle()

    monkeypatch.setattr(made.sio, "settle", look)
    at = ((0.4, "sio.server=connect"), (0.5, "sio.server=hex:" + "01" * 500))
    data = run(app, on=made, at=at, until=3.0)["globals"]
    assert isinstance(data, dict) and data["n"][1] == 500
    assert 0 < sum(1 for when in looks if when > 1_000_000_000) < 10


@pytest.mark.requirement("VAL-SIO-05", "VAL-SIO-10", by=S + "disconnect")
def test_a_partner_that_goes_and_a_time_out_of_an_operator() -> None:
    code = (
        'sioCtrl(si,"timeout",5)\nn[0]=sioGet(si,d)\nn[1]=clock()\nsioCtrl(line,"timeout",1)\ntaskCreate "t",10,text()\ndelay(2)\n'
        'n[2]=taskStatus("t")\ntaskKill("t")\nn[3]=sioGet(line,d)'
    )
    found, _ = played(code, (*UP, (1.0, "sio.client=disconnect")), text="s[0]=line")
    assert found[:4] == [-1, pytest.approx(1.0, abs=0.01), 125, 0]


@pytest.mark.requirement("VAL-SIO-06", "VAL-SIO-07", "VAL-SIO-09", by=IO + "f_sio_set")
def test_what_is_sent() -> None:
    code = (
        'd[0]=256.4\nd[1]=-1\nd[2]=66\nn[0]=sioSet(si,d)\nn[1]=sioSet(si,d[2])\ns[0]=(si="ab")\ni=(si=65.4)\nn[2]=i\n'
        'taskCreate "t",10,more()\ndelay(0.1)\nn[3]=taskStatus("t")\ntaskKill("t")'
    )
    found, sent = played(code, UP, more="sioSet(si,d,4)")
    assert found[:4] == [3, 1, 65, 20] and found[12] == "ab" and sent["Socket\\client"] == b"\x00\xffBBab\rA"


@pytest.mark.requirement("VAL-SIO-08", by=IO + "sio_read_string")
def test_strings_end_with_their_character_or_at_128_bytes() -> None:
    found, _ = played(
        'sioCtrl(si,"endOfString",13)\ns[0]=si\ni=si\nn[0]=i\ns[1]=si\nn[1]=len(s[1])',
        (*UP, (0.5, "sio.client=ab\\rc"), (0.6, "sio.client=" + "x" * 128)),
    )
    assert found[12] == "ab" and found[0] == 99 and found[1] == 128


@pytest.mark.requirement("VAL-SIO-13", "VAL-SIO-14", "VAL-SIO-16", by=S + "settle")
def test_a_client_is_shared_and_a_server_has_a_connection_a_variable() -> None:
    code = (
        'sioCtrl(srv1,"clients",2)\nsioCtrl(srv1,"timeout",3)\nd[0]=1\nsioSet(si,d)\nsioSet(si2,d)\n'
        'taskCreate "a",10,first()\ntaskCreate "b",10,second()\ndelay(3)\nn[4]=clearBuffer(si)\nn[5]=clearBuffer(si)'
    )
    made = machine(app := App(data=DATA, programs={"start": code, "first": "n[0]=sioGet(srv1,n[1])", "second": "n[2]=sioGet(srv2,n[3])"}))
    at = [(0.0, "sio.client=connect"), *((1.0, "sio.server=connect"),) * 3, (2.0, "sio.server.1=hex:0b"), (2.0, "sio.server.2=hex:0c")]
    found = run(app, on=made, at=at)["globals"]
    assert isinstance(found, dict)
    assert (found["n"][0], found["n"][1], found["n"][2], found["n"][3]) == (1, 11, 1, 12)
    assert found["n"][5] == -1 and made.sio.sent["Socket\\client"] == b"\x01\x00\x00\x01\x00\x00"


@pytest.mark.requirement("VAL-CAX-01", "VAL-OEM-01", by="gateway.pure.languages.val3.builtin_moves:f_reset_turn")
def test_turns_and_licences() -> None:
    data = (
        datum("q", "joint", "3", value("0", j3=90, j5=90, j6=200))
        + datum("m", "mdesc", values=value(blend="off"))
        + datum("s", "string", "2")
    )
    code = (
        "movej(q[0],flange,m)\nwaitEndMove()\nq[1].j6=-160\nq[2]=resetTurn(q[1])\nq[1]=herej()\n"
        's[0]=getLicence("oem","x")\ns[1]=getLicence("other","x")'
    )
    made = machine(app := App(data=data, programs={"start": code}), arm=True)
    made.licences = {"oem": "enabled"}
    found = run(app, on=made)["globals"]
    assert isinstance(found, dict) and found["s"] == ["enabled", ""]
    assert (
        found["q"][2]["j6"] == pytest.approx(-160)
        and found["q"][1]["j6"] == pytest.approx(-160)
        and found["q"][1]["j3"] == pytest.approx(90)
    )


@pytest.mark.parametrize(("option", "found"), [("", "oemLicenceDisabled"), ("oemlicence", "")])
def test_a_licence_cannot_be_tested_without_the_option(option: str, found: str) -> None:
    made = machine(app := App(data=datum("s", "string"), programs={"start": 's=getLicence("oem","x")'}), arm=True)
    made.robot.components = {option: "enabled"}
    assert run(app, on=made)["globals"] == {"s": found}


@pytest.mark.requirement("VAL-DH-01", by="gateway.pure.languages.val3.builtin_robot:f_get_default_dh")
def test_the_chain_of_the_arm_leads_where_joint_to_point_leads() -> None:
    data = "".join(datum(name, "num", "7") for name in ("th", "dd", "aa", "al", "be"))
    data += datum("q", "joint", values=value(j1=10, j2=20, j3=60, j4=5, j5=30, j6=40))
    data += datum("t", "trsf", "2") + datum("p", "point") + datum("k", "num") + datum("e", "num")
    code = (
        "getDefaultDH(th,dd,aa,al,be)\nt[0]={0,0,0,0,0,q.j1+th[0]}\n"
        + "".join(f"t[0]=t[0]*{{aa[{k}],0,dd[{k}],al[{k}],be[{k}],q.j{k + 2}+th[{k + 1}]}}\n" for k in range(5))
        + "t[0]=t[0]*{aa[5],0,dd[5],al[5],be[5],0}\np=jointToPoint(flange,world,q)\ne=distance(t[0],p.trsf)"
    )
    found = run(App(data=data, programs={"start": code}), arm=True)
    assert isinstance(found["globals"], dict) and found["tasks"] == {}, found["log"]
    assert found["globals"]["e"] == pytest.approx(0, abs=1e-6) and found["globals"]["t"][0]["x"] != 0


@pytest.mark.requirement("VAL-SIO-04", by=IO + "f_sio_get")
@pytest.mark.parametrize("end", ['taskKill("r")', 'taskSuspend("r")\ntaskResume("r",1)'])
def test_a_task_that_reads_no_more_takes_nothing_from_those_that_do(end: str) -> None:
    code = f'taskCreate "r",10,reader()\ndelay(0.5)\n{end}\nn[0]=sioGet(si,d)\nn[1]=d[0]\nn[2]=clock()\ns[0]=si'
    at = (*UP, (1.0, "sio.client=hex:07"), (2.0, "sio.client=hex:61620d"))
    found, _ = played(code, at, reader="s[1]=si\ndelay(99)")
    assert found[:3] == [1, 7, pytest.approx(1.0, abs=0.01)] and found[12:14] == ["ab", ""]


@pytest.mark.requirement("VAL-TASK-03", by="gateway.pure.languages.val3.builtin_tasks:f_watch")
def test_wait_and_watch_take_conditions_that_read() -> None:
    poll = 'sioCtrl(si,"timeout",-1)\nn[0]=sel(watch(sioGet(si,d)>0,0.5),1,2)\nn[1]=clock()\nwait(sioGet(si,d)>0 and d[0]==9)\nn[2]=clock()'
    moment = pytest.approx
    found, _ = played(poll, (*UP, (1.0, "sio.client=hex:09")))
    assert found[:3] == [2, moment(0.5, abs=0.01), moment(1.0, abs=0.01)]
    found, _ = played("n[0]=sel(watch(sioGet(si,d)>0,0.5),1,2)\nn[1]=clock()", (*UP, (1.0, "sio.client=hex:09")))
    assert found[:2] == [1, moment(1.0, abs=0.01)], "a read that waits for ever ends first"
    cyclic = 'sioCtrl(si,"timeout",-1)\ntaskCreateSync "p",0.004,b,poll()\ndelay(2)\ntaskKill("p")'
    app = App(data=DATA + datum("b", "bool"), programs={"start": cyclic, "poll": "wait(sioGet(si,d)>0)\nn[0]=clock()\nwait(false)"})
    data = run(app, at=(*UP, (1.0, "sio.client=hex:09")), until=5.0)["globals"]
    assert isinstance(data, dict) and data["n"][0] == moment(1.0, abs=0.005)


@pytest.mark.requirement("VAL-SIO-15", by="gateway.pure.languages.val3.controller:Controller.forget_sockets")
def test_a_client_stays_open_while_a_global_variable_refers_to_it() -> None:
    """A local variable and a parameter by value end with their programs, the connection of the global one does not (L2648)."""
    at = (*UP, (0.5, "sio.client=a\\r"), (1.5, "sio.client=b\\r"), (3.5, "sio.client=c\\r"))
    programs: dict[str, str | tuple[list[str], str]] = {"ask": (["sio l_si"], "sioLink(l_si,si)\ns[i]=l_si\ni=i+1")}
    programs["value(sio x_si)"] = "s[i]=x_si\ni=i+1"
    code = "call ask()\ndelay(2)\ncall value(si)\ndelay(2)\ncall ask()"
    found = run(App(data=DATA, programs={"start": code, **programs}), at=at, until=9.0)["globals"]
    assert isinstance(found, dict) and found["s"][:3] == ["a", "b", "c"]


def test_variables_of_programs_leave_nothing_behind(monkeypatch: pytest.MonkeyPatch) -> None:
    programs = {"value(sio x_si)": (["sio l_si"], "sioLink(l_si,x_si)\nx_si=1\nl_si=2")}
    made = machine(app := App(data=DATA, programs={"start": "for i=1 to 50\ncall value(si)\nendFor\nn[0]=1", **programs}))
    core, count = made.sio.core, {"made": 0, "deleted": 0}
    variable, delete = core.variable, core.delete

    def makes(link: str | None = None) -> Sio:
        count["made"] += 1
        return variable(link)

    def deletes(sio: Sio) -> list[AnyCall]:
        count["deleted"] += 1
        return delete(sio)

    monkeypatch.setattr(core, "variable", makes)
    monkeypatch.setattr(core, "delete", deletes)
    run(app, on=made, at=UP)
    assert count == {"made": 105, "deleted": 100}, "five are those of the data"


def test_a_killed_task_and_a_new_link_give_their_connection_to_a_server_free() -> None:
    start = 'sioCtrl(srv1,"timeout",0)\nsioCtrl(srv1,"clients",1)\n'
    at = [(float(second), f"sio.server={what}") for second, what in ((1, "connect"), (2, "disconnect"), (2.5, "connect"), (3, "hex:07"))]
    programs = {"reader": (["sio l_si"], "sioLink(l_si,srv1)\nn[1]=sioGet(l_si,d)\nn[2]=d[0]")}
    code = (
        start
        + 'taskCreate "r",10,reader()\ndelay(1.5)\nn[0]=taskStatus("r")\ntaskKill("r")\ntaskCreate "r",10,reader()\ndelay(3)\ntaskKill("r")'
    )
    found = run(App(data=DATA, programs={"start": code, **programs}), at=at[:1] + at[2:])["globals"]
    assert isinstance(found, dict) and found["n"][:3] == [1, 1, 7]
    code = start + 'taskCreate "r",10,other()\ndelay(1.5)\ntaskKill("r")\nsioLink(srv1,si)\nn[1]=sioGet(srv2,d)\nn[2]=d[0]'
    found = run(App(data=DATA, programs={"start": code, "other": "sioGet(srv1,d)"}), at=at[:1] + at[2:])["globals"]
    assert isinstance(found, dict) and found["n"][:3] == [0, 1, 7]


@pytest.mark.requirement("VAL-SIO-15", by="gateway.pure.languages.val3.builtin_io:f_delete_of_sockets")
@pytest.mark.parametrize(
    ("name", "drop"),
    [
        ("siA[1]", "delete(siA[1])"),
        ("siA[1]", "resize(siA,1,1)"),
        ('siC["b"]', 'delete(siC["b"])'),
        ("link.si[1]", "delete(link.si[1])"),
    ],
)
def test_a_deleted_element_gives_its_connection_to_a_server_free(name: str, drop: str) -> None:
    """Of arrays, collections and components (L2646)."""
    code = f'sioCtrl(siA,"clients",1)\nsioLink({name},siA)\nn[0]=sioGet({name},d)\n{drop}\nn[1]=sioGet(siA,d)\nn[2]=d[0]'
    at = [(float(second), f"sio.server={what}") for second, what in ((1, "connect"), (2, "hex:05"), (3, "connect"), (4, "hex:07"))]
    data = (
        DATA
        + datum("siA", "sio", "2", value("0", link="Socket\\server"))
        + datum("link", "Link", "1")
        + datum("siC", "sio", "", value("b"))
    )
    types = '<Type name="Link" path="Disk://chan/chan.pjx" />'
    found = run(App(data=data, programs={"start": code}, types=types), App("chan", datum("si", "sio", "2")), at=at)["globals"]
    assert isinstance(found, dict) and found["n"][:3] == [1, 1, 7]
