"""Built-in instructions, called by programs.  Source: VAL 3 reference 3-6, 9."""

import pytest

from gateway.files.val3_texts import val3_language, val3_texts
from hil_tests.lab.virtual.val3_cell_bench import CELL, SETUP
from hil_tests.unit.languages.val3.apps import App, datum, error_of, globals_of, machine, run, value

N = "gateway.pure.languages.val3.numbers:"
S = "gateway.pure.languages.val3.strings:"
IO = "gateway.pure.languages.val3.builtin_io:"
G = "gateway.pure.languages.val3.builtin_geometry:"
NUMS = datum("n", "num", "40") + datum("i", "num") + datum("j", "num") + datum("b", "bool") + datum("s", "string", "12")


def numbers(*expressions: str) -> list[object]:
    """Values of expressions of type num."""
    found = globals_of("\n".join(f"n[{at}]={each}" for at, each in enumerate(expressions)), NUMS)["n"]
    assert isinstance(found, list)
    return found[: len(expressions)]


def texts(*lines: str) -> list[object]:
    """Values of expressions of type string."""
    found = globals_of("\n".join(f"s[{at}]={each}" for at, each in enumerate(lines)), NUMS)["s"]
    assert isinstance(found, list)
    return found[: len(lines)]


@pytest.mark.requirement("VAL-NUM-01", by=(N + "f_sin", N + "f_atan"))
def test_angles_are_degrees() -> None:
    found = numbers("sin(30)", "asin(0.5)", "cos(60)", "acos(0.5)", "tan(45)", "atan(1)")
    assert found == pytest.approx([0.5, 30, 0.5, 60, 1, 45], abs=1e-12)


@pytest.mark.requirement("VAL-NUM-02", by=N + "f_power")
@pytest.mark.parametrize("call", ["asin(2)", "acos(-2)", "sqrt(-1)", "ln(0)", "log(-1)", "power(0,2)", "exp(1e9)", "power(10,999)"])
def test_a_value_outside_the_domain_is_error_11(call: str) -> None:
    assert error_of(f"i={call}", NUMS) == 11


@pytest.mark.requirement("VAL-NUM-03", by=N + "f_exp")
def test_exponentials() -> None:
    found = numbers("exp(1)", "ln(2.718281828)", "log(1000)", "power(5,7)", "exp(7*ln(5))", "sqrt(9)", "abs(-3.1415)")
    assert found == pytest.approx([2.718281828459, 0.99999999983113, 3, 78125, 78125, 3, 3.1415], rel=1e-12)


@pytest.mark.requirement("VAL-NUM-04", "VAL-NUM-05", by=(N + "f_round", N + "f_limit"))
def test_rounding_and_limits() -> None:
    assert numbers("roundUp(7.8)", "roundUp(-7.8)", "roundDown(7.8)", "roundDown(-7.8)") == [8, -7, 7, -8]
    assert numbers("round(7.8)", "round(-7.8)", "round(0.5)", "round(-0.5)") == [8, -8, 1, 0]
    assert numbers("min(-1,10)", "max(-1,10)", "limit(30,-90,90)", "limit(100,-90,90)", "limit(-100,-90,90)") == [-1, 10, 30, 90, -90]
    assert numbers("sel(true,-90,90)", "sel(false,-90,90)") == [-90, 90]


@pytest.mark.requirement("VAL-BIT-01", "VAL-BIT-02", by=N + "f_b_not")
def test_bit_fields() -> None:
    code = (
        "i=2\nj=4\nn[0]=(power(2,j-i+1)-1)*power(2,i)\nn[1]=bAnd(255,bNot(n[0]))\nn[2]=bXor(0,28)\n"
        "for i=2 to j\nn[3]=bOr(n[3],power(2,i))\nendFor\nn[4]=bNot(0)"
    )
    found = globals_of(code, NUMS)["n"]
    assert isinstance(found, list) and found[:5] == [28, 227, 28, 28, 4294967295]


@pytest.mark.requirement("VAL-BIT-03", "VAL-BIT-04", by=N + "f_to_binary")
def test_numbers_as_bytes() -> None:
    data = NUMS + datum("v", "num", "6") + datum("y", "num", "48") + datum("z", "num", "6")
    code = 'v[0]=1.5\ni=toBinary(v,6,"8.0b",y)\nj=fromBinary(y,48,"8.0b",z)'
    found = globals_of(code, data)
    assert (found["i"], found["j"], found["z"]) == (48, 6, [1.5, 0, 0, 0, 0, 0])
    assert isinstance(found["y"], list) and found["y"][:8] == [63, 248, 0, 0, 0, 0, 0, 0]
    for number, form, raw in ((-2, "-2l", [254, 255]), (-2, "-2b", [255, 254]), (258, "2l", [2, 1]), (1, "4b", [0, 0, 0, 1])):
        made = globals_of(f'v[0]={number}\ni=toBinary(v,1,"{form}",y)', data)
        assert isinstance(made["y"], list) and made["y"][: len(raw)] == raw and made["i"] == len(raw)
    assert [error_of(line, data) for line in ('i=toBinary(v,1,"3b",y)', 'i=toBinary(v,7,"1",y)', 'i=toBinary(y,7,"8.0b",y)')] == [
        70,
        70,
        70,
    ]


@pytest.mark.requirement("VAL-BIT-05", by=N + "f_from_binary")
def test_damaged_bytes_are_counted_below_zero() -> None:
    data = NUMS + datum("y", "num", "48", value("20", value=300)) + datum("z", "num", "6") + datum("u", "num", "2,3")
    assert globals_of('i=fromBinary(y,48,"8.0b",z)', data)["i"] == -2


@pytest.mark.requirement("VAL-STR-01", "VAL-STR-02", by=S + "f_to_string")
def test_numbers_as_text() -> None:
    calls = ['".4",3.141592654', '"8",3.141592654', '"8.4",3.141592654', '"8.4",2.70001', '"",3.141592654', '"1.2",1234.1234']
    assert texts(*(f"toString({each})" for each in calls)) == ["3.1416", "       3", "  3.1416", "  2.7   ", "3", "1234.12"]


def test_zeros_of_a_fraction_are_blanks_without_a_size_too() -> None:
    calls = ['".4",2.5', '"0.1",10', '".2",-0.001', '"1.2",90', '"",2.4']
    assert texts(*(f"toString({each})" for each in calls)) == ["2.5   ", "10  ", "0   ", "90   ", "2"]


@pytest.mark.requirement("VAL-STR-03", "VAL-STR-04", by=S + "f_to_num")
def test_numbers_from_text() -> None:
    code = 's[0]=toNum("10 20 30",i,b)\nn[0]=i\ns[1]=toNum("a10 20 30",i,b)\nn[1]=sel(b,1,0)\ns[2]=toNum("10 end",i,b)'
    code += '\ns[3]="+90 0.0 -7.6 17.3"\nj=2\nwhile len(s[3])>0\ns[3]=toNum(s[3],n[j],b)\nj=j+1\nendWhile'
    found = globals_of(code, NUMS)
    assert isinstance(found["n"], list) and isinstance(found["s"], list)
    assert (found["s"][:4], found["n"][:6], found["b"]) == (["20 30", "a10 20 30", "", ""], [10, 0, 90, 0, -7.6, 17.3], True)


@pytest.mark.requirement("VAL-STR-05", "VAL-STR-06", by=(S + "f_mid", S + "f_asc"))
def test_characters_and_parts_of_strings() -> None:
    assert texts("chr(65)") == ["A"] and numbers('asc("A",0)', 'asc("A",1)', 'asc("A",-1)') == [65, -1, -1]
    calls = ('left("hello world",5)', 'left("hello world",20)', 'right("hello world",5)', 'right("hello world",20)')
    assert texts(*calls) == ["hello", "hello world", "world", "hello world"]
    assert texts('mid("hello wild world",4,6)', 'mid("hello wild world",20,6)') == ["wild", "wild world"]
    assert [error_of(f"s={call}", NUMS) for call in ('left("a",-1)', 'right("a",-1)', 'mid("a",-1,0)', 'mid("a",1,-1)')] == [70] * 4


@pytest.mark.requirement("VAL-STR-07", "VAL-STR-08", "VAL-STR-09", by=(S + "f_insert_text", S + "f_delete_text", S + "f_replace"))
def test_changing_strings() -> None:
    assert texts('insert("hello world","wild ",6)', 'insert("a","b",99)') == ["hello wild world", "ab"]
    assert texts('delete("hello wild world",5,6)', 'delete("abc",1,9)') == ["hello world", "abc"]
    assert texts('replace("hello ? world","wild",1,6)', 'replace("abc","x",1,9)') == ["hello wild world", "abc"]


@pytest.mark.requirement("VAL-STR-10", "VAL-STR-11", by=(S + "f_find", S + "join"))
def test_searching_and_the_longest_string() -> None:
    assert numbers('find("hello wild world","wild")', 'find("a","b")', 'len("hello wild world")', 'len("\u4e2d\u6587")') == [6, -1, 16, 2]
    long = "a" * 100
    found = texts(f'"{long}"+"{long}"', f'"{chr(0x4E2D) * 43}"+""')
    assert [len(str(each)) for each in found] == [128, 42]


DIO = (
    datum("di", "dio", values=value(link="UserIO\\in1"))
    + datum("none", "dio")
    + datum("d4", "dio", "4", "".join(value(str(k), link=f"o{k}") for k in range(4)))
)
DIO += (
    datum("ai", "aio", values=value(link="a1")) + datum("aNone", "aio") + datum("diIn", "dio", values=value(link="BasicIO-1\\%I3")) + NUMS
)


@pytest.mark.requirement("VAL-DIO-01", "VAL-DIO-05", by=IO + "io_put")
def test_outputs_take_bools_and_unlinked_ones_are_an_error() -> None:
    assert [error_of(line, DIO) for line in ("none=true", "b=none==true", "diIn=true", "i=aioGet(aNone)")] == [123, 123, 122, 123]
    found = globals_of("b=(di=true)\ndi=!di\ndi=(d4[0]==false)\nif di\ni=1\nendIf", DIO)
    assert (found["b"], found["di"], found["i"]) == (True, True, 1)


@pytest.mark.requirement("VAL-DIO-02", "VAL-DIO-03", "VAL-DIO-04", by=(IO + "f_dio_get", IO + "f_dio_set"))
def test_digital_arrays_as_numbers_and_links() -> None:
    found = globals_of(
        "n[0]=dioSet(d4,10)\nn[1]=dioGet(d4)\nn[2]=dioSet(d4,26)\nif ioStatus(di)>=0\ndioLink(none,di)\nendIf\nnone=true", DIO
    )
    assert isinstance(found["n"], list) and found["n"][:3] == [10, 10, 10] and found["di"] is True


@pytest.mark.requirement("VAL-DIO-06", "VAL-DIO-08", by=IO + "f_io_description")
def test_status_of_inputs_and_outputs() -> None:
    found = globals_of("n[0]=ioStatus(di)\nn[1]=ioStatus(none)\nn[2]=ioStatus(di,s[0],s[1])", DIO)
    assert isinstance(found["n"], list) and found["n"][:3] == [0, -1, 0]
    assert isinstance(found["s"], list) and found["s"][1] == "UserIO\\in1"


@pytest.mark.requirement("VAL-AIO-01", "VAL-AIO-02", by=IO + "f_aio_set")
def test_analog_values() -> None:
    found = globals_of("n[0]=aioSet(ai,-12.3)\nn[1]=aioGet(ai)", DIO)
    assert isinstance(found["n"], list) and found["n"][:2] == [-12.3, -12.3] and found["ai"] == -12.3


def test_a_bare_name_finds_the_input_with_a_path() -> None:
    data = DIO + datum("again", "dio", values=value(link="in1"))
    assert globals_of("again=true", data)["di"] is True


SIO = (
    datum("siPort", "sio", values=value(link="Socket\\camera"))
    + datum("siLine", "sio", values=value(link="Serial\\com1"))
    + datum("siNone", "sio")
    + NUMS
)


@pytest.mark.requirement("VAL-SIO-02", "VAL-SIO-11", "VAL-SIO-18", by=(IO + "f_sio_get", IO + "f_sio_ctrl"))
def test_sockets_nobody_answers() -> None:
    code = 'n[0]=sioCtrl(siPort,"timeout",0.5)\nn[1]=sioGet(siPort,n)\nn[2]=clock()\nn[3]=sioCtrl(siPort,"foo",1)\nn[4]=clearBuffer(siPort)'
    found = globals_of(code, SIO)["n"]
    assert (
        isinstance(found, list)
        and found[0] == 0
        and found[1] == -1
        and found[2] == pytest.approx(0.5, abs=0.006)
        and found[3:5] == [-1, -1]
    )
    assert [error_of(line, SIO) for line in ("i=sioGet(siNone,n)", 'siNone="a"', "i=siNone", 'sioCtrl(siPort,"timeout",-1)\ni=siPort')] == [
        123,
        123,
        123,
        125,
    ]


@pytest.mark.requirement("VAL-SIO-17", by=IO + "f_sio_ctrl")
def test_setting_up_a_serial_line() -> None:
    assert [globals_of(f"i=sioCtrl(siLine,{each})", SIO)["i"] for each in ('"bits", 3', '"colour", 1')] == [-3, -1]
    calls = ('"baudRate", 115200', '"bits", 8', '"parity", "none"', '"stopBits", 1', '"timeout", 0', '"endOfString", 13')
    assert numbers.__doc__ and [globals_of(f"i=sioCtrl(siLine,{each})", SIO)["i"] for each in calls] == [0] * 6
    assert globals_of('siLine="ab"\ni=sioSet(siLine,n)', SIO)["i"] == 40


GEO = (
    datum("tr", "trsf", "6")
    + datum("p", "point", "4")
    + datum("f", "frame", "2", value("0", x=100, rz=90, fatherId="world[0]") + value("1", z=10, fatherId="f[0]"))
    + datum("t", "tool", values=value(z=50, fatherId="flange[0]", otime=0.2, ctime=0.1, ioLink="valve1"))
    + datum("q", "joint", "4", value("0", j2=20, j3=60, j5=30))
    + datum("c", "config")
    + NUMS
)


@pytest.mark.requirement("VAL-TRSF-02", "VAL-TRSF-03", by=(G + "trsf_product", G + "f_interpolate_l"))
def test_transformations() -> None:
    code = (
        "tr[0]={10,20,30,20,10,30}\ntr[1]=tr[0]*!tr[0]\n"
        "tr[2]=interpolateL({0,0,0,0,0,0},{10,0,0,0,0,90},0.5)\ni=distance(tr[1],tr[2])\n"
        "tr[3]=align(tr[0],tr[4])"
    )
    found = globals_of(code, GEO)["tr"]
    assert isinstance(found, list)
    assert all(abs(each) < 1e-9 for each in found[1].values()) and found[2] == pytest.approx(
        {"x": 5, "y": 0, "z": 0, "rx": 0, "ry": 0, "rz": 45}
    )
    assert (found[3]["x"], found[3]["y"], found[3]["z"]) == pytest.approx((10, 20, 30))
    assert error_of("tr[0]=interpolateL(tr[0],tr[1],2)", GEO) == 70
    product = globals_of("tr[0]={10,0,0,0,0,90}\ntr[1]={5,0,0,30,0,0}\ntr[2]=tr[0]*tr[1]", GEO)["tr"]
    assert isinstance(product, list) and product[2] == pytest.approx({"x": 10, "y": 5, "z": 0, "rx": 0, "ry": 30, "rz": 90}, abs=1e-9)


@pytest.mark.requirement("VAL-FRM-01", "VAL-FRM-02", by=(G + "f_set_frame", G + "f_link"))
def test_frames() -> None:
    code = (
        "p[0].trsf={10,0,0,0,0,0}\np[1].trsf={10,50,0,0,0,0}\np[2].trsf={0,0,0,0,0,0}\n"
        "i=setFrame(p[0],p[1],p[2],f[1])\nj=setFrame(p[0],p[0],p[2],f[1])"
    )
    code += "\nn[0]=setFrame(p[0],p[1],p[1],f[1])\nlink(f[1],world)\ntr[0]=position(f[1],world)\ntr[1]=f[1].trsf"
    found = globals_of(code, GEO)
    assert (found["i"], found["j"]) == (0, -1) and isinstance(found["n"], list) and found["n"][0] == -2
    assert isinstance(found["tr"], list) and found["tr"][0] == pytest.approx(found["tr"][1])


@pytest.mark.requirement("VAL-PNT-01", "VAL-PNT-03", "VAL-PNT-04", by=(G + "f_appro", G + "point_in"))
def test_points() -> None:
    code = (
        "p[0].trsf={100,0,0,180,0,0}\np[1]=appro(p[0],{0,0,-100,0,0,0})\nlink(p[1],f[0])\n"
        "i=distance(p[0],p[1])\nj=distance(position(p[0],world),position(p[1],world))"
    )
    found = globals_of(code, GEO)
    assert isinstance(found["p"], list) and found["p"][1]["trsf"]["z"] == pytest.approx(100) and found["i"] == pytest.approx(found["j"])
    lost = run(App(data=GEO, programs={"start": (["point l_p"], "tr[0]=position(l_p,world)")}))["tasks"]
    assert isinstance(lost, dict) and lost["demo~"]["status"] == 162
    assert [error_of("world.trsf.x=1\ntr[0]=position(p[0],f[0])", GEO), error_of("flange.trsf.x=1\ntr[0]=position(t,flange)", GEO)] == [
        161,
        160,
    ]


@pytest.mark.requirement("VAL-PNT-05", "VAL-CFG-01", by=(G + "f_point_to_joint", G + "f_config"))
def test_kinematics_there_and_back() -> None:
    code = (
        "p[0]=jointToPoint(t,f[0],q[0])\nb=pointToJoint(t,q[0],p[0],q[1])\nc=config(q[0])\np[1].trsf.x=9999\n"
        "if !pointToJoint(t,q[0],p[1],q[2])\ni=1\nendIf\nif q[0]==q[1]\nj=1\nendIf"
    )
    found = globals_of(code, GEO, arm=True)
    assert (found["b"], found["i"], found["j"]) == (True, 1, 1) and found["c"] == {
        "shoulder": "lefty",
        "elbow": "epositive",
        "wrist": "wpositive",
    }


@pytest.mark.requirement("VAL-JNT-01", "VAL-JNT-02", by=(G + "joint_below", G + "f_is_in_range"))
def test_joints_compare_by_every_field() -> None:
    code = (
        "q[0]={90,45,45,0,30,0}\nq[1]={5,5,5,5,5,5}\nif !(abs(herej()-q[0])<q[1])\ni=1\nendIf\n"
        "q[2]={1,5,9,9,9,9}\nq[3]={0,6,0,0,0,0}\nif q[2]>q[3] or q[2]<q[3]\nj=1\nendIf"
    )
    code += "\nb=isInRange(q[0])\nq[0].j1=999\nif isInRange(q[0])\nj=2\nendIf"
    code += "\nq[2]={1,1,1,1,1,1}\nif q[2]<q[1]\nj=j+4\nendIf\nif q[1]<q[1]\nj=j+8\nendIf"
    found = globals_of(code, GEO, arm=True)
    assert (found["i"], found["j"], found["b"]) == (1, 4, True)


@pytest.mark.requirement("VAL-UI-06", "VAL-UI-08", by="gateway.pure.languages.val3.builtin_pages:f_log_msg")
def test_messages_and_dates() -> None:
    found = run(
        App(data=NUMS, programs={"start": 'popUpMsg("hello")\nb=logMsg("note",2)\ndelay(1)\ns[0]=getDate("January %d, %Y %H:%M:%S")'})
    )
    assert found["popups"] == ["hello"] and found["log"] == ["[01/01/20 00:00:00]: <0x0002> USR:note"]
    assert found["globals"] is not None and "January 01, 2020 00:00:01" in str(found["globals"])
    assert [globals_of(f'b=logMsg("note",{severity})', NUMS)["b"] for severity in (1, 4)] == [True, True]


@pytest.mark.requirement("VAL-ROB-02", "VAL-ROB-04", by="gateway.pure.languages.val3.robot_state:RobotState.set_speed")
def test_mode_and_speed() -> None:
    code = (
        "n[0]=workingMode(i)\nn[1]=setMonitorSpeed(50)\nn[2]=getMonitorSpeed()\nn[3]=setMonitorSpeed(101)\n"
        "delay(1)\nn[4]=setMonitorSpeed(60)\nn[5]=workingMode()"
    )
    found = run(App(data=NUMS, programs={"start": code}), at=[(0.5, "mode=local")])["globals"]
    assert isinstance(found, dict) and found["n"][:6] == [4, 0, 50, -3, -1, 3]


@pytest.mark.requirement("VAL-EVT-01", by="gateway.pure.languages.val3.builtin_robot:f_get_events")
def test_the_ring_of_events() -> None:
    data = NUMS + datum("ids", "num", "30") + datum("ty", "num", "30") + datum("te", "string", "30")
    code = (
        'for j=1 to 25\nlogMsg(toString("",j))\nendFor\ngetIds(ids)\ni=1\nn[0]=getEvents(i,n,ty,te)\nn[0]=i\ni=26\nj=getEvents(i,ids,ty,te)'
    )
    found = globals_of(code, data)
    assert (found["i"], found["j"]) == (26, 25) and isinstance(found["n"], list) and found["n"][0] == 6
    assert isinstance(found["te"], list) and found["te"][0] == "6" and found["te"][19] == "25"


@pytest.mark.requirement("VAL-PAY-01", by="gateway.pure.languages.val3.builtin_robot:f_set_payload")
def test_payload_codes() -> None:
    data = GEO + datum("m", "num", "3,3") + datum("v", "num", "2")
    code = (
        "n[0]=setPayload(t,-1,tr[0],m)\nm[0,1]=1\nn[1]=setPayload(t,1,tr[0],m)\nm[1,0]=1\n"
        "n[2]=setPayload(t,2,tr[0],m)\nn[3]=getPayload(t,i,tr[1],v)\nj=size(v)"
    )
    found = globals_of(code, data)
    assert isinstance(found["n"], list) and found["n"][:4] == [-4, -5, 0, 0] and (found["i"], found["j"]) == (2, 9)


@pytest.mark.requirement("VAL-PAY-01", by="gateway.pure.languages.val3.builtin_robot:f_get_payload")
@pytest.mark.parametrize(("size", "status"), [("9", -1), ("3", -1), ("3,3", -1), ("1", 71), ("10", 71), ("2,3", 71)])
def test_a_local_matrix_is_not_resized(size: str, status: int) -> None:
    """L6130."""
    app = App(data=GEO, programs={"start": ([f"num l_m[{size}]"], "n[0]=getPayload(t,i,tr[1],l_m)\nn[1]=1")})
    tasks = run(app)["tasks"]
    assert isinstance(tasks, dict) and (tasks["demo~"]["status"] if tasks else -1) == status


@pytest.mark.requirement("VAL-ERR-01", by="gateway.pure.languages.val3.errors:help_text")
def test_every_code_of_the_table_has_a_text() -> None:
    codes = [
        10,
        11,
        20,
        21,
        23,
        25,
        29,
        30,
        31,
        32,
        33,
        34,
        40,
        41,
        45,
        60,
        61,
        70,
        71,
        80,
        81,
        82,
        90,
        *range(100, 107),
        122,
        123,
        124,
        125,
        126,
    ]
    codes += [
        150,
        153,
        154,
        *range(160, 166),
        250,
        270,
        271,
        290,
        301,
        513,
        514,
        515,
        520,
        525,
        *range(530, 537),
        *range(540, 545),
        *range(550, 555),
    ]
    for code in (*codes, 570, 571, 580, 590, 600, 611, 999):
        assert texts(f"help({code})") != [""], code
    assert texts("help(5555)") == [""]


def test_help_and_log_are_in_the_language_of_the_controller() -> None:
    app = App(data=datum("s", "string", "3"), programs={"start": 's[0]=help(10)\nsetLanguage("deutsch")\ns[1]=help(10)\ns[2]=left("x",-1)'})
    controller = machine(app)
    controller.texts = val3_texts()
    found = run(app, on=controller)
    assert found["globals"] == {"s": ["invalid calculation: division by zero", "ungueltige Berechnung: Division durch null", ""]}
    assert str(found["log"]).endswith("demo~ start line 5: error 70 ungueltiger Parameterwert (size -1)']"), found["log"]
    assert (val3_language("de"), SETUP.language) == ("deutsch", val3_language(CELL.cell.language))


def test_latch_takes_the_position_of_the_edge() -> None:
    data = GEO + datum("fast", "dio", values=value(link="FastIO\\fIn0")) + datum("slow", "dio", values=value(link="x"))
    app = App(data=data, programs={"start": "setLatch(fast)\nb=watch(getLatch(q[3])==true,5)\ni=clock()"})
    found = run(app, arm=True, at=[(1.0, "dio.fIn0=1")], on=machine(app, arm=True))["globals"]
    assert isinstance(found, dict) and found["b"] is True and found["i"] == pytest.approx(1.0, abs=0.01) and found["q"][3]["j3"] == 90
    assert error_of("setLatch(slow)", data, arm=True) == 70
