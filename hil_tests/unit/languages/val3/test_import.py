"""A cell out of a flash card: usr/configs and usr/usrapp as controllers write them (AX-990)."""

import json
import pathlib
import shutil
import tomllib
import zipfile
from collections.abc import Callable

import pytest

import configs
from gateway.cell_file.load import load_cell
from gateway.commands.val3 import main
from gateway.pure.controllers.val3.sio.channel import Channel, Kind, channel_named
from gateway.pure.languages.val3.card import card_of
from gateway.pure.languages.val3.links import Link
from gateway.tools.new_cell.val3_cell import distinct, place_of
from hil_tests.unit.languages.val3.apps import App, datum, value

CYCLE = pathlib.Path(configs.__file__).parent / "cells" / "cs8" / "usrapp" / "cycle"
HEAD = '<?xml version="1.0" encoding="utf-8" ?>\n'
SIO = """<sio>
  <serialPort>
    <String name="name" value="portSerial" />
    <Uint name="baudRate" value="19200" />
    <Uint name="byteSize" value="7" />
    <String name="parity" value="even" />
    <Uint name="nbStopBit" value="2" />
    <Int name="endOfString" value="3" />
    <Float name="timeOut" value="5" />
    <String name="flowControl" value="none" />
  </serialPort>
  <!-- sockets -->
  <socketSrv>
    <String name="name" value="hmi" />
    <Uint name="portNumber" value="11000" />
    <Uint name="nbClients" value="2" />
    <Int name="endOfString" value="10" />
    <Float name="timeOut" value="-0.001" />
    <Bool name="nagle" value="false" />
  </socketSrv>
  <socketClt>
    <String name="name" value="cam" />
    <String name="desc" value="Camera &quot;left&quot;" />
    <Inet name="connectIp" value="192.168.0.20" />
    <Uint name="portNumber" value="4000" />
  </socketClt>
  <udpSocket>
    <String name="name" value="control" />
    <Inet name="connectIp" value="172.31.0.2" />
    <Uint name="portNumber" value="11001" />
    <Bool name="broadcast" value="true" />
    <Float name="quietTime" value="30" />
  </udpSocket>
</sio>"""
CELL = """<cell>
  <String name="language" value="deutsch" />
  <Float name="val3WatchdogPeriod" value="2.5" />
  <FloatArray name="minCellJointPos" ><Float index="0" value="-90" /><Float index="1" value="-99999" /></FloatArray>
  <FloatArray name="maxCellJointPos" ><Float index="0" value="-10" /><Float index="2" value="120" /></FloatArray>
  <String name="robotName" value="Press 3" />
  <autoStart name="cycle" location="Disk" />
  <String name="initWorkingMode" value="manual" />
</cell>"""
ARM = '<arm><String name="arm" value="rx160-S1" /><FloatArray name="minArmJointPos" ><Float index="0" value="-60" /></FloatArray></arm>'
BUS = """<ProcessData xmlns="x-schema:ProcessDataSchema.xml">
  <Adapter displayName="J207J208 RE/PLS[CIFX RE/PLS]"><Module displayName="8 Bytes In">
    <Signal displayName="In_Byte_0" signalType="output" signalAccessPath="0.0" dataType="bit" arrayElements="8"/>
    <Signal displayName="InWord" signalType="output" dataType="word" arrayElements="1"/></Module>
    <Module displayName="8 Bytes Out"><Signal displayName="OutStart" signalType="input" dataType="bit"/></Module></Adapter>
</ProcessData>"""


def card(folder: pathlib.Path, *apps: App, **files: str) -> pathlib.Path:
    """A copy of a flash card."""
    usrapp, place = folder / "card" / "usr" / "usrapp", folder / "card" / "usr" / "Configs"
    place.mkdir(parents=True)
    usrapp.mkdir()
    for app in apps:
        for path, data in app.files().items():
            (usrapp / path).parent.mkdir(parents=True, exist_ok=True)
            (usrapp / path).write_bytes(data)
    for name, text in files.items():
        (place / name.replace("_", ".", 1)).write_text(HEAD + text)
    return folder / "card"


def test_the_cell_of_a_card_is_sound_and_has_all_it_says(tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    made = card(tmp_path, sio_cfx=SIO, cell_cfx=CELL, arm_cfx=ARM, J207_xml=BUS)
    shutil.copytree(CYCLE, made / "usr" / "usrapp" / "cycle")
    out = tmp_path / "press.toml"
    assert main(["import", str(made), "--out", str(out), "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert said["application"] == "cycle" and said["doubts"] == [
        "Serial\\portSerial: name its port in address; /dev/ttyS0 and so on are assumed"
    ]
    cell = load_cell(str(out))  # no CellFaults: it is sound
    assert cell.val3 is not None and cell.controller is not None
    assert (cell.cell.name, cell.cell.language, cell.val3.autostart, cell.val3.watchdog_s) == ("Press 3", "de", True, 2.5)
    rows = {each.name: each for each in cell.val3.channel}
    serial, server, client, udp = (rows[name] for name in ("Serial\\portSerial", "Socket\\hmi", "Socket\\cam", "UdpSocket\\control"))
    assert (serial.baud_rate, serial.bits, serial.parity, serial.stop_bits, serial.end_of_string) == (19200, 7, "even", 2, 3)
    assert (server.kind, server.port, server.clients, server.timeout_s, server.nagle) == ("server", 11000, 2, -1.0, False)
    assert (client.kind, client.address, client.port, client.description) == ("client", "192.168.0.20", 4000, 'Camera "left"')
    assert (udp.address, udp.timeout_s) == ("172.31.255.255", 0.0)
    points = {each.name: each for each in cell.controller.point}
    assert points["valve1"].output and not points["part"].output and points["part"].bit != 711
    assert not points["In_Byte_0"].output and points["InWord"].steps and points["OutStart"].output
    assert (cell.axis[0].limits.min, cell.axis[0].limits.max, cell.axis[2].limits.max) == (-60.0, -10.0, 120.0)
    assert -60.0 <= tomllib.loads(out.read_text())["plant"]["axis"]["J1"]["start"] <= -10.0


def test_one_application_is_found_or_named(tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    library = '<Library alias="lib" path="Disk://lib/lib.pjx" />'
    made = card(tmp_path, App("cellA", libraries=library), App("lib"), App("data", programs={}))
    assert main(["import", str(made), "--out", str(tmp_path / "a.toml")]) == 2
    assert "2 applications can start: cellA, data; name one with --application" in capsys.readouterr().err
    assert main(["import", str(made / "usr"), "--application", "CELLA", "--out", str(tmp_path / "a.toml")]) == 0
    table = load_cell(str(tmp_path / "a.toml")).val3
    assert table is not None and table.application == "cellA"
    assert main(["import", str(made), "--application", "cellA", "--out", str(tmp_path / "a.toml")]) == 2
    assert "exists already and is not changed" in capsys.readouterr().err
    assert main(["import", str(made), "--application", "nothing", "--out", str(tmp_path / "b.toml")]) == 2
    assert main(["import", str(tmp_path / "none")]) == 2 and not (tmp_path / "b.toml").exists()
    assert "Traceback" not in capsys.readouterr().err


def test_the_card_says_how_user_boards_are_refreshed_and_whether_the_path_is_altered(tmp_path: pathlib.Path) -> None:
    cell_cfx = '<cell><UserIOResfresh><String name="mode" value="noJitter" /><Float name="cyclicRatio" value="3" /></UserIOResfresh></cell>'
    made = card(tmp_path, App("glue", datum("f", "frame") + datum("m", "mdesc"), {"start": "alterBegin(f,m)"}), cell_cfx=cell_cfx)
    assert main(["import", str(made), "--out", str(tmp_path / "glue.toml")]) == 0
    cell = load_cell(str(tmp_path / "glue.toml"))
    assert cell.val3 is not None and cell.val3.user_io is not None and cell.alter is not None
    assert (cell.val3.user_io.mode, cell.val3.user_io.ratio, cell.alter.source) == ("noJitter", 3, "application")
    plain = card(tmp_path / "b", App("plain", programs={"start": "// alterBegin"}))
    assert main(["import", str(plain), "--out", str(tmp_path / "plain.toml")]) == 0
    assert load_cell(str(tmp_path / "plain.toml")).alter is None


def test_a_scara_gets_a_cell_of_four_axes(tmp_path: pathlib.Path) -> None:
    made = card(tmp_path, App("pick", datum("jA", "jointRs")), arm_cfx='<arm><String name="arm" value="ts60" /></arm>')
    assert main(["import", str(made), "--out", str(tmp_path / "pick.toml")]) == 0
    cell = load_cell(str(tmp_path / "pick.toml"))
    assert len(cell.axis) == 4 and cell.robot[0].kinematics == "scara"


def test_links_of_all_kinds_get_one_point_each(tmp_path: pathlib.Path) -> None:
    data = datum("doA", "dio", "2", value("0", link="BasicIO-1\\%Q0") + value("1", link="BasicIO-1\\%Q1"))
    data += datum("aoB", "aio", values=value(link="EtherCAT-1\\%QF32")) + datum("diC", "dio", values=value(link="usrIn0"))
    data += datum("tA", "tool", values=value(ioLink="ValveIO\\valve1")) + datum("tB", "tool", values=value(ioLink="valve1"))
    data += datum("siD", "sio", values=value(link="Socket\\none"))
    made = card(tmp_path, App("io", data), sio_cfx="<sio></sio>")
    assert main(["import", str(made), "--out", str(tmp_path / "io.toml"), "--json"]) == 0
    table = tomllib.loads((tmp_path / "io.toml").read_text())
    points = {
        each["name"]: (each["board"], each["address"], each.get("output", False), "byte" in each) for each in table["controller"]["point"]
    }
    assert points == {
        "valve1": ("ValveIO", "valve1", True, False),
        "doA": ("BasicIO-1", "%Q0", True, False),
        "doA_2": ("BasicIO-1", "%Q1", True, False),
        "aoB": ("EtherCAT-1", "%QF32", True, True),
        "usrIn0": ("System", "usrIn0", False, False),
    }
    assert place_of("a\\b\\c\\%I1") == ("a", "b\\c", "%I1")
    assert len(distinct([Link("valve1", True, False, "t"), Link("ValveIO/valve1", True, False, "t")])) == 1


@pytest.mark.parametrize(
    ("name", "text", "doubt"),
    [
        ("sio.cfx", SIO.replace("</sio>", "<sio>"), "sio.cfx line 35: <sio> was read as </sio>"),
        ("sio.cfx", "<sio><socketSrv>", "the file is left out"),
        ("sio.cfx", '<!DOCTYPE a [<!ENTITY x "y">]><sio>&x;</sio>', "a document type is declared"),
        ("sio.cfx", "<sio><socketSrv /></sio>", "sio.cfx line 2: <socketSrv> has no name and is left out"),
        (
            "sio.cfx",
            '<sio><modem><String name="name" value="m" /></modem></sio>',
            "<modem> is neither a serial line nor a socket; m is left out",
        ),
        ("sio.cfx", SIO.replace('value="even"', 'value="mark"'), "portSerial: 'mark' is not one of none, even, odd; none is used"),
        ("sio.cfx", SIO.replace('"11000"', '"99999"'), "hmi: portNumber '99999' is not a whole number 1..65535; 0 is used"),
        ("sio.cfx", SIO.replace('"5"', '"soon"'), "portSerial: timeOut 'soon' is not a number; 0 is used"),
    ],
)
def test_what_is_not_understood_is_said(name: str, text: str, doubt: str) -> None:
    found = card_of({name: (HEAD + text).encode()})
    assert any(doubt in each for each in found.doubts), found.doubts


def test_sockets_whose_names_differ_in_case_alone_are_two() -> None:
    row = '<socketSrv><String name="name" value="{}" /><Uint name="portNumber" value="{}" /></socketSrv>'
    rows = row.format("Vision", 8500) + row.format("vision", 5000) + row.format("vision", 5001)
    found = card_of({"sio.cfx": (HEAD + "<sio>" + rows + "</sio>").encode()})
    assert [(each.name, each.port) for each in found.channels] == [("Socket\\Vision", 8500), ("Socket\\vision", 5000)]
    assert found.doubts == ["sio.cfx line 2: vision has the name of Socket\\vision above and is left out"]
    channels = [Channel(each.name, Kind.TCP_SERVER) for each in found.channels]
    leads = {link: channel_named(channels, link) for link in ("Socket\\vision", "vision", "Socket/Vision", "VISION", "Serial\\vision", "x")}
    assert leads == {
        "Socket\\vision": "Socket\\vision",
        "vision": "Socket\\vision",
        "Socket/Vision": "Socket\\Vision",
        "VISION": "Socket\\Vision",
        "Serial\\vision": "Socket\\vision",
        "x": None,
    }, "the one as written, else the first in any case"


def zipped(folder: pathlib.Path, target: pathlib.Path, under: str = "") -> pathlib.Path:
    """The ZIP file of a card."""
    with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as made:
        for path in sorted(folder.rglob("*")):
            if path.is_file():
                made.write(path, under + path.relative_to(folder).as_posix())
    return target


@pytest.mark.parametrize("under", ["", "backup 2019/flash/"])
def test_a_zip_file_is_unpacked_beside_the_cell(tmp_path: pathlib.Path, under: str) -> None:
    app = App("pick", datum("p", "point", values=value(fatherId="world[0]")))
    archive = zipped(card(tmp_path, app, sio_cfx=SIO), tmp_path / "card.zip", under)
    out = tmp_path / "cells" / "press.toml"
    out.parent.mkdir()
    assert main(["import", str(archive), "--out", str(out)]) == 0
    cell = load_cell(str(out))
    assert cell.val3 is not None and [each.name for each in cell.val3.channel][:1] == ["Serial\\portSerial"]
    assert (out.parent / cell.val3.disk / "pick" / "pick.pjx").is_file() and cell.val3.disk.startswith("press/")


def test_an_application_alone_is_imported_too(tmp_path: pathlib.Path) -> None:
    usrapp = card(tmp_path, App("pick", libraries='<Library alias="lib" path="Disk://lib/lib.pjx" />'), App("lib")) / "usr" / "usrapp"
    assert main(["import", str(usrapp.parent / "usrapp" / "pick"), "--application", "pick", "--out", str(tmp_path / "a.toml")]) == 0
    assert main(["import", str(zipped(usrapp, tmp_path / "usrapp.zip")), "--application", "pick", "--out", str(tmp_path / "b.toml")]) == 0
    for name in ("a", "b"):
        cell = load_cell(str(tmp_path / f"{name}.toml"))
        assert cell.val3 is not None and (tmp_path / cell.val3.disk / "lib" / "lib.pjx").is_file()


def _escapes(made: zipfile.ZipFile) -> None:
    made.writestr("usr/usrapp/../../../../escaped.pjx", "x")


def _link(made: zipfile.ZipFile) -> None:
    entry = zipfile.ZipInfo("usr/usrapp/a")
    entry.external_attr = 0o120777 << 16
    made.writestr(entry, "/etc/passwd")


def _nothing(made: zipfile.ZipFile) -> None:
    made.writestr("readme.txt", "no card")


@pytest.mark.parametrize(
    ("fill", "words"),
    [
        (_escapes, "leads out of the folder"),
        (_link, "leads out of the folder"),
        (_nothing, "there is no folder usrapp and no .pjx file"),
        (None, "the ZIP file is damaged"),
    ],
)
def test_a_zip_file_that_is_refused_leaves_nothing(
    tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str], fill: Callable[[zipfile.ZipFile], None] | None, words: str
) -> None:
    archive = tmp_path / "in" / "card.zip"
    archive.parent.mkdir()
    with zipfile.ZipFile(archive, "w") as made:
        (fill or _nothing)(made)
    if fill is None:
        data = bytearray(archive.read_bytes())
        data[40] ^= 0xFF  # of the content: its check sum is wrong
        archive.write_bytes(data)
    assert main(["import", str(archive), "--out", str(tmp_path / "press.toml")]) == 2
    assert words in capsys.readouterr().err
    assert sorted(each.name for each in tmp_path.iterdir()) == ["in"]


def test_a_folder_that_is_there_is_not_unpacked_into(tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    archive = zipped(card(tmp_path, App("pick")), tmp_path / "card.zip")
    (tmp_path / "press").mkdir()
    assert main(["import", str(archive), "--out", str(tmp_path / "press.toml")]) == 2
    assert "press exists already and is not changed" in capsys.readouterr().err


def test_what_a_program_writes_is_an_output(tmp_path: pathlib.Path) -> None:
    """Links of s8 are identifications that say nothing about the direction."""
    names = ("gripper", "part", "door", "level", "force", "line", "spare")
    links = {name: value(link=f"0000000{at}-7D0C-47C0-8458-4D7DB0686071") for at, name in enumerate(names)}
    data = "".join(datum(name, "aio" if name in ("level", "force") else "dio", values=links[name]) for name in names[:-2])
    code = "gripper = part==true\naioSet (level, aioGet(force))\nif door==false\nlib:line[0]=true\nendIf\n//spare=true"
    lib = App("lib", datum("line", "dio", "1", links["line"]) + datum("spare", "dio", "1", links["spare"]))
    app = App("cell", data, {"start": code}, libraries='<Library alias="lib" path="Disk://lib/lib.pjx" />')
    made = card(tmp_path, app, lib, sio_cfx="<sio></sio>")
    assert main(["import", str(made), "--out", str(tmp_path / "cell.toml"), "--json"]) == 0
    points = tomllib.loads((tmp_path / "cell.toml").read_text())["controller"]["point"]
    assert {each["name"] for each in points if each.get("output")} == {"gripper", "level", "line"}
    assert len(points) == len(names)
    assert [each.output for each in distinct([Link("A", False, False, "part"), Link("A", True, False, "doPart")])] == [True]


def test_an_import_is_reported_in_german_and_names_a_wrong_port_once(
    tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """A tool without an output of its own has valve1 (L4923), so the cell needs its point."""
    app = App("job", datum("tT", "tool") + datum("siX", "sio", values=value(link="Socket\\none")), {"start": "close(tT)"})
    sio, out = SIO.replace('"11000"', '"70000"').replace('"even"', '"mark"'), tmp_path / "c.toml"
    folder = card(tmp_path, app, sio_cfx=sio)
    monkeypatch.setenv("LC_ALL", "de_DE.UTF-8")
    assert main(["import", str(folder), "--out", str(out)]) == 0
    said, doubts = capsys.readouterr()
    assert said == f"{out} geschrieben, Anwendung job.  weiter: axisgate check {out}      dann: axisgate run {out} --sim\n"
    assert doubts.splitlines() == [
        "  sio.cfx Zeile 3, portSerial: 'mark' ist nicht bekannt (none, even, odd); none wird genommen",
        "  sio.cfx Zeile 14, hmi: portNumber '70000' ist keine ganze Zahl 1..65535; 0 wird genommen",
        "  Serial\\portSerial: die Schnittstelle in address nennen; angenommen sind /dev/ttyS0 und folgende",
        "  Socket\\none: diesen Kanal hat sio.cfx nicht; ein [[val3.channel]] ergaenzen",
    ]
    assert 'name    = "valve1"' in out.read_text()
    job = str(folder / "usr" / "usrapp" / "job")
    assert main(["check", job]) == 0 and capsys.readouterr().out == "job: 2 Programme, 2 Daten, 0 Fehler\n"
    assert main(["run", job, "--virtual"]) == 0 and capsys.readouterr().out.startswith("beendet nach ")


@pytest.mark.parametrize(
    ("sio", "doubt"),
    [
        (
            b"<sio><socketSrv>",
            "sio.cfx Zeile 2: kein wohlgeformtes XML: kein Element gefunden, "
            "<socketSrv> von Zeile 2 ist nicht geschlossen; die Datei entfaellt",
        ),
        (b"<sio>&x;</sio>", "sio.cfx Zeile 2: kein wohlgeformtes XML: unbekannte Entitaet; die Datei entfaellt"),
        (b"", "sio.cfx Zeile 2: kein wohlgeformtes XML: kein Element gefunden; die Datei entfaellt"),
        (
            b'<sio><socketSrv><String name="name" value="T\xfcr" /></socketSrv></sio>',
            "sio.cfx Zeile 2: Byte FCh ist kein UTF-8; die Datei wurde als Windows-1252 gelesen",
        ),
    ],
)
def test_faults_of_the_cards_files_are_reported_in_german(
    sio: bytes, doubt: str, tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = card(tmp_path, App("job", "", {"start": "wait(true)"}), sio_cfx=SIO)
    (next(folder.rglob("sio.cfx"))).write_bytes(HEAD.encode() + sio)
    monkeypatch.setenv("LC_ALL", "de_DE.UTF-8")
    assert main(["import", str(folder), "--out", str(tmp_path / "c.toml")]) == 0
    assert capsys.readouterr().err.splitlines()[0].strip() == doubt
