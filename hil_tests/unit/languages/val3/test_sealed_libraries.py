"""Encrypted libraries (VAL 3 reference 6.5) and their passwords (AX-992)."""

import pathlib
import struct
import zlib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gateway.commands.val3 import main
from gateway.pure.languages.val3.disk import Disk
from gateway.pure.languages.val3.machine import Machine
from gateway.pure.languages.val3.sealed import SealFault, opened, public_of, secret_of
from gateway.pure.languages.val3.virtual import Run
from hil_tests.unit.languages.val3.apps import App, datum, run, value

SECRET = "long enough 42"


def zipped(files: dict[str, bytes], secret: str | None, *, method: int = 8) -> bytes:
    """A ZIP file with the classic encryption, as APPNOTE 6.1 describes it; None: not encrypted."""
    body, entries = b"", b""
    for name, data in files.items():
        packer = zlib.compressobj(9, zlib.DEFLATED, -15)
        plain = packer.compress(data) + packer.flush() if method else data
        sealed = plain if secret is None else encrypted(bytes(11) + bytes([zlib.crc32(data) >> 24]) + plain, secret.encode())
        head = struct.pack("<HHHHHIII", 20, secret is not None, method, 0, 0, zlib.crc32(data), len(sealed), len(data))
        entries += (
            b"PK\x01\x02" + struct.pack("<H", 20) + head + struct.pack("<HHHHHII", len(name), 0, 0, 0, 0, 0, len(body)) + name.encode()
        )
        body += b"PK\x03\x04" + head + struct.pack("<HH", len(name), 0) + name.encode() + sealed
    return body + entries + b"PK\x05\x06" + struct.pack("<HHHHIIH", 0, 0, len(files), len(files), len(entries), len(body), 0)


def encrypted(data: bytes, secret: bytes) -> bytes:
    keys = [0x12345678, 0x23456789, 0x34567890]

    def update(byte: int) -> None:
        keys[0] = ~zlib.crc32(bytes([byte]), ~keys[0] & 0xFFFFFFFF) & 0xFFFFFFFF
        keys[1] = ((keys[1] + (keys[0] & 0xFF)) * 134775813 + 1) & 0xFFFFFFFF
        keys[2] = ~zlib.crc32(bytes([keys[1] >> 24]), ~keys[2] & 0xFFFFFFFF) & 0xFFFFFFFF

    for byte in secret:
        update(byte)
    found = bytearray()
    for byte in data:
        mask = keys[2] | 2
        found.append(byte ^ ((mask * (mask ^ 1)) >> 8) & 0xFF)
        update(byte)
    return bytes(found)


PART = App("part", datum("nX", "num", values=value(value=3)), {"init": "nX=nX*2"})
INSIDE = {path.removeprefix("part/"): data for path, data in PART.files().items()}
OUTSIDE = App("open", datum("nX", "num", values=value(value=1)), {"init": "nX=nX+1"})


def loaded(data: bytes, path: str, password: str, name: str = "lib/part.zip") -> tuple[object, object]:
    """Result of libLoad and lib:nX after init()."""
    code = f'nR=lib:libLoad("{path}"{password})\nif nR<2\n  call lib:init()\n  nX=lib:nX\nendIf'
    app = App(data=datum("nR", "num") + datum("nX", "num"), libraries='<Library alias="lib" path="open" />', programs={"start": code})
    machine = Machine(Disk({**app.files(), **OUTSIDE.files(), name: data}))
    own = machine.instance("demo", "demo", "")
    assert own is not None, machine.log
    run = Run(machine, own, 10**9, [])
    run.go()
    found = run.result()["globals"]
    assert isinstance(found, dict)
    assert not any(path.startswith("lib/part.zip/") for path in machine.disk.files), "the content stays secret"
    return found["nR"], found["nX"]


@pytest.mark.requirement("VAL-LIB-08", by="gateway.pure.languages.val3.sealed:library_of")
@pytest.mark.parametrize("method", [0, 8])
def test_an_encrypted_library_loads_with_its_public_password(method: int) -> None:
    good = zipped(INSIDE, SECRET, method=method)
    assert loaded(good, "lib/part.zip", f', "{public_of(SECRET)}"') == (0, 6)
    assert loaded(good, "Disk://lib/PART.zip", f', "{public_of("another secret")}"') == (12, 0)
    assert loaded(good, "lib/part.zip", f', "{SECRET}"') == loaded(good, "lib/part.zip", "") == (12, 0)
    assert loaded(good, "lib/none.zip", f', "{public_of(SECRET)}"') == (39, 0)
    assert loaded(good, "open", f', "{public_of(SECRET)}"') == (23, 0)
    assert loaded(zipped(INSIDE, None), "lib/part.zip", f', "{public_of(SECRET)}"') == (23, 0)
    assert loaded(b"no zip", "lib/part.zip", f', "{public_of(SECRET)}"') == (23, 0)
    assert loaded(good, "lib/partpartpart.zip", f', "{public_of(SECRET)}"', "lib/partpartpart.zip")[0] == 22


@given(st.binary(max_size=300), st.integers(0, 400), st.binary(max_size=4))
def test_no_damage_is_more_than_a_code(tail: bytes, at: int, other: bytes) -> None:
    good = zipped({"part.pjx": b"<a/>"}, SECRET)
    codes = set()
    for data in (tail, good[:at] + tail, good[:at] + other + good[at + len(other) :]):
        try:
            opened(data, SECRET)
        except SealFault as fault:
            codes.add(fault.code)
    assert codes <= {12, 23}


@given(st.text(st.characters(codec="utf-8"), min_size=1, max_size=80))
def test_every_password_comes_back(secret: str) -> None:
    assert secret_of(public_of(secret)) == secret
    assert len(secret) < 11 or secret.encode().hex() not in public_of(secret)


def test_the_command_writes_what_lib_load_takes(capsys: pytest.CaptureFixture[str], tmp_path: pathlib.Path) -> None:
    assert main(["password", SECRET]) == 0
    assert capsys.readouterr().out.strip() == public_of(SECRET)
    assert main(["password", "short"]) == 2 and "11 characters at least" in capsys.readouterr().err


@pytest.mark.requirement("VAL-LIB-08", by="gateway.pure.languages.val3.builtin_libraries:f_lib_delete")
def test_an_encrypted_library_is_never_saved_and_can_be_deleted() -> None:
    code = f"""n[0]=lib:libLoad("lib/part.zip","{public_of(SECRET)}")
n[1]=lib:libSave()
n[2]=lib:libSave("copy")
n[3]=libDelete("lib/note.txt")
n[4]=libDelete("lib/part.zip")
n[5]=lib:libLoad("lib/part.zip","{public_of(SECRET)}")"""
    app = App(data=datum("n", "num", "6"), libraries='<Library alias="lib" path="open" />', programs={"start": code})
    disk = Disk({**app.files(), **OUTSIDE.files(), "lib/part.zip": zipped(INSIDE, SECRET), "lib/note.txt": b"kept"})
    before = set(disk.files)
    found = run(app, on=Machine(disk))["globals"]
    assert isinstance(found, dict) and found["n"] == [0, 40, 40, 0, 0, 39]
    assert before - set(disk.files) == {"lib/part.zip"} and not set(disk.files) - before
