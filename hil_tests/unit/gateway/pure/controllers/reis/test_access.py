"""Access levels of the ROBOTstar V.  Source: ROBOTstar V operating manual L1544-1558."""

import pytest

from gateway.pure.controllers.reis.access import Codes, Level, Menus, Operation, Pendant

CODES = Codes("1111", "2222", "9999")


def offered(code: str) -> tuple[set[Operation], Menus] | str:
    pendant = Pendant(CODES)
    pendant.enter(code)
    return {operation for operation in Operation if pendant.may(operation)}, pendant.menus


@pytest.mark.requirement(
    "RSV-UI-01", by=("gateway.pure.controllers.reis.access:Pendant.may", "gateway.pure.controllers.reis.access:Pendant.enter")
)
def test_each_code_opens_its_level() -> None:
    operator = {Operation.START, Operation.STOP, Operation.HOME}
    setter = operator | {Operation.RUN_MACRO, Operation.REPROGRAM, Operation.EDIT, Operation.ARCHIVE, Operation.SELECT_PROGRAM}
    programmer = setter | {Operation.PROGRAM_SYSTEM_INSTRUCTION, Operation.PROGRAM_MACRO}
    assert offered("") == (operator, Menus.NONE)
    assert offered("1111") == (setter, Menus.MACROS)
    assert offered("2222") == (programmer, Menus.APPLICATION)
    assert offered("9999") == (set(Operation), Menus.ALL)
    assert offered("0000") == (operator, Menus.NONE), "an unknown code opens nothing"


def test_a_wrong_code_changes_nothing_and_no_code_goes_back() -> None:
    pendant = Pendant(CODES)
    assert pendant.enter("2222") and not pendant.enter("3333")
    levels = [pendant.level]
    for code in ("1111", ""):
        assert pendant.enter(code)
        levels.append(pendant.level)
    assert levels == [Level.PROGRAMMER, Level.SETTER, Level.OPERATOR]


def test_an_unset_code_opens_nothing() -> None:
    pendant = Pendant(Codes())
    assert pendant.enter("") and pendant.level is Level.OPERATOR
