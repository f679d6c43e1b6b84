"""External program selection and abort, and the process table under them."""

import pytest

from gateway.pure.controllers.rho3.functions.processes import ProcessFault, ProcessTable, Stopped, Turn
from hil_tests.unit.gateway.pure.controllers.rho3.functions.plant import CYCLE, P9, Plant, idle, program
from protocols.base.machine import Ns

ABORT, SELECT, PARITY = 80, 81, 83
ABORTED, ABORT_ERROR, SELECTED, SELECT_ERROR = ANSWERS = (116, 117, 120, 121)
HALF = P9 // CYCLE


def order(plant: Plant, code: int, *strobes: int, parity: bool | None = None) -> list[int]:
    """Code and parity stand, strobes rise; the outputs one cycle later."""
    plant.number(88, 8, code).put(PARITY, bool(code.bit_count() & 1) if parity is None else parity).cycle()
    for strobe in strobes:
        plant.put(strobe)
    return plant.cycle().outs(*ANSWERS)


@pytest.mark.requirement(
    "RHO-PLC-15",
    by=(
        "gateway.pure.controllers.rho3.functions.external_programs:ExternalPrograms.step",
        "gateway.pure.controllers.rho3.functions.external_programs:ExternalPrograms._abort",
    ),
)
def test_code_2_aborts_progxy_at_once() -> None:
    plant = Plant()
    plant.start("PROGXY")
    plant.start("OTHER")
    assert order(plant, 2, ABORT) == [ABORTED]
    assert plant.names() == ["OTHER"]
    assert plant.processes.take_stopped() == [Stopped("PROGXY", 2)], "its motion is not finished"
    assert plant.pulses(ABORTED, 3 * HALF) == [(1, HALF - 1, 1), (0, 2 * HALF + 1, 1)]


@pytest.mark.requirement("RHO-PLC-15", by="gateway.pure.controllers.rho3.functions.external_programs:ExternalPrograms._name")
@pytest.mark.parametrize(
    "code, parity, why", [(2, False, "parity"), (7, False, "parity"), (3, False, "no_code"), (0xFE, True, "no_process")]
)
def test_wrong_parity_or_an_unknown_process_sets_bit_117(code: int, parity: bool, why: str) -> None:
    plant = Plant()
    plant.start("PROGXY")
    plant.start("OTHER")
    assert order(plant, code, ABORT, parity=parity) == [ABORT_ERROR]
    assert plant.refused == [why] and plant.names() == ["PROGXY", "OTHER"]
    assert plant.pulses(ABORT_ERROR, 3 * HALF) == [(1, HALF - 1, 1), (0, 2 * HALF + 1, 1)]


def test_permanent_processes_are_aborted_whatever_bit_61_says() -> None:
    plant = Plant()
    plant.start("OTHER")
    plant.put(61)
    assert order(plant, 7, ABORT) == [ABORTED] and plant.names() == []


@pytest.mark.requirement(
    "RHO-PLC-16",
    by=(
        "gateway.pure.controllers.rho3.functions.processes:ProcessTable.stop",
        "gateway.pure.controllers.rho3.functions.processes:ProcessTable.family",
    ),
)
def test_aborting_the_main_process_takes_its_sub_processes_along() -> None:
    plant = Plant()
    main = plant.start("MAIN")
    branch = plant.start("BRANCH", main.number, idle)
    started = plant.start("PROGXY", branch.number)
    plant.start("OTHER")
    assert [started.kind.name, branch.kind.name, branch.priority] == ["SUB", "SUB", main.priority]
    assert order(plant, 1, ABORT) == [ABORTED]
    assert plant.names() == ["OTHER"]
    assert {stopped.name for stopped in plant.processes.take_stopped()} == {"MAIN", "BRANCH", "PROGXY"}


@pytest.mark.requirement(
    "RHO-PLC-17",
    by=(
        "gateway.pure.controllers.rho3.functions.external_programs:ExternalPrograms._name",
        "gateway.pure.controllers.rho3.functions.external_programs:ExternalPrograms.step",
    ),
)
def test_both_strobes_at_once_do_nothing() -> None:
    plant = Plant()
    plant.start("PROGXY")
    assert order(plant, 2, ABORT, SELECT) == [ABORT_ERROR, SELECT_ERROR]
    assert plant.refused == ["both_strobes", "both_strobes"]
    assert plant.names() == ["PROGXY"]
    plant.put(SELECT, False).put(ABORT, False).wait(3 * P9)
    assert order(plant, 2, ABORT) == [ABORTED], "one alone works again"
    plant.wait(3 * P9)
    assert order(plant, 1, SELECT) == [SELECT_ERROR], "the abort strobe still stands"
    assert plant.names() == []


def test_selection_starts_a_program_once() -> None:
    plant = Plant()
    assert order(plant, 1, SELECT) == [SELECTED]
    plant.wait(5 * P9)
    assert plant.names() == ["MAIN"], "a strobe that stands starts nothing more"
    plant.put(SELECT, False).cycle()
    assert order(plant, 1, SELECT) == [SELECT_ERROR] and plant.refused == ["not_started"], "1051: it exists already"
    plant.put(SELECT, False).wait(3 * P9)
    assert order(plant, 0xFE, SELECT) == [SELECT_ERROR] and plant.names() == ["MAIN"]


# ------------------------------------------------------------------------------------------------------------ the table


def test_lower_numbers_run_first_equal_ones_take_turns() -> None:
    ran: list[str] = []

    def saying(name: str) -> object:
        def body(_: Ns) -> Turn:
            ran.append(name)
            return Turn.GO_ON

        return body

    bodies = {name: saying(name) for name in "ABC"}
    table = ProcessTable({name: program(priority=10 if name == "C" else 140, body=body) for name, body in bodies.items() if callable(body)})
    for name in "ABC":
        table.start(name)
    for now in range(4):
        table.step(now)
    assert "".join(ran) in ("CABCBACABCBA", "CBACABCBACAB")


def test_a_faulty_body_ends_itself_alone_and_its_error_is_shown_to_the_plc() -> None:
    def broken(_: Ns) -> Turn:
        raise ProcessFault(91, "Inadmiss. meas. sys.")

    def defect(_: Ns) -> Turn:
        return Turn(1 // 0)

    plant = Plant()
    main = plant.start("MAIN")
    plant.start("BROKEN", main.number, broken)
    plant.start("DEFECT", main.number, defect)
    plant.cycle(3)
    assert [(process.name, process.state.name, process.error) for process in plant.processes.processes] == [
        ("MAIN", "WAITING", 0),
        ("BROKEN", "FAULTY", 91),
        ("DEFECT", "FAULTY", 1255),
    ]
    assert {record.code for record in plant.errors.records} == {91, 1255}
    assert [process.turns for process in plant.processes.processes] == [3, 1, 1]


def test_a_finished_process_leaves_and_its_children_go_on() -> None:
    plant = Plant()
    plant.processes.programs["SHORT"] = program(body=lambda _: Turn.DONE)
    short = plant.start("SHORT")
    child = plant.start("CHILD", short.number, idle)
    main = plant.start("MAIN")
    middle = plant.start("MIDDLE", main.number, lambda _: Turn.DONE)
    low = plant.start("LOW", middle.number, idle)
    plant.cycle()
    assert plant.names() == ["CHILD", "MAIN", "LOW"] and plant.processes.take_stopped() == []
    assert (child.parent, low.parent) == (0, main.number)


def test_refusals_of_the_table_carry_the_manuals_codes() -> None:
    plant = Plant()
    main = plant.start("MAIN")
    sub = plant.start("SUBA", main.number, idle)
    for call, code in (
        (lambda: plant.processes.start("MAIN"), 1051),
        (lambda: plant.processes.start("NONE"), 1092),
        (lambda: plant.processes.stop(main.number, by=sub.number), 1079),
    ):
        with pytest.raises(ProcessFault) as found:
            call()
        assert found.value.code == code
    assert plant.names() == ["MAIN", "SUBA"]
    assert plant.processes.stop(sub.number, by=main.number) == ("SUBA",)
    assert plant.processes.stop(99) == ()
    assert plant.processes.stop(main.number, by=main.number) == ("MAIN",), "a process may end itself"


@pytest.mark.parametrize("keep, left", [(True, ["OTHER", "CHILD"]), (False, [])])
def test_control_reset_ends_all_but_permanent_ones_where_bit_61_says_so(keep: bool, left: list[str]) -> None:
    plant = Plant()
    main, permanent = plant.start("MAIN"), plant.start("OTHER")
    plant.start("SUBA", main.number, idle)
    plant.start("CHILD", permanent.number, idle)
    gone = plant.processes.control_reset(keep)
    assert plant.names() == left and set(gone) == {"MAIN", "SUBA", "OTHER", "CHILD"} - set(left)
