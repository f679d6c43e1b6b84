"""Processes that wait for each other are told of, and go on waiting (AX-1731)."""

import pathlib

from gateway.pure.controllers.rho3.functions.system_variables import SystemVariables
from gateway.pure.controllers.rho3.pendant.pages import page_of
from gateway.web.german import german
from hil_tests.lab.virtual.baps2_bench import ProgramCell
from hil_tests.unit.languages.baps2.running import Event, body, faults_of, run, short
from hil_tests.unit.languages.baps2.test_two_robots_in_a_cell import memory, two_portals

BEGINS = "these processes wait for each other, and none continues until one is stopped: "
OWN = "EXCLUSIVE S\nPARALLEL\nEXCLUSIVE S\nWRITE 'A'\nEXCLUSIVE_END\nALSO\nWRITE 'B'\nPARALLEL_END\nEXCLUSIVE_END"
TWO = ";;KINEMATICS : (1 = K1, 2 = K2)\n;;K1.JC_NAMES = A\n;;K2.JC_NAMES = B\n"
BELTS = ";;KINEMATICS : (1 = K1, 2 = K2)\n;;K1.JC_NAMES = A, C\n;;K2.JC_NAMES = B, D\n"


def told(events: list[Event]) -> list[tuple[object, str]]:
    return [(event["t"], str(event["text"]).removeprefix(BEGINS)) for event in events if event["event"] == "warning"]


def test_a_branch_that_enters_what_its_program_holds() -> None:
    text = body(OWN, "SEMAPHORE : S")
    assert faults_of(text) == [("semaphore-held", 6)]
    words = "P line 5 waits for its branch in line 6; P line 6 (branch) waits for semaphore S, held by P line 5"
    assert told(run(text)) == [(0.0, words)]
    assert german(BEGINS + words).endswith("P Zeile 6 (Zweig) wartet auf Semaphor S, belegt durch P Zeile 5")


def test_two_semaphores_the_other_way_round() -> None:
    one = "EXCLUSIVE {0}\nWAIT 1\nEXCLUSIVE {1}\nI = 1\nEXCLUSIVE_END\nEXCLUSIVE_END"
    text = body(f"PARALLEL\n{one.format('S', 'T')}\nALSO\n{one.format('T', 'S')}\nPARALLEL_END", "SEMAPHORE : S, T INTEGER : I")
    first, second = "P line 7 (branch)", "P line 14 (branch)"
    words = f"{first} waits for semaphore T, held by {second}; {second} waits for semaphore S, held by {first}"
    assert told(run(text)) == [(1.0, words)]


def test_one_whose_part_is_over_but_for_its_blocks_is_no_circle() -> None:
    first = "EXCLUSIVE S\nMOVE K1 TO @(1)\nEXCLUSIVE_END\nEXCLUSIVE T\nI = 1\nEXCLUSIVE_END"
    text = f"PARALLEL\n{first}\nALSO\nEXCLUSIVE T\nWAIT 0.5\nEXCLUSIVE S\nI = 2\nEXCLUSIVE_END\nEXCLUSIVE_END\nPARALLEL_END"
    events = run(TWO + body(text, "SEMAPHORE : S, T INTEGER : I"))
    assert told(events) == [] and events[-1]["how"] == "ended"


def test_two_branches_that_move_two_kinematics_in_turn_let_each_other_by() -> None:
    one = "MOVE {0} TO @(1)\nMOVE {1} TO @(2)\nMOVE {0} TO @(3)"
    events = run(TWO + body(f"PARALLEL\n{one.format('K1', 'K2')}\nALSO\n{one.format('K2', 'K1')}\nPARALLEL_END"))
    assert [row[0] for row in short(events, "moving")] == [0.0, 0.0, 1.0, 1.0, 2.0, 2.0]


def test_the_synchronous_part_of_one_program_is_not_the_others() -> None:
    """Others wait for the kinematic (L6111), and SYNCHRON_END is that of its own program."""
    declared = "EXTERNAL : Q K1.BELT : 501 = C K2.BELT : 502 = D"
    mine = "START Q\nSYNCHRON K1 C\nMOVE K1 LINEAR TO @(1, 10)\nWAIT 2\nMOVE K1 LINEAR TO @(2, 20)\nSYNCHRON_END"
    synchronous = "SYNCHRON K2 D\nWAIT 0.5\nSYNCHRON_END"
    other = f"PROGRAM Q\nK2.BELT : 502 = D\nBEGIN\n{synchronous}\nMOVE K1 LINEAR TO @(9, 0)\nPROGRAM_END\n"
    events = run(BELTS + body(mine, declared), Q=BELTS + other)
    assert [row[0] for row in short(events, "moving")] == [0.0, 3.0, 4.0]


def test_a_circle_of_a_semaphore_and_a_synchronous_part() -> None:
    declared = "EXTERNAL : Q PUBLIC SEMAPHORE : S K1.BELT : 501 = C"
    mine = "START Q\nSYNCHRON K1 C\nWAIT 1\nEXCLUSIVE S\nEXCLUSIVE_END\nSYNCHRON_END"
    other = "PROGRAM Q\nEXTERNAL P : S\nBEGIN\nEXCLUSIVE S\nMOVE K1 LINEAR TO @(9, 0)\nEXCLUSIVE_END\nPROGRAM_END\n"
    events = run(BELTS + body(mine, declared), Q=BELTS + other)
    words = "P line 10 waits for semaphore S, held by Q line 8; Q line 8 waits for kinematic K1, held by P line 10"
    assert told(events) == [(1.0, words)]


def test_a_cell_shows_who_waits_for_whom(tmp_path: pathlib.Path) -> None:
    cell = ProgramCell(memory(OWN, "SEMAPHORE : S"), two_portals(tmp_path))
    run = cell.start("P")
    cell.bench.run(0.2)
    rows = {row.branch: (row.waits, row.held, row.holder, row.stuck) for row in cell.language.rows()}
    assert rows == {False: ("its branches", "", "", True), True: ("a semaphore", "semaphore S", "P line 11", True)}
    assert page_of((7, 3, 2), cell.control.pendant.view, "en").rows == ("P           blocked", " S", " has: P 11")
    variables = SystemVariables(cell.control.processes)
    variables.write(34310, 1)
    assert variables.read(34313) == "blocked"
    assert cell.port is not None and len([each for each in cell.port.words if BEGINS in each]) == 1
    cell.control.processes.stop(cell.control.processes.processes[0].number)
    assert cell.ends(run)[0] == "stopped"
    assert cell.language.rows() == [] and cell.control.processes.processes == ()


def test_a_process_that_waits_for_another_one_names_it(tmp_path: pathlib.Path) -> None:
    files = memory("EXCLUSIVE S\nWAIT 30\nEXCLUSIVE_END", "PUBLIC SEMAPHORE : S")
    files |= memory("EXCLUSIVE S\nEXCLUSIVE_END", "EXTERNAL P : S", name="Q")
    cell = ProgramCell(files, two_portals(tmp_path))
    cell.start("P")
    cell.bench.run(0.1)
    cell.start("Q")
    cell.bench.run(0.1)
    assert page_of((7, 3, 2), cell.control.pendant.view, "de").rows == ("P           wartet", "Q           wartet", " S", " hat: P 11")
