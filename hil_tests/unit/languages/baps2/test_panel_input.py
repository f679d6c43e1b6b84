"""READ PHG of BAPS2 programs in a cell: keys of the panel are what they read (rho 3 releases L6623-6717, AX-1121)."""

from gateway.services.rho3_panel import Rho3Panel
from hil_tests.lab.virtual.baps2_bench import ProgramCell, one


def cell_of(body: str, declared: str) -> ProgramCell:
    return ProgramCell(one(body, declared))


def press(cell: ProgramCell, *keys: str) -> list[str]:
    """Keys of the panel, one behind the other; the screen."""
    panel = Rho3Panel(cell.control, cell.bench.dispatcher)
    for key in keys:
        panel.answer({"key": key}, 1, cell.bench.now)
    cell.bench.run(0.2)
    shown = panel.answer({}, 1, cell.bench.now)["screen"]
    assert isinstance(shown, list)
    return [str(line).strip() for line in shown]


READS = """WRITE PHG, CLS, 'HOW MANY?'
READ N, R
WRITE ' NAME '
READ NAME
READ PHG, C
OUT = 1
WRITE_BEGIN LOG
WRITE LOG, N, ' ', R, ' ', NAME, ' ', C
CLOSE LOG"""


def test_what_an_operator_types_is_what_read_phg_reads() -> None:
    cell = cell_of(READS, "INTEGER : N\nREAL : R\nTEXT : NAME\nCHAR : C\nFILE : LOG\nOUTPUT : 1 = OUT")
    run = cell.start("P")
    cell.bench.run(0.2)
    assert press(cell, "1", "7", "DELETE", "2")[0] == "HOW MANY?12", "what is typed is shown"
    assert not cell.hosted.results and cell.control.functions.phg.mode == "0"
    press(cell, "ENTER", *"2.5", "ENTER", *"AB1", "ENTER")
    assert cell.outputs == [], "it reads one more"
    press(cell, "Y")
    assert cell.ends(run)[:2] == ("ended", 0)
    assert cell.memory.files["LOG.DAT"] == b"12      2.5 AB1 Y\r\n"
    press(cell, "MODE", "7", "ENTER")
    assert cell.control.functions.phg.mode == "7", "the keys are the system's again"


def test_an_operator_may_go_to_a_mode_while_a_program_reads_and_a_stopped_program_reads_no_more() -> None:
    cell = cell_of("READ N\nJUMP ON\nON:", "INTEGER : N")
    cell.start("P")
    cell.bench.run(0.2)
    press(cell, "4", "MODE", "7", "ENTER")
    assert cell.control.functions.phg.mode == "7" and not cell.hosted.results
    cell.control.processes.stop(cell.control.processes.processes[0].number)
    cell.bench.run(0.2)
    press(cell, "MODE", "1", "ENTER")
    assert cell.control.functions.phg.mode == "7.1"


def test_keys_typed_ahead_are_for_the_next_read() -> None:
    cell = cell_of("READ N\nREAD M\nWRITE_BEGIN LOG\nWRITE LOG, N, ' ', M\nCLOSE LOG", "INTEGER : N, M\nFILE : LOG")
    run = cell.start("P")
    cell.bench.run(0.2)
    press(cell, "4", "ENTER", "5", "ENTER")
    assert cell.ends(run)[:2] == ("ended", 0)
    assert cell.memory.files["LOG.DAT"] == b"4 5\r\n"


def test_a_line_that_is_no_number_ends_the_program_with_the_error_of_a_read() -> None:
    cell = cell_of("READ N", "INTEGER : N")
    run = cell.start("P")
    cell.bench.run(0.2)
    press(cell, *"4X", "ENTER")
    assert cell.ends(run)[:3] == ("aborted", 201, "Protocol error READ")


def test_what_a_write_keeps_open_is_on_the_panel_while_the_program_reads() -> None:
    cell = cell_of("WRITE CLS\nWRITE 'HOW MANY? ', ..\nREAD N\nWRITE N, ' IT IS'", "INTEGER : N")
    cell.start("P")
    cell.bench.run(0.2)
    assert press(cell, "7")[0] == "HOW MANY? 7", "L5760-5762"
    assert press(cell, "ENTER")[:2] == ["HOW MANY? 7", "7 IT IS"]


def test_umlauts_of_a_source_are_on_the_panel_whatever_editor_wrote_them() -> None:
    for page in ("utf-8", "cp437"):
        cell = cell_of("WRITE 'TEIL PR\u00dcFEN'\nREAD N", "INTEGER : N")
        cell.memory.files["P.QLL"] = cell.memory.files["P.QLL"].decode("utf-8").encode(page)
        cell.start("P")
        cell.bench.run(0.2)
        assert press(cell)[0] == "TEIL PR\u00dcFEN"
