"""Start-up of a CiA 402 node: order, read-back, what is refused and which object is named; the node is the emulated drive."""

from dataclasses import replace

import pytest

from drivers.drives import cia402_boot as plans
from drivers.drives.canopen_plan import collisions, gateway_identifiers, node_identifiers
from drivers.drives.canopen_steps import Read, Write
from drivers.drives.cia402_boot import (
    CONTROLWORD,
    BootRefused,
    Identity,
    Loss,
    NodePlan,
    Parameter,
    Pdo,
    boot,
    default_pdos,
    map_faults,
    runs_on,
)
from drivers.drives.cia402_words import GERMAN, sentence
from drivers.emulator.cia402.errors import Error
from hil_tests.lab.virtual.cell_402_bench import Dialogue
from hil_tests.lab.virtual.one_node import NODE, OneNode, one_plan
from protocols.canopen import cob_id as cobid
from protocols.canopen import sdo


def refused(dialogue: Dialogue, plan: NodePlan) -> BootRefused:
    with pytest.raises(BootRefused) as caught:
        dialogue.carry(boot(plan))
    return caught.value


def test_the_node_ends_operational_in_csp_with_its_options_known() -> None:
    rig = OneNode()
    dialogue = rig.dialogue()
    booted = dialogue.carry(boot(one_plan()))
    assert (booted.node, booted.mode) == (NODE, 8)
    assert booted.options["abort connection"] == 3 and booted.options["quick stop"] == 2
    assert booted.identity.product == 0x402
    assert rig.slave.seat(NODE).node.state.name == "OPERATIONAL"


def test_every_map_is_written_in_the_order_all_devices_take_and_read_back() -> None:
    dialogue = OneNode().dialogue()
    dialogue.carry(boot(one_plan()))
    own = [step for step in dialogue.steps if isinstance(step, Read | Write) and step.index in (0x1400, 0x1600)]
    pairs = [(step.index, step.sub) for step in own if isinstance(step, Write)]
    assert pairs == [(0x1400, 1), (0x1600, 0), (0x1600, 1), (0x1600, 2), (0x1600, 0), (0x1400, 2), (0x1400, 1)]
    writes = [step for step in own if isinstance(step, Write)]
    assert int.from_bytes(writes[0].data, "little") & cobid.INVALID and writes[1].data == b"\0"
    assert not int.from_bytes(writes[-1].data, "little") & cobid.INVALID
    for at, step in enumerate(own):
        if isinstance(step, Write):
            assert own[at + 1] == Read(step.index, step.sub)


def test_no_foreign_pdo_is_left_valid() -> None:
    rig = OneNode()
    rig.dialogue().carry(boot(one_plan()))
    objects = rig.slave.seat(NODE).node.objects
    valid = [index for index in (*range(0x1400, 0x1404), *range(0x1800, 0x1804)) if not objects.whole((index, 1)) & cobid.INVALID]
    assert valid == [0x1400, 0x1401, 0x1800, 0x1801, 0x1802]


@pytest.mark.parametrize(
    ("key", "words"),
    [((0x1600, 1), "1600h:01 map of RPDO1"), ((0x1A00, 2), "1A00h:02 map of TPDO1"), ((0x1016, 1), "1016h:01 heartbeat consumer")],
)
def test_what_the_node_refuses_is_named(key: tuple[int, int], words: str) -> None:
    dialogue = OneNode().dialogue()
    dialogue.refuse[key] = sdo.Abort.NOT_MAPPABLE
    assert words in str(refused(dialogue, one_plan())) and "06040041h" in str(refused(dialogue, one_plan()))


@pytest.mark.parametrize("key", [(0x1600, 2), (0x1400, 1), (0x1017, 0), (0x6061, 0)])
def test_what_reads_back_otherwise_is_named(key: tuple[int, int]) -> None:
    dialogue = OneNode().dialogue()
    dialogue.lies[key] = b"\x55\0\0\0"
    why = refused(dialogue, one_plan())
    assert why.key == key and f"{key[0]:04X}h:{key[1]:02X}" in str(why) and "55" in str(why)
    assert not why.dead


def test_another_drive_than_the_pinned_one_is_refused() -> None:
    plan = NodePlan(NODE, default_pdos(NODE, torque=True), Identity(product=0x402, serial=4711))
    why = refused(OneNode().dialogue(), plan)
    assert why.key == (0x1018, 4) and "serial number" in str(why)


def test_a_node_that_is_not_there_is_reported_as_dead() -> None:
    rig = OneNode()
    dialogue = rig.dialogue()
    dialogue.node = NODE + 1
    why = refused(dialogue, NodePlan(NODE + 1, default_pdos(NODE + 1, torque=True)))
    assert why.dead


def test_a_node_that_falls_silent_while_it_is_looked_at_is_no_other_drive() -> None:
    dialogue = OneNode().dialogue()
    dialogue.silent.add((0x1018, 2))
    why = refused(dialogue, NodePlan(NODE, default_pdos(NODE, torque=True), Identity(product=0x402)))
    assert why.dead and why.key == (0x1018, 2) and "no answer" in str(why)


def test_a_needed_parameter_that_is_refused_stops_the_start_up_another_is_noted() -> None:
    there_not = Parameter(0x2999, 0, b"\0", "DCF")
    why = refused(OneNode().dialogue(), one_plan(there_not))
    assert why.key == (0x2999, 0) and "06020000h" in str(why)
    noted = Parameter(0x2999, 0, b"\0", "DCF", needed=False)
    booted = OneNode().dialogue().carry(boot(one_plan(noted)))
    assert any("2999h" in note for note in booted.notes)


# ---- what the drive would do when we are gone ------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("abort", "reaction", "quick", "loss", "words"),
    [
        (None, None, 2, Loss.QUICK_STOP, "does not report"),
        (0, 2, 2, Loss.QUICK_STOP, "runs on"),
        (0, 2, 2, Loss.COAST, "runs on"),
        (1, 2, 2, Loss.QUICK_STOP, ""),
        (1, 0, 2, Loss.QUICK_STOP, "coasts"),
        (1, None, 2, Loss.QUICK_STOP, "does not report"),
        (2, 2, 2, Loss.QUICK_STOP, "coasts"),
        (2, 2, 2, Loss.COAST, ""),
        (3, 2, 2, Loss.QUICK_STOP, ""),
        (3, 2, 0, Loss.QUICK_STOP, "coasts"),
        (3, 2, 6, Loss.QUICK_STOP, ""),
        (-1, 2, 2, Loss.QUICK_STOP, "runs on"),
    ],
)
def test_ready_is_refused_for_a_drive_that_would_not_stop(
    abort: int | None, reaction: int | None, quick: int, loss: Loss, words: str
) -> None:
    options = {"abort connection": abort, "fault reaction": reaction, "quick stop": quick}
    why = runs_on({name: value for name, value in options.items() if value is not None}, loss)
    assert (words in why) if words else why == ""


def test_a_drive_that_keeps_running_on_whatever_is_written_is_not_started() -> None:
    rig = OneNode()
    dialogue = rig.dialogue()
    dialogue.refuse[0x6007, 0] = sdo.Abort.READ_ONLY
    dialogue.lies[0x6007, 0] = b"\0\0"
    why = refused(dialogue, one_plan())
    assert "not ready" in str(why) and "runs on" in str(why) and "6007h" in str(why)
    assert rig.slave.seat(NODE).node.state.name != "OPERATIONAL"


def test_a_drive_without_6007h_is_refused_with_what_to_do_unless_its_stop_was_measured() -> None:
    rig = OneNode()
    dialogue = rig.dialogue()
    dialogue.refuse[0x6007, 0] = sdo.Abort.NO_OBJECT
    dialogue.absent.add((0x6007, 0))
    why = refused(dialogue, one_plan())
    assert "does not report" in str(why) and "stop_evidence" in str(why) and "loss-test" in str(why)
    assert rig.slave.seat(NODE).node.state.name != "OPERATIONAL"
    booted = dialogue.carry(boot(replace(one_plan(), stop_evidence="loss-test-x.json")))
    assert any("loss-test-x.json" in note for note in booted.notes) and "abort connection" not in booted.options


def test_measured_or_not_a_drive_that_shows_that_it_runs_on_or_that_does_not_watch_the_gateway_is_refused() -> None:
    plan = replace(one_plan(), stop_evidence="loss-test-x.json")
    for key, refusal, lies in (((0x6007, 0), sdo.Abort.READ_ONLY, b"\0\0"), ((0x1016, 1), sdo.Abort.NO_OBJECT, b"")):
        dialogue = OneNode().dialogue()
        dialogue.refuse[key] = refusal
        if lies:
            dialogue.lies[key] = lies
        assert refused(dialogue, plan).key == key
    dialogue = OneNode().dialogue()
    dialogue.silent.add((0x6007, 0))
    assert "does not report" in str(refused(dialogue, plan)), "no answer is not an object that is not there"


# ---- plans that cannot be ------------------------------------------------------------------------------------------------


def test_a_controlword_in_two_rpdos_is_refused_with_both_places() -> None:
    pdos = (*default_pdos(NODE, torque=False), Pdo(True, 3, cobid.rpdo(3, NODE), 255, (CONTROLWORD,)))
    assert map_faults(pdos) and "RPDO1 and RPDO3" in map_faults(pdos)[0]
    assert map_faults(default_pdos(NODE, torque=True)) == []
    why = refused(OneNode().dialogue(), NodePlan(NODE, pdos))
    assert "6040h is mapped in RPDO1 and RPDO3" in str(why)


def test_two_nodes_of_one_number_collide_in_everything_they_say() -> None:
    used = gateway_identifiers(127)
    for who in ("axis A1", "axis A2"):
        used += node_identifiers(5, who, default_pdos(5, torque=True))
    found = collisions(used)
    assert len(found) == 4 + 5 and "517 (205h) is RPDO1 of axis A1 and RPDO1 of axis A2" in found
    apart = node_identifiers(5, "axis A1", default_pdos(5, torque=True)) + node_identifiers(6, "axis A2", default_pdos(6, torque=True))
    assert collisions(apart) == []


def test_everything_the_emulated_drive_can_say_has_words_in_both_languages() -> None:
    for error in Error:
        for language in ("en", "de"):
            told = sentence(error, language)
            assert f"{error.value:04X}h" in told and "unknown" not in told and "unbekannt" not in told
        assert any(error.value & mask in GERMAN for mask in (0xFFFF, 0xFFF0, 0xFF00))
    assert sentence(0x8611, "de").startswith("Schleppfehler (8611h)")
    assert "0FFFh" not in sentence(0, "de") and "unknown" in sentence(0x0FFF)


def test_taking_over_only_reads() -> None:
    rig = OneNode().start()
    dialogue = rig.dialogue()
    booted = dialogue.carry(plans.adopt(one_plan()))
    assert booted.mode == 8 and all(isinstance(step, Read) for step in dialogue.steps)
