"""Programs of a cell that READ and WRITE V24_1 to V24_4, in virtual time: the other end of each line is a partner by hand (AX-1021)."""

from dataclasses import replace

import pytest

from gateway.assembly.program_lines import serial_setup
from gateway.pure.cell.lines import Line, ProgramUnit
from gateway.pure.languages.baps2 import forms
from hil_tests.lab.virtual.baps2_bench import CELL, ProgramCell, one
from hil_tests.lab.virtual.program_units_bench import VirtualUnits
from protocols.p3964r.characters import wire_block

STX, DLE = b"\x02", b"\x10"
DISABLED = 114  # DISSER_1_RCI
GO_ON = ";;SER_IO_STOP -\n"
DECLARED = "INTEGER : I, J\nREAL : R\nTEXT : T\nCHAR : C\nBINARY : B\nARRAY [1..3] INTEGER : A\nOUTPUT : 1 = LAMP, 2 = DONE"


class Coupled(ProgramCell):
    """Line ser1 with the units under test."""

    def __init__(self, files: dict[str, str], *units: ProgramUnit, priority: str = "low") -> None:
        super().__init__(files)
        line = replace(Line("ser1", "sim", layer="program"), program=units)
        if priority == "high":
            line = replace(line, priority="high")
        setup = serial_setup(replace(CELL, line=(line,)))
        assert setup is not None
        self.lines = VirtualUnits(setup, lambda: self.bench.now)
        self.language.connect(self.lines.units)

    def says(self, *expected: bytes, seconds: float = 5.0) -> None:
        """The control sends this; nothing else in between."""
        wanted, got = b"".join(expected), bytearray()

        def there() -> bool:
            got.extend(self.lines.taken("ser1"))
            return len(got) >= len(wanted)

        self.until(there, seconds)
        assert bytes(got) == wanted, (bytes(got).hex(" "), wanted.hex(" "))

    def quiet(self, seconds: float) -> None:
        self.bench.run(seconds)
        assert self.lines.taken("ser1") == b""

    def send(self, data: bytes) -> None:
        """A cycle later: no partner answers in no time."""
        self.bench.cycle()
        self.lines.send("ser1", data)

    def takes_block(self, data: bytes) -> None:
        """The control sends this block, and it is acknowledged."""
        self.says(STX)
        self.send(DLE)
        self.says(bytes(wire_block(data, True)))
        self.send(DLE)

    def gives_block(self, data: bytes) -> None:
        """The partner sends a block, which the control acknowledges."""
        self.send(STX)
        self.says(DLE)
        self.send(bytes(wire_block(data, True)))
        self.says(DLE)


def link(files: dict[str, str], **more: int | None) -> Coupled:
    return Coupled(files, ProgramUnit("V24_1", "3964R", "", 10_000, more.get("input_timeout_ms")))


def text(files: dict[str, str], procedure: str = "text", **more: int | None) -> Coupled:
    unit = ProgramUnit("V24_1", "text", "", 10_000, more.get("input_timeout_ms"))
    return Coupled(files, unit if procedure == "text" else replace(unit, procedure="echo"))


def with_head(head: str, files: dict[str, str]) -> dict[str, str]:
    return {name: head + source if name.endswith(".QLL") else source for name, source in files.items()}


@pytest.mark.requirement("RHO-SER-17", by="gateway.pure.controllers.rho3.serial.program_units:item_of")
@pytest.mark.requirement("RHO-SER-20", by="gateway.pure.controllers.rho3.serial.program_units:ProgramUnits.write")
def test_a_write_is_one_3964r_block_of_binary_values() -> None:
    cell = link(one("WRITE V24_1, 258, 1.0, CHR(65)\nWRITE V24_1, @(1, 2, 3, 4)", DECLARED))
    run = cell.start("P")
    cell.takes_block(bytes.fromhex("02010000 0000803f 41"))
    cell.takes_block(b"".join(bytes.fromhex(each) for each in ("0000803f", "00000040", "00004040", "00008040")))
    assert cell.ends(run)[:2] == ("ended", 0)


@pytest.mark.requirement("RHO-SER-21", by="gateway.pure.controllers.rho3.serial.program_units:ProgramUnits.got")
@pytest.mark.requirement("RHO-SER-25", by="gateway.pure.controllers.rho3.serial.program_units:value_of")
def test_reads_go_on_in_the_same_block_and_take_arrays_and_texts() -> None:
    body = "READ V24_1, I\nREAD V24_1, J\nREAD V24_1, A, T, C, B, R\n"
    body += (
        "IF (I = 7) AND (J = -2) AND (A[1] = 1) AND (A[3] = 3) AND (T = 'PALLET') AND (C = CHR(90)) AND (B = 1) AND (R = 0.5) THEN LAMP = 1"
    )
    cell = link(one(body, DECLARED))
    run = cell.start("P")
    cell.gives_block(bytes.fromhex("07000000 feffffff"))
    cell.gives_block(bytes.fromhex("01000000 02000000 03000000") + b"PALLET".ljust(80, b"\0") + b"Z\x01" + bytes.fromhex("0000003f"))
    assert cell.ends(run)[:2] == ("ended", 0)
    assert [(channel, value) for _, channel, value in cell.outputs] == [(1, True)]


@pytest.mark.requirement("RHO-SER-22", by="gateway.pure.languages.baps2.cell_devices:fault_of")
def test_a_block_that_ends_inside_of_a_value_is_protocol_error_read() -> None:
    cell = link(one("READ V24_1, I, J", DECLARED))
    run = cell.start("P")
    cell.gives_block(bytes.fromhex("07000000 01"))
    assert cell.ends(run)[:3] == ("aborted", 201, "Protocol error READ")


@pytest.mark.requirement("RHO-SER-32", by="gateway.pure.languages.baps2.cell_devices:CellDevices._sound")
@pytest.mark.requirement("RHO-SER-31", by="gateway.pure.controllers.rho3.serial.program_units:ProgramUnits.condition")
def test_without_an_answer_the_program_ends_or_goes_on_with_its_condition() -> None:
    body = "READ V24_1, I\nIF CONDITION(V24_1) = -3 THEN LAMP = 1\nDONE = 1"
    cell = link(one(body, DECLARED), input_timeout_ms=800)
    how, code, words, place = cell.run("P")
    assert (how, code) == ("aborted", 212) and "V24_1: Time out" in words and place.startswith("P.QLL line ")
    assert cell.outputs == []
    cell = link(with_head(GO_ON, one(body, DECLARED)), input_timeout_ms=800)
    assert cell.run("P")[:2] == ("ended", 0)
    assert [(channel, value) for _, channel, value in cell.outputs] == [(1, True), (2, True)]


@pytest.mark.requirement("RHO-SER-02", by="gateway.pure.controllers.rho3.serial.program_units:ProgramUnits.hear")
def test_a_write_that_fails_later_ends_the_program_where_it_is() -> None:
    cell = link(one("WRITE V24_1, 1\nDONE = 1\nWAIT UNTIL LAMP_IN = 1\nDONE = 0", DECLARED + "\nINPUT : 3 = LAMP_IN"))
    run = cell.start("P")
    cell.says(STX)
    how, code, words, _ = cell.ends(run)
    assert (how, code) == ("aborted", 212) and "V24_1: " in words
    assert [(channel, value) for _, channel, value in cell.outputs] == [(2, True)], "the WRITE did not hold the program up"
    assert cell.lines.taken("ser1").count(STX) == 5, "six attempts in all (L1936)"


def test_condition_waits_for_the_output_and_status_of_a_wait_does_not() -> None:
    cell = link(with_head(GO_ON, one("WRITE V24_1, 1\nI = CONDITION(V24_1)\nIF I = 0 THEN LAMP = 1", DECLARED)))
    run = cell.start("P")
    cell.says(STX)
    cell.bench.run(0.4)
    assert run not in cell.hosted.results
    cell.send(DLE)
    cell.says(bytes(wire_block(b"\x01\0\0\0", True)))
    cell.send(DLE)
    assert cell.ends(run)[0] == "ended" and cell.outputs[0][1:] == (1, True)


@pytest.mark.requirement("RHO-SER-27", by="gateway.pure.controllers.rho3.serial.program_units:ProgramUnits.turn")
@pytest.mark.requirement("RHO-SER-28", by="gateway.pure.controllers.rho3.serial.program_units:ProgramUnits.read")
def test_the_disable_signal_ends_a_read_and_refuses_the_next() -> None:
    body = "READ V24_1, I\nIF CONDITION(V24_1) = -7 THEN LAMP = 1\nREAD V24_1, I\nIF CONDITION(V24_1) = -2 THEN DONE = 1"
    cell = text(with_head(GO_ON, one(body, DECLARED)))
    cell.bench.permit(DISABLED, value=False)
    run = cell.start("P")
    cell.bench.run(0.5)
    assert run not in cell.hosted.results
    cell.bench.permit(DISABLED, value=True)
    assert cell.ends(run)[0] == "ended"
    assert [(channel, value) for _, channel, value in cell.outputs] == [(1, True), (2, True)]


@pytest.mark.requirement("RHO-SER-38", by="gateway.assembly.program_lines:serial_setup")
def test_text_is_read_with_and_without_echo() -> None:
    body = "WRITE V24_1, 'HOW MANY? ', ..\nWRITE V24_1, 12\nREAD V24_1, I, T\nIF (I = 42) AND (T = 'BOXES') THEN LAMP = 1"
    for procedure, echoed in (("text", b""), ("echo", b"42\rBOXES\r")):
        cell = text(one(body, DECLARED), procedure)
        run = cell.start("P")
        cell.says(b"HOW MANY? 12")
        cell.bench.run(0.1)
        cell.send(b"42\r")
        cell.bench.run(0.1)
        cell.send(b"BOXES\r")
        assert cell.ends(run)[0] == "ended" and cell.outputs[0][1:] == (1, True)
        assert cell.lines.taken("ser1") == echoed


@pytest.mark.requirement("RHO-SER-34", by="gateway.pure.controllers.rho3.serial.program_units:ProgramUnits.begin")
def test_write_begin_drops_what_was_prepared_and_read_begin_what_has_come() -> None:
    cell = link(
        with_head(
            GO_ON,
            one("WRITE V24_1, 1\nWRITE V24_1, 2\nWRITE_BEGIN V24_1\nREAD_BEGIN V24_1\nREAD V24_1, I\nIF I = 1 THEN LAMP = 1", DECLARED),
        )
    )
    cell.gives_block(bytes.fromhex("63000000"))  # lies there before the program begins
    run, heard = cell.start("P"), b""
    for _ in range(12):  # the partner acknowledges whatever comes
        cell.bench.run(0.5)
        if said := cell.lines.taken("ser1"):
            heard += said
            cell.send(DLE)
    assert bytes(wire_block(b"\x02\0\0\0", True)) not in heard, "the second WRITE was only prepared"
    cell.gives_block(bytes.fromhex("01000000"))
    assert cell.ends(run)[0] == "ended" and cell.outputs[0][1:] == (1, True)


@pytest.mark.requirement("RHO-SER-15", by="gateway.pure.languages.baps2.cell_devices:CellDevices.ended")
def test_a_stopped_program_gives_its_unit_back_and_the_rest_of_its_block_is_dropped() -> None:
    files = one("READ V24_1, I\nWAIT UNTIL GO = 1\nREAD V24_1, J", DECLARED + "\nINPUT : 4 = GO")
    files |= one("READ V24_1, I\nIF I = 9 THEN LAMP = 1", DECLARED, "Q")
    cell = link(files)
    run = cell.start("P")
    cell.gives_block(bytes.fromhex("01000000 02000000"))
    cell.bench.run(0.1)
    cell.language.stop_run(run, cell.bench.now)
    assert cell.ends(run)[0] == "stopped"
    second = cell.start("Q")
    cell.gives_block(bytes.fromhex("09000000"))
    assert cell.ends(second)[0] == "ended" and cell.outputs[0][1:] == (1, True)


def test_a_unit_without_a_line_has_no_interface_and_a_held_write_goes_out_as_one() -> None:
    cell = link(
        with_head(GO_ON, one("WRITE V24_2, 1\nIF CONDITION(V24_2) = -1 THEN LAMP = 1\nWRITE V24_1, 1, ..\nWRITE V24_1, 2", DECLARED))
    )
    run = cell.start("P")
    cell.takes_block(bytes.fromhex("01000000 02000000"))
    assert cell.ends(run)[0] == "ended" and cell.outputs[0][1:] == (1, True)


def test_seventeen_writes_wait_for_room_and_all_arrive() -> None:
    cell = link(
        one("FOR_I = 0\nREPEAT 20 TIMES\nFOR_I = FOR_I + 1\nWRITE V24_1, FOR_I\nREPEAT_END\nDONE = 1", DECLARED + "\nINTEGER : FOR_I")
    )
    run = cell.start("P")
    for number in range(1, 21):
        cell.takes_block(number.to_bytes(4, "little"))
    assert cell.ends(run)[0] == "ended" and cell.outputs[0][1:] == (2, True)


@pytest.mark.parametrize(
    "value, text",
    [
        (-1234.45, "-1234.45"), (0.0, "     0.0"), (1.5, "     1.5"), (0.00012, " 0.00012"), (3.14159265, "3.141593"),
        (-3.14159265, "-3.14159"), (-1234.567, "-1234.57"), (1234567.8, "1234568."), (12345678.0, "12345678"), (1e20, "1.00E+20"),
        (-1.5e30, "-1.5E+30"), (1.23e-5, "1.23E-05"), (-1e-7, "-1.0E-07"), (3.4e38, "3.40E+38"), (-3.4e-38, "-3.4E-38"),
    ],
)  # fmt: skip
def test_a_real_is_written_in_eight_characters(value: float, text: str) -> None:
    """L9853-9857, AX-1821."""
    assert forms.real_text(value) == text
    data = forms.encode("REAL", value, binary=False)
    assert data == text.encode() and forms.decode_letters("REAL", 0, data)[0] == float(text)
