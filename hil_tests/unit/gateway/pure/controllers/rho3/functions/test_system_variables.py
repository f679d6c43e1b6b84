"""PHG 2000 variables: process counts, list and stop; file lines."""

import pytest

from gateway.pure.controllers.rho3.functions.processes import Kind, ProcessFault, Turn
from gateway.pure.controllers.rho3.functions.system_variables import FileEntry, SystemVariables, VariableError
from hil_tests.unit.gateway.pure.controllers.rho3.functions.plant import Plant, idle, program
from protocols.base.machine import Ns

FILES = (FileEntry("PHG_2001.PKT", 848, "24.09.95", "09:40"), FileEntry("A.IRD", 1052, "25.08.95", "14:11"))


def fails(_: Ns) -> Turn:
    raise ProcessFault(91, "Inadmiss. measuring system")


def plant_of_six() -> tuple[Plant, SystemVariables]:
    plant = Plant()
    plant.processes.programs |= {"BAD": program(body=fails), "PERM": program(Kind.PERMANENT, priority=130)}
    main = plant.start("MAIN")
    for name, parent in (("PERM", 0), ("OTHER", 0), ("BAD", 0)):
        plant.start(name, parent)
    plant.start("SUBA", main.number, idle)
    plant.start("SUBB", main.number, idle)
    plant.cycle()
    return plant, SystemVariables(plant.processes, FILES)


@pytest.mark.requirement("RHO-PHG-05", by="gateway.pure.controllers.rho3.functions.system_variables:SystemVariables.write")
def test_writing_1_to_34322_stops_the_selected_process_alone() -> None:
    plant, variables = plant_of_six()
    variables.write(34310, 5)
    assert variables.read(34316) == "SUBA"
    variables.write(34322, 0)
    assert "SUBA" in plant.names(), "the key was let go"
    variables.write(34322, 1)
    assert plant.names() == ["MAIN", "PERM", "OTHER", "BAD", "SUBB"]
    assert [stopped.name for stopped in plant.processes.take_stopped()] == ["SUBA"]
    variables.write(34322, 1)
    assert len(plant.names()) == 5, "the next one in the list is not selected by itself"


@pytest.mark.requirement(
    "RHO-PHG-05",
    by=(
        "gateway.pure.controllers.rho3.functions.system_variables:SystemVariables.write",
        "gateway.pure.controllers.rho3.functions.processes:ProcessTable.stop",
    ),
)
def test_a_stopped_main_process_takes_its_sub_processes_along() -> None:
    plant, variables = plant_of_six()
    main, sub = (plant.processes.named(name) for name in ("MAIN", "SUBA"))
    assert main is not None and sub is not None
    with pytest.raises(ProcessFault, match="1079"):
        plant.processes.stop(main.number, by=sub.number)
    variables.write(34310, 1)
    variables.write(34322, 1)
    assert plant.names() == ["PERM", "OTHER", "BAD"]
    assert [stopped.name for stopped in plant.processes.take_stopped()] == ["MAIN", "SUBA", "SUBB"]
    assert plant.processes.stop(main.number) == (), "it is gone"


@pytest.mark.requirement("RHO-PHG-06", by="gateway.pure.controllers.rho3.functions.system_variables:SystemVariables.read")
def test_counts_and_process_list() -> None:
    _, variables = plant_of_six()
    counts = [variables.read(code) for code in (34305, 34306, 34307, 34308)]
    assert counts == [2, 2, 2, 1]  # MAIN, BAD; PERM, OTHER; SUBA, SUBB; BAD
    names = [variables.read(34309, line) for line in range(1, 8)]
    assert names == ["MAIN", "PERM", "OTHER", "BAD", "SUBA", "SUBB", ""]


@pytest.mark.requirement("RHO-PHG-06", by="gateway.pure.controllers.rho3.functions.system_variables:SystemVariables._of_files")
def test_one_line_of_a_file_has_name_size_and_date() -> None:
    _, variables = plant_of_six()
    assert variables.read(34561, 1) == "PHG_2001.PKT      848 Byte  24.09.95  09:40"
    assert variables.read(34561, 2) == "A.IRD            1052 Byte  25.08.95  14:11"
    assert [variables.read(code, 2) for code in (34562, 34563, 34564)] == [
        "A.IRD            1052 Byte",
        "A.IRD         25.08.95  14:11",
        "A.IRD       ",
    ]
    assert variables.read(34561, 3) == ""
    assert [variables.read(code) for code in (34568, 34569, 34570)] == [131072, 1900, 129172]
    assert variables.read(34567) == "131072 Bytes     1900 used   129172 free"


def test_the_selected_process_in_detail() -> None:
    _, variables = plant_of_six()
    assert [variables.read(code) for code in range(34310, 34322)] == [0, "", 0, "", "", 0, "", 0, 0, 0, 0, ""]
    variables.write(34310, 4)
    assert [variables.read(code) for code in range(34310, 34322)] == [
        4, "normal", 140, "error", "", 0, "BAD", 0, 0, 1, 91, "Inadmiss. measuring ",
    ]  # fmt: skip


@pytest.mark.parametrize("code, index", [(34304, 1), (34322, 1), (34571, 1), (0, 1), (34309, 0), (34309, 101), (34561, 1001), (34561, -1)])
def test_what_is_no_variable_is_refused(code: int, index: int) -> None:
    _, variables = plant_of_six()
    with pytest.raises(VariableError):
        variables.read(code, index)
    if code != 34322:
        with pytest.raises(VariableError):
            variables.write(code, 1)
    for value in (0, 101):
        with pytest.raises(VariableError):
            variables.write(34310, value)
