"""Applications as the editors of s7 and s8 write them: what the manual does not say, but files of real controllers show (AX-991)."""

from typing import Any

from gateway.pure.languages.val3.disk import Disk
from gateway.pure.languages.val3.loader import Loader
from gateway.pure.languages.val3.machine import Machine
from gateway.pure.languages.val3.virtual import Run, declare_links
from gateway.pure.languages.val3.virtual_events import event_of
from hil_tests.unit.languages.val3.apps import SPACE, XSI, App, error_of, faults_of, globals_of, machine

Files = dict[str, str]


def pgx(name: str, code: str, parameters: str = "", locals_: str = "") -> str:
    """A program as the editor indents it; no `access`: private."""
    return (
        f'<?xml version="1.0" encoding="utf-8"?>\n<Programs {XSI} xmlns="{SPACE}Program/2">\n  <Program name="{name}">\n'
        f"    <Description></Description>\n{parameters}{locals_}    <Code><![CDATA[begin\n{code}\nend]]></Code>\n  </Program>\n</Programs>"
    )


def project(name: str, programs: Files, data: str, *, folder: str = "", types: str = "", version: str = "s7.11.2") -> Files:
    """Its files on the disk; programs may lie in sub-folders."""
    folder = folder or name
    listed = "".join(f'    <Program file="{path}" />\n' for path in programs)
    made = {
        f"{folder}/{name}.pjx": (
            f'<?xml version="1.0" encoding="utf-8"?>\n<Project xmlns="{SPACE}Project/3">\n  <Parameters version="{version}" '
            f'stackSize="5000" millimeterUnit="true" />\n  <Programs>\n{listed}  </Programs>\n  <Database>\n    '
            f'<Data file="{name}.dtx" />\n  </Database>\n  <Libraries />\n  <Types>{types}</Types>\n</Project>'
        ),
        f"{folder}/{name}.dtx": f'<Database {XSI} xmlns="{SPACE}Data/2">\n  <Datas>\n{data}  </Datas>\n</Database>',
    }
    return made | {f"{folder}/{path}": text for path, text in programs.items()}


def data(name: str, kind: str, value: str = "", size: str = "1") -> str:
    """A Data element; attributes that are the default are left out, as the controller does."""
    inner = f"<Value {value} />" if value else ""
    return f'    <Data name="{name}" access="private" xsi:type="array" type="{kind}" size="{size}">{inner}</Data>\n'


def played(files: Files, name: str, *at: tuple[float, str], until: float = 10.0) -> dict[str, object]:
    """Loads without a fault and runs."""
    made = Machine(Disk({path: text.encode() for path, text in files.items()}), machine(App(), arm=True).moves_or_none)
    loaded = made.loader.load(name, name)
    assert loaded is not None
    assert not loaded.faults.errors, [fault.text for fault in loaded.faults]
    own = made.instance(name, name, "")
    assert own is not None, made.log
    declare_links(made, own.data.values())
    going = Run(made, own, round(until * 1e9), [event_of(str(seconds), what) for seconds, what in at])
    going.go()
    return going.result()


NUMBER = '<Parameter name="x_nValue" type="num" xsi:type="element" use="reference" />'


def test_programs_whose_names_begin_with_an_underscore() -> None:
    programs = {
        "_mainLoop.pgx": pgx("_mainLoop", "  while bRun\n    call _next(nCount)\n    bRun = nCount < 3\n    delay(0.01)\n  endWhile"),
        "Comm/_next.pgx": pgx("_next", "  x_nValue = x_nValue + 1", f"<Parameters>{NUMBER}</Parameters>"),
        "start.pgx": pgx("start", '  bRun=true\n  taskCreate "mainLoop", 100, _mainLoop()\n  wait(taskStatus("mainLoop")==-1)'),
        "stop.pgx": pgx("stop", ""),
    }
    found = played(project("_cell", programs, data("bRun", "bool") + data("nCount", "num")), "_cell")
    assert found["globals"] == {"bRun": False, "nCount": 3} and found["tasks"] == {}


MESSAGE = data("jPos", "jointRx") + data("nRaw", "num") + data("nForce", "num", size="6")
PUBLIC = {"private": "public"}
ENCODE = """  resize(x_m.nRaw, 1, 13)
  l_n = 1
  toBinary(x_m.jPos.j1, 4, "4.0l",x_m.nRaw[l_n])
  toBinary(x_m.nForce[5], 4, "4.0l", x_m.nRaw[l_n+4])
  x_m.nForce[0] = fromBinary(x_m.nRaw[l_n], 4, "4.0l", x_m.jPos.j2)
  if(size(x_m.nRaw) != 13 and !bOver)
    logMsg("size " + toString("",size(x_m.nRaw)),2)
  endIf"""
FIELDS = '<Parameter name="x_m" type="Msg" xsi:type="element" use="reference" />'


def _message(version: str) -> Files:
    types = '<Type name="Msg" path="Disk://app/Types/Msg/Msg.pjx" />'
    programs = {
        "Serialization/encode.pgx": pgx(
            "encode",
            ENCODE,
            f"<Parameters>{FIELDS}</Parameters>",
            '<Locals><Local name="l_n" type="num" xsi:type="array" size="1" /></Locals>',
        ),
        "control.pgx": pgx(
            "control",
            "  l_m.jPos.j1 = 1.5\n  l_m.nForce[5] = -2\n  call encode(l_m)\n"
            "  nByte = l_m.nRaw[3]\n  nJ2 = l_m.jPos.j2\n  nLast = l_m.nRaw[8]",
            locals_='<Locals><Local name="l_m" type="Msg" xsi:type="array" size="1" /></Locals>',
        ),
        "start.pgx": pgx("start", '  taskCreateSync "control", 0.004, bOver, control()\n  wait(taskStatus("control")!=1)'),
        "stop.pgx": pgx("stop", ""),
    }
    own = data("bOver", "bool") + data("nByte", "num") + data("nJ2", "num") + data("nLast", "num")
    message = project("Msg", {}, MESSAGE.replace("private", "public"), folder="app/Types/Msg")
    return project("app", programs, own, types=types, version=version) | message


def test_a_field_is_an_array_of_one_value_for_an_instruction() -> None:
    found = played(_message("s8.20.2Cs9_BS4270"), "app")
    assert found["globals"] == {"bOver": False, "nByte": 192, "nJ2": 1.5, "nLast": 192}, found["log"]


def test_more_values_than_there_are_is_an_error_up_to_s7() -> None:
    tasks = played(_message("s7.9"), "app")["tasks"]
    assert isinstance(tasks, dict) and tasks["control"]["status"] == 70 and tasks["control"]["program"] == "encode"


BYTE: dict[str, Any] = {"one(num& x)": 'toBinary(x,1,"1",x)'}
WORD: dict[str, Any] = {"one(num& x)": 'toBinary(x,1,"2l",x)'}


def test_a_parameter_by_reference_and_an_entry_are_arrays_of_one_value() -> None:
    parts = data("n", "num") + data("a", "num", size="4")
    parts += '<Data name="c" access="public" xsi:type="collection" type="num"><Value key="x" value="9" /></Data>'
    code = 'call one(a[1])\nn=toBinary(c["x"],1,"2l",a[2])\nfromBinary(a[2],2,"2b",c["x"])'
    found = globals_of(code, parts, **BYTE)
    assert (found["n"], found["a"], found["c"]) == (2, [0, 0, 9, 0], {"x": 2304})
    assert error_of("call one(a[1])", parts, **WORD) == 70, "two bytes into one value"


def test_text_page_of_s7_with_entries() -> None:
    parts = data("nKey", "num", size="3") + data("sName", "string") + data("nVal", "num") + data("scPage", "screen")
    code = '  title("Setup")\n  nKey[0]=get(sName)\n  nKey[1]=get(scPage, nVal)\n  nKey[2]=get()\n  userPage(scPage)\n  putln(nVal)'
    files = project("app", {"start.pgx": pgx("start", code), "stop.pgx": pgx("stop", "")}, parts)
    found = played(files, "app", (1.0, "answer=ok:Box"), (2.0, "answer=ok:none"), (2.5, "answer=ok:4.5"), (3.0, "answer=ok:A"))
    values = found["globals"]
    assert isinstance(values, dict) and (values["nKey"], values["sName"], values["nVal"]) == ([270, 270, 65], "Box", 4.5)
    values = played(files, "app")["globals"]
    assert isinstance(values, dict) and (values["nKey"], values["sName"]) == ([255, 255, 255], ""), "without an operator: Esc"


def test_the_log_has_a_line_of_the_text_page_as_a_whole() -> None:
    files = project(
        "app",
        {"start.pgx": pgx("start", '  put("old")\n  gotoxy(0,3)\n  put("n=")\n  putln(7)\n  putln("end")'), "stop.pgx": pgx("stop", "")},
        "",
    )
    log = played(files, "app")["log"]
    assert isinstance(log, list) and [line.partition("SCREEN:")[2] for line in log] == ["n=7", "end"]


def test_keys_of_the_pendant() -> None:
    parts = data("nKey", "num", size="5") + data("bDown", "bool") + data("n", "num") + data("sc", "screen") + data("nNone", "num")
    code = """  setTextMode(1)
  setTextMode(sc,0)
  nNone=getKey()
  while n<3
    nKey[n]=getKey()
    n=n+sel(nKey[n]>=0,1,0)
    delay(0.02)
  endWhile
  wait(isKeyPressed(276) and !isKeyPressed(sc,277))
  bDown=true
  nKey[3]=get(sc)
  nKey[4]=getKey(sc)"""
    files = project("app", {"start.pgx": pgx("start", code), "stop.pgx": pgx("stop", "")}, parts)
    keys = ((0.1, "key=A"), (0.2, "key=1"), (0.2, "key=271"), (0.5, "key=276"))
    found = played(files, "app", *keys)["globals"]
    assert isinstance(found, dict) and found["nKey"] == [65, 49, 271, 276, -1]
    assert (found["bDown"], found["nNone"]) == (True, -1)


def test_a_project_of_s6_is_refused_by_name() -> None:
    old = b'<?xml version="1.0"?>\n<project xmlns="ProjectNameSpace">\n  <parameters version="s6.8" stackSize="5000" />\n</project>'
    found = Loader(Disk({"old/old.pjx": old})).load("old", "old")
    assert found is not None
    assert [fault.text for fault in found.faults] == ["the file was written by s6.8; s7 and s8 are read, s6 and older are not"]


def test_world_and_flange_of_an_s7_data_file() -> None:
    parts = data("world", "frame", 'key="0"') + data("flange", "tool", 'key="0" fatherId="flange[0]"')
    parts += data("fPart", "frame", 'key="0" x="10" fatherId="world[0]"') + data("pA", "pointRx", 'key="0" y="5" fatherId="fPart[0]"')
    parts += data("trA", "trsf")
    found = played(project("app", {"start.pgx": pgx("start", "  trA=position(pA,world)"), "stop.pgx": pgx("stop", "")}, parts), "app")
    values = found["globals"]
    assert isinstance(values, dict) and (values["trA"]["x"], values["trA"]["y"]) == (10, 5), found["log"]


def test_add_ons_load_with_a_warning_and_stop_with_250() -> None:
    code = "  nA = $getBoxcarDelay()"
    files = project("app", {"start.pgx": pgx("start", code), "stop.pgx": pgx("stop", "")}, data("nA", "num"))
    tasks = played(files, "app")["tasks"]
    assert isinstance(tasks, dict) and tasks["app~"]["status"] == 250
    loops = "while $more()\ni=i+1\nendWhile", "for i=0 to $last()\nendFor", "if i==1\ni=2\nelseIf $x(i)\nendIf", "call $go()\ni=1"
    for code in ("$setBoxcarFreq(60)", "movejf(i)", "if isCompliant()\ni=1\nendIf", *loops):
        parts = data("i", "num")
        found = played(project("app", {"start.pgx": pgx("start", code), "stop.pgx": pgx("stop", "")}, parts), "app")["tasks"]
        assert isinstance(found, dict) and found["app~"]["status"] == 250, code


def test_sizes_of_tables_as_controllers_write_them() -> None:
    """Sizes with a blank, keys with a comma: s7.9 and s8.8 (AX-1758)."""
    own = (
        '    <Data name="n" access="private" xsi:type="array" type="num" size="3 2"><Value key="2,1" value="7" /></Data>\n'
        + data("m", "num")
        + data("k", "num", size="3")
    )
    locals_ = '<Locals><Local name="l_n" type="num" xsi:type="array" size="1 30" /></Locals>'
    code = '  l_n[0,29]=n[2,1]\n  k[0]=size(n,1)\n  k[1]=size(n,2)\n  k[2]=size(l_n,2)\n  m=l_n[0,29]+libSave("copy")'
    files = project("demo", {"start.pgx": pgx("start", code, locals_=locals_), "stop.pgx": pgx("stop", "")}, own)
    disk = Disk({path: text.encode() for path, text in files.items()})
    made = Machine(disk)
    loaded = made.instance("demo", "demo", "")
    assert loaded is not None, made.log
    going = Run(made, loaded, 10**9, [])
    going.go()
    found: Any = going.result()["globals"]
    assert (found["m"], found["k"]) == (7, [3, 2, 30]), made.log
    saved = made.disk.files
    assert b'size="3 2"' in saved["copy/copy.dtx"] and b'key="2,1"' in saved["copy/copy.dtx"]
    assert b'size="1 30"' in saved["copy/start.pgx"]


def test_times_of_a_tool_as_s8_writes_them() -> None:
    tool = data("tGrip", "tool", 'key="0" z="62.5" fatherId="flange[0]" ioLink="ValveIO\\valve1" ioOpen="0.5" ioClose="0.25"')
    numbers = "".join(data(name, "num") for name in ("nOpen", "nClose", "nTime"))
    code = "  nOpen=tGrip.otime\n  nClose=tGrip.ctime\n  open(tGrip)\n  nTime=clock()"
    found = played(project("grip", {"start.pgx": pgx("start", code), "stop.pgx": pgx("stop", "")}, tool + numbers), "grip")["globals"]
    assert isinstance(found, dict)
    assert (found["nOpen"], found["nClose"], round(found["nTime"], 2)) == (0.5, 0.25, 0.5)


def test_libsave_writes_the_times_of_a_tool_as_s8_does() -> None:
    tool = data("tGrip", "tool", 'key="0" ioOpen="0.5"')
    files = project("grip", {"start.pgx": pgx("start", '  libSave("copy")'), "stop.pgx": pgx("stop", "")}, tool)
    made = Machine(Disk({path: text.encode() for path, text in files.items()}))
    own = made.instance("grip", "grip", "")
    assert own is not None
    Run(made, own, 10**9, []).go()
    saved = made.disk.read("copy/copy.dtx")
    assert saved is not None and b'ioOpen="0.5"' in saved and b"otime" not in saved


def test_arrays_of_more_values_than_a_program_can_make() -> None:
    """Applications of s8.15 have them; append and resize keep their limit (L1141)."""
    programs = {"start.pgx": pgx("start", "  nRecord[9999]=5\n  nSize=size(nRecord)\n  append(nRecord)"), "stop.pgx": pgx("stop", "")}
    found = played(project("record", programs, data("nRecord", "num", size="10000") + data("nSize", "num")), "record")
    assert isinstance(found["globals"], dict) and isinstance(found["tasks"], dict)
    assert found["globals"]["nSize"] == 10000 and found["tasks"]["record~"]["status"] == 40


def test_names_of_tasks_from_s8_on() -> None:
    code = '  taskCreate "N15_AproAgafarPuntes",50,work()\n  nStatus=taskStatus("N15_AproAgafarPuntes")'
    programs = {"start.pgx": pgx("start", code), "stop.pgx": pgx("stop", ""), "work.pgx": pgx("work", "  delay(0.1)")}
    found = played(project("long", programs, data("nStatus", "num"), version="s8.8.3cs9_BS1660"), "long")
    assert found["globals"] == {"nStatus": 1} and found["tasks"] == {}
    old = played(project("long", programs, data("nStatus", "num")), "long")["tasks"]
    assert isinstance(old, dict) and old["long~"]["status"] == 29


def test_variables_for_opc_ua_are_a_warning() -> None:
    code = "  opcuaExport(nCount,true)\n  opcuaExport(sText,false)\n  opcuaExport(bOn[1],true)\n  nCount=opcuaExport(nCount,true)+1"
    variables = data("nCount", "num") + data("sText", "string") + data("bOn", "bool", size="2")
    files = project("opc", {"start.pgx": pgx("start", code), "stop.pgx": pgx("stop", "")}, variables, version="s8.15.3Cs9_BS3337")
    loaded = Loader(Disk({path: text.encode() for path, text in files.items()})).load("opc", "opc")
    assert loaded is not None
    found = [(each.severity.value, each.position.line, each.text) for each in loaded.faults]
    assert found == [("warning", line, "'opcuaExport' : there is no OPC UA server, it has no effect") for line in (2, 3, 4, 5)]
    assert played(files, "opc")["globals"] == {"nCount": 1, "sText": "", "bOn": [False, False]}
    wrong = [fault for _, fault in faults_of("opcuaExport(5,true)\nopcuaExport(n,5)", data("n", "num")) if "'5'" in fault]
    assert wrong == ["'5' : variable expected as parameter", "'5' : invalid type"]


def test_get_waits_for_a_key_that_is_pressed_later() -> None:
    code = "  nKey[0]=get()\n  nTime[0]=clock()\n  nKey[1]=get()\n  nTime[1]=clock()"
    files = project(
        "keys",
        {"start.pgx": pgx("start", code), "stop.pgx": pgx("stop", "")},
        data("nKey", "num", size="2") + data("nTime", "num", size="2"),
    )
    keys = ((0.5, "key=271"), (1.0, "key=A"))
    for at in (keys, (*keys, (9.0, "answer=ok"))):
        found = played(files, "keys", *at)["globals"]
        assert isinstance(found, dict) and found["nKey"] == [271, 65]
        assert [round(each, 1) for each in found["nTime"]] == [0.5, 1.0]
    found = played(files, "keys")["globals"]
    assert isinstance(found, dict) and found["nKey"] == [255, 255]
