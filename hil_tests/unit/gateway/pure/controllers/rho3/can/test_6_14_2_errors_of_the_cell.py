"""rho 3 Releases part 5, 6.14.2 (L7502-7527): what the cycle's I/O complains about, carried to the services (AX-431)."""

from drivers.drives.servodyn_download import Cause, download_error
from gateway.pure.controllers.rho3.can.ledger import LEDGER_BYTES, MOST, Complaint, Ledger, unpack_ledger
from gateway.pure.controllers.rho3.can.messages import IoError, Trouble


def told(ledger: Ledger) -> list[Complaint]:
    payload = ledger.pack()
    assert len(payload) == LEDGER_BYTES
    return unpack_ledger(payload)


def test_an_error_carries_number_pendant_text_and_sentence_and_stays_with_its_count() -> None:
    ledger = Ledger()
    ledger.note([IoError(Trouble.SILENT, 2, 1), IoError(Trouble.INADMISSIBLE, 1, 3)])
    ledger.note([IoError(Trouble.SILENT, 2, 1, active=False)])
    ledger.note([IoError(Trouble.SILENT, 2, 1)])
    silent, wrong = told(ledger)
    assert (silent.number, silent.where, silent.active, silent.count) == (381, "no transm. CAN2 I1", True, 2)
    assert silent.words("en").startswith("no transm. CAN2 I1: no data from input block 1 on CAN 2")
    assert silent.words("de").startswith("no transm. CAN2 I1: keine Daten von Eingangsblock 1")
    assert (wrong.number, wrong.where, wrong.active, wrong.count) == (380, "inadm. data CAN 1 I3", True, 1)


def test_an_error_of_one_cycle_is_seen_by_its_count_when_it_is_gone_again() -> None:
    ledger = Ledger()
    ledger.note([IoError(Trouble.INADMISSIBLE, 1, 1), IoError(Trouble.INADMISSIBLE, 1, 1, active=False)])
    (gone,) = told(ledger)
    assert (gone.number, gone.active, gone.count) == (380, False, 1)
    assert not ledger.changed
    ledger.note([])
    assert not ledger.changed


def test_every_trouble_of_every_block_and_module_finds_room() -> None:
    ledger = Ledger()
    for bus in (1, 2):
        ledger.note(IoError(trouble, bus, block) for trouble in Trouble for block in range(1, 11))
        for module in range(1, 7):
            ledger.refused(bus, module, download_error(Cause.DRIVES_ON, 7))
    assert len(told(ledger)) == MOST
    assert told(ledger)[-1] == Complaint(
        645,
        "CAN2 module 6",
        "parameter 7: data change not admitted with drives active",
        "Parameter 7: Aenderung bei eingeschalteten Antrieben nicht zulaessig",
        active=True,
        count=1,
    )


def test_our_identifier_from_somebody_else_has_the_number_of_its_bus_and_a_silent_drive_has_none() -> None:
    ledger = Ledger()
    ledger.note([IoError(Trouble.SAME_IDENTIFIER, 2, 4)])
    ledger.refused(1, 2, download_error(Cause.SILENT, 9))
    same, silent = told(ledger)
    assert (same.number, same.where) == (381, "same id CAN2 O4")
    assert (silent.number, silent.en) == (0, "no answer to parameter 9")
