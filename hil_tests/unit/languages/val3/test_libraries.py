"""Libraries, user types, files.  Source: VAL 3 reference 6, 7; S8 note N01."""

import pytest

from gateway.pure.languages.val3.disk import Disk, PathFault, application_of, resolve
from gateway.pure.languages.val3.loader import Loader
from gateway.pure.languages.val3.machine import Machine
from gateway.pure.languages.val3.references import element
from gateway.pure.languages.val3.values import PointV
from gateway.pure.languages.val3.virtual import shown_container
from hil_tests.unit.languages.val3.apps import App, check, datum, disk, error_of, globals_of, machine, run, value

L = "gateway.pure.languages.val3.builtin_libraries:"
DATA = "".join(datum(name, "num") for name in ("n", "i", "j", "k")) + datum("b", "bool") + datum("s", "string", "6")
PART = App(
    "part",
    datum("nX", "num", values=value(value=3))
    + datum("pPath", "num", "3", value("1", value=5))
    + datum("sText", "string")
    + datum("hidden", "num", access="private"),
    {"init": "nX=nX+1", "tasks": 'taskCreate "inner", 1, wait9()', "wait9": "delay(9)"},
)
USES = '<Library alias="part" path="Disk://part/part.pjx" /><Library alias="again" path="./../part" />'


def using(code: str, *others: App) -> dict[str, object]:
    """Data after start() ran this code with the library."""
    found = run(App(data=DATA, libraries=USES, programs={"start": code}), PART, *others)
    data = found["globals"]
    assert isinstance(data, dict), found["log"]
    return data


@pytest.mark.requirement("VAL-LIB-01", "VAL-LIB-05", by="gateway.pure.languages.val3.machine:Machine.load_library")
def test_two_identifiers_share_one_library() -> None:
    found = using(
        'n=part:libLoad("part")\ni=again:libLoad("Disk://part/part.pjx")\nagain:sText="lib2"\n'
        's[0]=part:sText\ncall part:init()\nj=again:nX\ns[1]=part:libPath()\nk=libDelete("none")'
    )
    assert (found["n"], found["i"], found["j"], found["k"]) == (0, 0, 4, 0) and found["s"] == ["lib2", "Disk://part", "", "", "", ""]


@pytest.mark.requirement("VAL-LIB-02", "VAL-LIB-03", by="gateway.pure.languages.val3.instance:Instance.library")
def test_codes_of_loading() -> None:
    thin = App("thin", datum("sText", "string"))
    found = using('n=part:libLoad("thin")\ni=part:libLoad("Nowhere://x")\nj=part:libLoad("missing")\nk=part:libLoad("../../x")', thin)
    assert (found["n"], found["i"], found["j"], found["k"]) == (11, 20, 39, 21)
    for code in ("n=part:nX", "call part:init()", 'part:libLoad("thin")\nn=part:nX', 'part:libLoad("thin")\ncall part:init()'):
        tasks = run(App(data=DATA, libraries=USES, programs={"start": code}), PART, thin)["tasks"]
        assert isinstance(tasks, dict) and tasks["demo~"]["status"] == 80, code


@pytest.mark.requirement("VAL-LIB-04", by="gateway.pure.languages.val3.disk:resolve")
def test_paths() -> None:
    assert application_of("article_1", "demo") == application_of("Disk://article_1", "x") == ("article_1", "article_1")
    assert application_of("./part/part.pjx", "demo") == ("demo/part", "part") and resolve("USR\\a", "") == "USR/a"
    for path, code in (("Nowhere://a", 20), ("../a", 21), ("a:b", 22), ("", 22), ("USB0://a", 32)):
        with pytest.raises(PathFault) as fault:
            resolve(path, "")
        assert fault.value.code == code


@pytest.mark.requirement("VAL-LIB-06", "VAL-LIB-07", by=(L + "f_lib_list", L + "f_lib_exist"))
def test_lists_and_symbols() -> None:
    found = using(
        'part:libLoad("part")\nb=libList("part",s)\n'
        'if part:libExist("nX") and part:libExist("init()") and !part:libExist("hidden") and !part:libExist("init")\n'
        "n=1\nendIf\nif isDefined(part:sText)\ni=1\nendIf"
    )
    assert found["s"] == ["init.pgx", "part.dtx", "part.pjx", "start.pgx", "stop.pgx", "tasks.pgx", "wait9.pgx"] and (
        found["b"],
        found["n"],
        found["i"],
    ) == (True, 1, 1)
    app = App(data=DATA, programs={"start": (["string l_s[3]"], 'b=libList("demo",l_s)\ns[0]=l_s[2]')})
    small = run(app)["globals"]
    assert isinstance(small, dict) and small["b"] is False and small["s"][0] == "start.pgx"


@pytest.mark.requirement("VAL-VAR-11", by=L + "f_get_data")
def test_data_by_name() -> None:
    data = DATA + datum("v", "num", "5")
    code = (
        'part:libLoad("part")\nn=getData("part:pPath",v)\ni=getData("part:none",v)\nj=getData("nobody:x",v)\n'
        'k=getData("part:pPath[9]",v)\nv[4]=getData("part:sText",v)\nv[3]=getData("part:pPath[1]",v[2])'
    )
    found = run(App(data=data, libraries=USES, programs={"start": code}), PART)["globals"]
    assert (
        isinstance(found, dict) and (found["n"], found["i"], found["j"], found["k"]) == (3, -1, -2, -3) and found["v"] == [0, 5, 5, 1, -4]
    )


@pytest.mark.requirement("VAL-TASK-12", by="gateway.pure.languages.val3.controller:Controller.task")
def test_tasks_of_a_library_are_its_own() -> None:
    found = using('part:libLoad("part")\ncall part:tasks()\nn=taskStatus("inner")\ni=part:libLoad("part")')
    assert (found["n"], found["i"]) == (-1, 14)


def test_a_library_with_tasks_that_another_identifier_keeps_is_no_obstacle() -> None:
    uses = USES + '<Library alias="same" path="part" />'
    other = App("other", datum("nX", "num", values=value(value=8)))
    code = 'part:libLoad("part")\nsame:libLoad("part")\ncall part:tasks()\nn=same:libLoad("other")\ni=part:libLoad("other")'
    found = run(App(data=DATA, libraries=uses, programs={"start": code}), PART, other)["globals"]
    assert isinstance(found, dict) and (found["n"], found["i"]) == (11, 14), "nothing is unloaded; then the last one would be (L3940)"


@pytest.mark.requirement("VAL-APP-01", "VAL-APP-07", by="gateway.pure.languages.val3.machine:Machine.load_library")
def test_another_length_unit_is_a_warning() -> None:
    inch = App("part", PART.data, PART.programs, millimetres=False)
    found = run(App(data=DATA, libraries=USES, programs={"start": 'n=part:libLoad("part")\ni=part:nX'}), inch)
    assert (
        isinstance(found["globals"], dict)
        and (found["globals"]["n"], found["globals"]["i"]) == (1, 3)
        and "length unit" in str(found["log"])
    )


def test_other_length_units_of_what_an_application_declares_are_a_popup_at_its_start() -> None:
    """L532-538: of libraries and user types; libLoad of a library with such a type is 1."""
    body = App("body", datum("x", "num"), millimetres=False)
    types = '<Type name="Body" path="body" />'
    uses = '<Library alias="part" path="part" />'
    part = App("part", datum("u", "Body"), types=types)
    found = run(App(data=DATA + datum("u", "Body"), types=types, libraries=uses, programs={"start": 'n=part:libLoad("part")'}), body, part)
    assert isinstance(found["globals"], dict) and found["globals"]["n"] == 1
    assert isinstance(found["popups"], list) and [
        each for each in found["popups"] if each.startswith("user type 'Body': its length unit is inch")
    ]
    assert str(found["log"]).count("length unit") >= 3
    assert not run(App(data=DATA, libraries=uses), App("part", datum("x", "num")))["popups"]


INNER = App(
    "inner",
    datum("x", "num", values=value(value=7)) + datum("list", "num", "2", value("1", value=4)) + datum("secret", "num", access="private"),
)
OUTER = App(
    "outer",
    datum("part", "Inner", "2") + datum("name", "string", values=value(value="new")) + datum("f", "frame"),
    types='<Type name="Inner" path="Disk://inner/inner.pjx" />',
)
TYPES = '<Type name="Outer" path="outer" />'


@pytest.mark.requirement("VAL-UTYP-01", by="gateway.pure.languages.val3.values:UserV.set")
def test_user_types_nest_and_are_copied_deep() -> None:
    fields = '<Value key="0"><Field name="name" xsi:type="array" type="string" size="1"><Value key="0" value="file" /></Field></Value>'
    data = DATA + datum("u", "Outer", "2", fields) + datum("w", "Outer")
    code = (
        'w=u[0]\nappend(w.part[1].list)\nw.part[1].list[2]=9\nu[1]=w\nw.part[1].list[2]=1\nw.name="w"\n'
        "n=size(w.part[1].list)\ni=u[1].part[0].x\ncall p(w.part[0].x)\nresize(u[0].part,1,3)"
    )
    app = App(
        data=data,
        types=TYPES,
        programs={"start": code, "p(num& x_n)": (["Outer l_u"], 'x_n=x_n+1\nl_u.name="l"\nappend(l_u.part)\nj=size(l_u.part)')},
    )
    found = run(app, INNER, OUTER)["globals"]
    assert isinstance(found, dict)
    assert (found["n"], found["i"], found["j"]) == (3, 7, 3) and found["u"][1]["name"] == "file" and found["w"]["name"] == "w"
    assert found["u"][1]["part"][1]["list"] == [0, 4, 9] and found["w"]["part"][0]["x"] == 8
    assert [each["x"] for each in found["u"][0]["part"]] == [7, 7, 7] and "secret" not in found["u"][0]["part"][0]


def test_what_is_saved_loads_again_equal() -> None:
    data = (
        DATA
        + datum("u", "Outer", "2")
        + datum("g", "num", "2,3", value("1,2", value=5))
        + datum("c", "string", "", value("k y", value="&lt;&quot;"))
        + datum("m", "mdesc", values=value(tmax=250, blend="Cartesian"))
        + datum("t", "tool", values=value(z=10, fatherId="flange[0]", otime=0.5, ioLink="valve2"))
        + datum("f", "frame", "2", value("1", x=1, fatherId="f[0]"))
        + datum("p", "pointRx", values=value(x=1, fatherId="f[1]", shoulder="lefty"))
        + datum("q", "jointRx", values=value(j1=1.5))
        + datum("d", "dio", values=value(link="IO\\a"))
    )
    app = App(data=data, types=TYPES, libraries=USES, programs={"start": 'n=1\ni=libSave("copy")\nj=libSave("copy")'})
    made = machine(app, INNER, OUTER, PART)
    first = run(app, on=made)["globals"]
    assert isinstance(first, dict) and (first["i"], first["j"]) == (0, 31)
    again = Machine(Disk(dict(made.disk.files)))
    own = again.instance("copy", "copy", "")
    assert own is not None, again.log
    copy = {name: shown_container(again, each) for name, each in own.data.items()}
    kept = {name: each for name, each in first.items() if name not in ("i", "j", "d", "t")}
    assert {name: copy[name] for name in kept} == kept
    points = own.data["p"]
    assert isinstance(points, list) and isinstance(points[0], PointV) and points[0].father is not None
    assert points[0].father is element(own.data["f"], "1")


@pytest.mark.parametrize(
    ("path", "text", "told"),
    [
        ("demo/demo.pjx", "<Project", "not well-formed XML"),
        ("demo/demo.dtx", '<!DOCTYPE x [<!ENTITY a "b">]><Database/>', "a document type is declared"),
        ("demo/start.pgx", "<Other/>", "<Programs> of"),
        ("demo/demo.dtx", '<Database><Datas><Data name="1a" type="num" /></Datas></Database>', "'1a' : invalid name"),
        ("demo/demo.dtx", '<Database><Datas><Data name="a" type="num" size="0" /></Datas></Database>', "size '0'"),
        ("demo/demo.dtx", '<Database><Datas><Data name="a" type="Nothing" size="1" /></Datas></Database>', "'a' : invalid type (Nothing)"),
        (
            "demo/demo.dtx",
            "<Database><Datas><Data name='a' type='num' size='1'><Value key='4' /></Data></Datas></Database>",
            "no value with the key '4'",
        ),
    ],
)
def test_broken_files_are_named_with_file_and_line(path: str, text: str, told: str) -> None:
    made = disk(App(data=DATA))
    made.write(path, text.encode())
    found = Loader(made).load("demo", "demo")
    assert found is not None
    assert any(told in fault.text and fault.position.file == path and fault.position.line == 1 for fault in found.faults), list(
        map(str, found.faults)
    )


def test_missing_files_old_versions_and_rings_are_named() -> None:
    made = disk(App(data=DATA))
    made.delete("demo/none")
    missing = Disk({path: data for path, data in made.files.items() if not path.endswith(".dtx")})
    found = Loader(missing).load("demo", "demo")
    assert found is not None and [fault.text for fault in found.faults] == ["the file demo.dtx is missing"]
    old = Disk({path: data.replace(b"s7.9.1", b"s6.4.2") for path, data in made.files.items()})
    refused = Loader(old).load("demo", "demo")
    assert refused is not None and "s6.4.2" in next(iter(refused.faults)).text
    ring = App("part", libraries='<Library alias="back" path="demo" />')
    assert any("ring" in fault.text for fault in check(App(data=DATA, libraries=USES), ring))


def test_values_of_another_arm_are_error_81() -> None:
    data = DATA + datum("q", "jointRs") + datum("m", "mdesc")
    assert error_of("movej(q,flange,m)", data, arm=True) == 81


def test_a_program_in_a_sub_folder_and_several_in_one_file() -> None:
    made = disk(App(data=DATA, programs={"start": "call a()\ncall c()"}))
    first = "<Program name='a'><Description>x</Description><Code>begin\nn=1\nend</Code></Program>"
    second = "<Program name='c'><Code>begin\ni=2\nend</Code></Program>"
    made.write("demo/sub/two.pgx", f'<Programs xmlns="http://www.staubli.com/robotics/VAL3/Program/2">{first}{second}</Programs>'.encode())
    project = made.read("demo/demo.pjx")
    assert project is not None
    made.write("demo/demo.pjx", project.replace(b"<Programs>", b'<Programs><Program file="sub\\two.pgx" />'))
    found = run(App(), on=Machine(made))["globals"]
    assert isinstance(found, dict) and (found["n"], found["i"]) == (1, 2)


def test_words_of_the_language_are_values() -> None:
    found = globals_of("m.blend=off\nif m.blend==off\nn=1\nendIf\nm.blend=Cartesian", DATA + datum("m", "mdesc"))
    assert found["n"] == 1 and isinstance(found["m"], dict) and found["m"]["blend"] == "Cartesian"


def test_fields_of_user_types_are_arrays_for_instructions() -> None:
    body = App("body", datum("nData", "num", "8") + datum("nSeq", "num"))
    data = DATA + datum("msg", "Body")
    code = (
        'n=toBinary(i,1,"-4l",msg.nData)\ni=258\nn=toBinary(i,1,"4l",msg.nData[4])\nj=fromBinary(msg.nData[4],4,"-4l",msg.nSeq)\nk=msg.nSeq'
    )
    app = App(data=data, types='<Type name="Body" path="Disk://body/body.pjx" />', programs={"start": code})
    found = run(app, body)["globals"]
    assert isinstance(found, dict) and (found["n"], found["j"], found["k"]) == (4, 1, 258) and found["msg"]["nData"][4:6] == [2, 1]


def test_a_reference_without_a_container_is_an_array() -> None:
    made = disk(App(data=DATA + datum("a", "num", "3"), programs={"start": "a[2]=7\ncall first(a)\ni=a[1]"}))
    space = "http://www.staubli.com/robotics/VAL3/"
    given = f'<Parameters xmlns="{space}Param/1"><Parameter name="x_n" type="num" use="reference" /></Parameters>'
    text = f"<Program name='first'>{given}<Code>begin\nx_n[1]=x_n[2]\nend</Code></Program>"
    made.write("demo/more.pgx", f'<Programs xmlns="{space}Program/2">{text}</Programs>'.encode())
    project = made.read("demo/demo.pjx")
    assert project is not None
    made.write("demo/demo.pjx", project.replace(b"<Programs>", b'<Programs><Program file="more.pgx" />'))
    found = run(App(), on=Machine(made))["globals"]
    assert isinstance(found, dict) and found["i"] == 7


@pytest.mark.parametrize(("call", "code"), [('s=next(c["x"])', 25), ('s=prev(c["x"])', 25), ('s=next(c[""])', 23), ('s=prev(c[""])', 23)])
def test_a_key_that_is_not_there_is_an_error_in_an_empty_collection_too(call: str, code: int) -> None:
    data = DATA + datum("c", "num", "")
    assert error_of(call, data) == error_of(f'insert(c["y"])\n{call}', data) == code


@pytest.mark.requirement("VAL-VAR-11", by=L + "f_get_data")
def test_get_data_of_an_index_takes_one_value_and_copies_what_was_there() -> None:
    data = DATA + datum("a", "num", "5", "".join(value(str(at), value=at + 1) for at in range(5)))
    found = globals_of('n=getData("a[1.2.3]",i)\ni=getData("a[3]",a)\nj=a[1]\nk=a[0]', data)
    assert (found["n"], found["i"], found["j"], found["k"]) == (-1, 1, 2, 4)
    found = globals_of('n=getData("a",a[1])', data)
    assert (found["n"], found["a"]) == (4, [1, 1, 2, 3, 4])


@pytest.mark.requirement("VAL-LIB-01", by="gateway.pure.languages.val3.machine:Machine.load_library")
def test_what_is_loaded_in_place_of_a_library_has_its_initial_values() -> None:
    """L3935, L3945, also for the same library again; as long as another identifier has it, it is shared as it is (AX-1735)."""
    code = (
        'part:libLoad("part")\npart:nX=9\npart:libLoad("other")\npart:libLoad("part")\nn=part:nX\npart:nX=9\npart:libLoad("part")\ni=part:nX\n'
        'again:libLoad("part")\npart:nX=9\npart:libLoad("part")\nj=part:nX\npart:libLoad("other")\npart:libLoad("part")\nk=part:nX'
    )
    found = using(code, App("other", PART.data, {"init": "", "tasks": "", "wait9": ""}))
    assert (found["n"], found["i"], found["j"], found["k"]) == (3, 3, 9, 9)


def test_what_was_saved_is_what_loads_again() -> None:
    code = 'part:libLoad("part")\npart:nX=9\nn=part:libSave()\npart:nX=10\ni=part:libLoad("other")\nj=part:libLoad("part")\nk=part:nX'
    found = using(code, App("other", PART.data, {"init": "", "tasks": "", "wait9": ""}))
    assert (found["n"], found["i"], found["j"], found["k"]) == (0, 0, 0, 9)


def test_a_library_that_a_task_is_in_is_not_unloaded() -> None:
    code = 'part:libLoad("part")\ntaskCreate "in",1,inside()\ndelay(1)\nn=part:libLoad("thin")\ni=part:nX\n'
    code += 'taskKill("in")\nj=part:libLoad("thin")'
    app = App(data=DATA, libraries=USES, programs={"start": code, "inside": "call part:wait9()"})
    found = run(app, PART, App("thin", datum("nX", "num")))["globals"]
    assert isinstance(found, dict) and (found["n"], found["i"], found["j"]) == (13, 3, 11)


def test_a_library_that_cannot_be_loaded_leaves_the_one_that_is_there() -> None:
    made = disk(
        App(data=DATA, libraries=USES, programs={"start": 'part:libLoad("part")\npart:nX=9\nn=part:libLoad("wrong")\ni=part:nX'}), PART
    )
    made.files["wrong/wrong.pjx"] = b"<Project"
    found = run(App(), on=Machine(Disk(dict(made.files))))["globals"]
    assert isinstance(found, dict) and (found["n"], found["i"]) == (12, 9)


def test_libraries_of_an_unloaded_library_go_with_it() -> None:
    inner = '<Library alias="inner" path="inner" autoload="true" />'
    outer = App("part", PART.data, {"init": "inner:x=inner:x+1\nnX=inner:x", "tasks": "", "wait9": ""}, libraries=inner)
    code = 'part:libLoad("part")\ncall part:init()\nn=part:nX\npart:libLoad("other")\npart:libLoad("part")\ncall part:init()\ni=part:nX'
    found = run(App(data=DATA, libraries=USES, programs={"start": code}), outer, INNER, App("other", PART.data))["globals"]
    assert isinstance(found, dict) and (found["n"], found["i"]) == (8, 8)


def test_autoload_is_saved() -> None:
    uses = '<Library alias="part" path="part" autoload="true" />'
    made = machine(app := App(data=DATA, libraries=uses, programs={"start": 'n=libSave("copy")'}), PART)
    run(app, on=made)
    again = Machine(Disk(dict(made.disk.files)))
    own = again.instance("copy", "copy", "")
    assert own is not None and own.libraries["part"] is not None


def test_is_defined_is_false_where_what_an_element_lies_in_is_missing() -> None:
    data = DATA + datum("u", "Outer", "2") + datum("c", "Outer", "")
    asked = ("u[7].part[0].list[0]", "u[1].part[5].list[0]", "u[1].part[1].list[9]", 'c["x"].part[0].list[0]', "u[1].part[1].list[1]")
    code = "\n".join(f'if isDefined({each})\ns[{at}]="y"\nelse\ns[{at}]="n"\nendIf' for at, each in enumerate(asked))
    found = run(App(data=data, types=TYPES, programs={"start": code}), INNER, OUTER)["globals"]
    assert isinstance(found, dict) and found["s"][:5] == ["n", "n", "n", "n", "y"]


def test_texts_with_control_characters_are_saved_and_load_again() -> None:
    """A telegram in a global (STX, the GS of a bar code) does not make its application unreadable (AX-1737)."""
    data = DATA + datum("c", "num", "") + datum("t", "string", "2", value("1", value="a&#13;&quot;&amp;"))
    code = 't[0]=chr(2)+"01"+chr(29)+"é"+chr(0)+chr(65535)\ninsert(c[chr(29)])\nc[chr(29)]=4\ninsert(c["x"])\nn=libSave("copy")'
    made = machine(app := App(data=data, programs={"start": code}))
    first = run(app, on=made)["globals"]
    again = Machine(Disk(dict(made.disk.files)))
    own = again.instance("copy", "copy", "")
    assert own is not None and isinstance(first, dict), again.log
    assert shown_container(again, own.data["t"]) == first["t"] == ["\x0201\x1dé\0\uffff", 'a\r"&']
    assert shown_container(again, own.data["c"]) == first["c"] == {"\x1d": 4, "x": 0}
    broken = disk(App(data=datum("a", "string", values=value(valueHex="zz"))))
    loaded = Loader(broken).load("demo", "demo")
    assert loaded is not None and ["UTF-8 text" in fault.text for fault in loaded.faults] == [True]


def test_what_was_bound_to_a_library_is_bound_to_the_one_that_takes_its_place() -> None:
    """An entry on the page reaches the recipe that is loaded, not one that is gone (AX-1735)."""
    code = (
        'part:libLoad("part")\nuserPageBind("p","a","value",part:nX,1,"rw")\nuserPageBindClick("p","b",part:nX,7)\n'
        'part:libLoad("part")\ndelay(2)\nn=part:nX\npart:libLoad("other")\ndelay(2)\ni=part:nX'
    )
    app = App(data=DATA, libraries=USES, programs={"start": code})
    at = [(1.0, "page.p.a.value=5"), (3.0, "page.p.b=click")]
    found = run(app, PART, App("other", PART.data), at=at)["globals"]
    assert isinstance(found, dict) and (found["n"], found["i"]) == (5, 7)
