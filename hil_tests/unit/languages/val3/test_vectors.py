"""The worked examples of the manual, as applications on a disk: through files, checker and scheduler to the values the manual prints."""

import pathlib
import tomllib
from typing import Any

import pytest

from gateway.files.val3_disk import place_of, read_disk
from gateway.pure.languages.val3.loader import Loader
from gateway.pure.languages.val3.machine import Machine
from gateway.pure.languages.val3.moves import Moves
from gateway.pure.languages.val3.virtual import Run, declare_links
from gateway.pure.languages.val3.virtual_events import event_of
from hil_tests.unit.languages.val3.apps import ROBOT, VECTORS

START = (0.0, 0.0, 90.0, 0.0, 90.0, 0.0)


def golden(name: str) -> dict[str, object]:
    """What the vector expects."""
    return tomllib.loads((VECTORS / name / "golden.toml").read_text())


def listed(expected: dict[str, object], what: str) -> list[Any]:
    """Rows of an array; none where it is not given."""
    rows = expected.get(what, [])
    assert isinstance(rows, list)
    return rows


def application(name: str, expected: dict[str, object]) -> pathlib.Path:
    """Its first application: named, or the one with a program start."""
    found = [path for path in sorted((VECTORS / name).glob("*/*.pjx")) if (path.parent / "start.pgx").exists()]
    named = [path for path in found if path.stem == expected.get("app", path.stem)]
    assert len(named) == 1, [str(path) for path in named]
    return named[0]


def result_of(name: str) -> tuple[dict[str, object], Machine]:
    """Globals, tasks, moves and the rest of one run."""
    expected = golden(name)
    root, folder, own_name = place_of(application(name, expected), VECTORS / name)
    line_us = expected.get("line_us", 1)
    assert isinstance(line_us, int)
    machine = Machine(read_disk(root), Moves(ROBOT, START) if expected.get("arm") else None, line_us * 1000)
    references = expected.get("references", {})
    assert isinstance(references, dict)
    machine.references = {each: tuple(joints) for each, joints in references.items()}
    own = machine.instance(folder, own_name, "")
    assert own is not None, machine.log
    declare_links(machine, own.data.values())
    at = expected.get("at", [])
    until = expected.get("until_s", 10.0)
    assert isinstance(at, list) and isinstance(until, int | float)
    run = Run(machine, own, round(until * 1e9), [event_of(str(seconds), what) for seconds, what in at])
    run.go()
    return run.result(), machine


def value_at(result: dict[str, object], what: str) -> object:
    """tr[1].x, moves[0].target.j1."""
    globals_ = result["globals"]
    assert isinstance(globals_, dict)
    here: object = {**globals_, "moves": result["moves"]}
    for step in what.replace("[", ".[").split("."):
        if step.startswith("["):
            assert isinstance(here, list), what
            here = here[int(step[1:-1])]
        else:
            assert isinstance(here, dict), what
            here = here[step]
    return here


def differs(given: object, wanted: object, within: float) -> bool:
    """Deep; fields the golden value does not name are not looked at."""
    if isinstance(wanted, dict):
        return not isinstance(given, dict) or any(differs(given.get(name), each, within) for name, each in wanted.items())
    if isinstance(wanted, list):
        return not isinstance(given, list) or len(given) != len(wanted) or any(map(differs, given, wanted, [within] * len(wanted)))
    if isinstance(wanted, float | int) and not isinstance(wanted, bool):
        return not isinstance(given, float | int) or isinstance(given, bool) or not abs(given - wanted) <= within
    return given is not wanted if isinstance(wanted, bool) else given != wanted


def check_vector(name: str) -> None:
    """Everything golden.toml says."""
    expected = golden(name)
    if faults := expected.get("fault"):
        root, folder, own = place_of(application(name, expected), VECTORS / name)
        loaded = Loader(read_disk(root)).load(folder, own)
        assert loaded is not None and isinstance(faults, list)
        found = [(fault.position.file, fault.position.line, fault.text) for fault in loaded.faults]
        assert sorted(found) == sorted((each["file"], each["line"], each["text"]) for each in faults)
        return
    result, machine = result_of(name)
    tasks = {task: each["status"] for task, each in result["tasks"].items()} if isinstance(result["tasks"], dict) else {}
    assert tasks == expected.get("tasks", {}), result["log"]
    wanted = expected.get("globals", {})
    assert isinstance(wanted, dict) and isinstance(result["globals"], dict)
    seen = {each: (result["globals"].get(each), value) for each, value in wanted.items()}
    wrong = {each: pair for each, pair in seen.items() if differs(pair[0], pair[1], 1e-9)}
    for each in listed(expected, "near"):
        if differs(value_at(result, each["what"]), each["is"], each["within"]):
            wrong[each["what"]] = (value_at(result, each["what"]), each["is"])
    for each in listed(expected, "between"):
        value = value_at(result, each["what"])
        if not (isinstance(value, float | int) and each["from"] <= value <= each["to"]):
            wrong[each["what"]] = (value, (each["from"], each["to"]))
    assert not wrong, (wrong, result["log"])
    if "popups" in expected:
        assert result["popups"] == expected["popups"]
    if "moves" in expected:
        assert isinstance(result["moves"], list) and len(result["moves"]) == expected["moves"]
    if "pages" in expected:
        assert machine.pages.shown() == expected["pages"]
    if "sent" in expected:
        assert {name: data.hex() for name, data in machine.sio.sent.items()} == expected["sent"]
    for text in listed(expected, "logged"):
        assert any(str(line).endswith(text) for line in machine.log), text


V = "gateway.pure.languages.val3."
PROOFS = [
    ("control_flow", ("VAL-LANG-01", "VAL-LANG-04", "VAL-LANG-08"), V + "translate:ProgramTranslator._do_case"),
    ("control_flow", ("VAL-LANG-07", "VAL-LANG-09"), V + "translate:ProgramTranslator._do_for"),
    ("lamp_while_moving", ("VAL-LANG-05", "VAL-MOV-08"), V + "builtin_moves:f_is_settled"),
    ("rotating_axis_1", ("VAL-LANG-06", "VAL-MOV-01"), V + "translate:ProgramTranslator._do_for"),
    ("data_and_containers", ("VAL-LANG-21", "VAL-VAR-01", "VAL-VAR-03"), V + "values:rounded"),
    ("data_and_containers", ("VAL-VAR-04", "VAL-VAR-05", "VAL-VAR-06"), V + "arrays:f_size_of"),
    ("data_and_containers", ("VAL-VAR-07", "VAL-VAR-08", "VAL-VAR-09"), V + "arrays:f_next"),
    (
        "containers_refused",
        ("VAL-LANG-11", "VAL-LANG-19", "VAL-MOV-02"),
        "gateway.pure.languages.val3.value_expressions:ValueTranslator.fault",
    ),
    ("parameters", ("VAL-LANG-18", "VAL-LANG-19", "VAL-LANG-20"), V + "tasks:Task.enter"),
    ("named_data", ("VAL-VAR-11",), V + "builtin_libraries:f_get_data"),
    ("numbers", ("VAL-NUM-01", "VAL-NUM-02", "VAL-NUM-03"), V + "numbers:f_sin"),
    ("numbers", ("VAL-NUM-04", "VAL-NUM-05", "VAL-LANG-15"), V + "numbers:f_round"),
    ("bit_fields", ("VAL-BIT-01", "VAL-BIT-02", "VAL-LANG-14"), V + "numbers:f_b_not"),
    ("binary_formats", ("VAL-BIT-03", "VAL-BIT-04", "VAL-BIT-05"), V + "numbers:f_to_binary"),
    ("strings", ("VAL-STR-01", "VAL-STR-02", "VAL-STR-06"), V + "strings:f_to_string"),
    ("strings", ("VAL-STR-03", "VAL-STR-04", "VAL-STR-11"), V + "strings:f_to_num"),
    ("strings", ("VAL-STR-07", "VAL-STR-08", "VAL-STR-09"), V + "strings:f_insert_text"),
    ("strings", ("VAL-STR-05", "VAL-STR-10"), V + "strings:f_find"),
    ("trsf_through_sockets", ("VAL-SIO-04", "VAL-SIO-12"), V + "virtual_sio:VirtualSio.hear"),
    ("inputs_and_outputs", ("VAL-DIO-01", "VAL-DIO-02", "VAL-DIO-05"), V + "virtual_io:VirtualIo.write"),
    ("inputs_and_outputs", ("VAL-DIO-03", "VAL-DIO-04", "VAL-DIO-08"), V + "builtin_io:f_dio_set"),
    ("inputs_and_outputs", ("VAL-DIO-06", "VAL-DIO-07", "VAL-SIO-17"), V + "virtual_io:VirtualIo.write"),
    ("user_pages", ("VAL-UI-01", "VAL-UI-02"), V + "pages:PageBoard.bind"),
    ("user_pages", ("VAL-UI-03", "VAL-UI-04"), V + "pages:PageBoard.happen"),
    ("user_pages", ("VAL-UI-05",), V + "builtin_pages:f_user_page_prompt"),
    ("language_and_date", ("VAL-UI-06", "VAL-UI-07", "VAL-UI-08"), V + "builtin_pages:f_set_profile"),
    ("rendezvous", ("VAL-TASK-13", "VAL-TASK-14"), V + "builtin_tasks:f_set_mutex"),
    ("tasks", ("VAL-TASK-01", "VAL-TASK-03", "VAL-TASK-04"), V + "builtin_tasks:f_watch"),
    ("tasks", ("VAL-TASK-07", "VAL-SYNC-01"), V + "builtin_tasks:f_task_create_sync"),
    ("libraries", ("VAL-LIB-01", "VAL-LIB-02", "VAL-LIB-04"), V + "machine:Machine.load_library"),
    ("libraries", ("VAL-LIB-05", "VAL-LIB-07"), V + "builtin_libraries:f_lib_exist"),
    ("power_and_speed", ("VAL-ROB-03", "VAL-ROB-05"), V + "robot_state:RobotState.stop"),
    ("power_and_speed", ("VAL-ROB-06",), V + "builtin_robot:f_brake_test"),
    ("joints", ("VAL-JNT-01", "VAL-JNT-02"), V + "builtin_geometry:joint_below"),
    ("joints", ("VAL-LATCH-01",), V + "controller:Latch.tick"),
    ("transformations", ("VAL-TRSF-01", "VAL-TRSF-02", "VAL-TRSF-03"), V + "builtin_geometry:trsf_product"),
    ("transformations", ("VAL-TRSF-04", "VAL-PNT-02"), V + "builtin_geometry:f_interpolate_c"),
    ("transformations", ("VAL-FRM-01", "VAL-FRM-02", "VAL-PNT-03"), V + "builtin_geometry:f_set_frame"),
    ("u_cycle", ("VAL-MOV-04", "VAL-TOOL-01"), V + "builtin_moves:f_wait_end_move"),
    ("queued_moves", ("VAL-MID-01", "VAL-MID-02", "VAL-MOV-07"), V + "builtin_moves:f_get_move_id"),
    ("circle_and_stop", ("VAL-MOV-06", "VAL-MOV-10"), V + "builtin_moves:f_movec"),
    ("circle_and_stop", ("VAL-MOV-11", "VAL-MOV-12"), V + "builtin_moves:mdesc_in"),
    ("sequences", ("VAL-DH-01",), V + "builtin_robot:f_get_dh"),
    ("events", ("VAL-EVT-01",), V + "builtin_robot:f_get_events"),
]


def test_every_vector_proves_something() -> None:
    assert {path.parent.name for path in VECTORS.glob("*/golden.toml")} == {name for name, _, _ in PROOFS}


@pytest.mark.parametrize(
    "name",
    [pytest.param(name, id=f"{name} {ids[0]}", marks=pytest.mark.requirement(*ids, by=by)) for name, ids, by in PROOFS],
)
def test_a_worked_example_of_the_manual(name: str) -> None:
    check_vector(name)
