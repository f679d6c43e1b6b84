"""Saving the user memory in the EEPROM and loading it from there: conditions and messages.  Source: rho 3 Releases L4846-4911; AX-1041."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from gateway.pure.image.records.interpreter import Fact

EEPROM = {96 * 1024: 128 * 1024, 128 * 1024: 256 * 1024}  # user memory -> EEPROM (L4854-4856)
KEPT_FREE = 512
NO_OPTION, NO_STOP, OPEN, ACTIVE = "Option not found", "no EMERGENCY STOP", "File(s) not closed", "Prog. is active"
TOO_SMALL, TOO_FULL, PROTECTED = "EEPROM not enough", "Memory too full", "EEPROM write protect."
NO_INTERFACE = "Interface: n.avail."
OTHER_SIZE, NOT_VALID = "Memory <> EEPROM", "EEPROM data n. valid"
SAVE, LOAD, PRINT, INIT, BACKUP = "save", "load", "print", "init", "backup"
NO_CARD_OPTION, NO_STOP_INPUT = "Option not active", "EMERGENCY STOP input"


@dataclass(frozen=True, slots=True)
class Wanted:
    """An order of the pendant.  stop: EMERGENCY STOP is pending; active: processes of the control run; file: to be printed."""

    ticket: int
    what: str
    stop: bool
    active: bool
    file: str = ""


@dataclass(slots=True)
class EepromOrders:
    """Orders that wait for the one who has the files."""

    waiting: list[Wanted] = field(default_factory=list)

    def hear(self, order: Mapping[str, Fact]) -> bool:
        """Whether it is one."""
        if order["do"] not in (SAVE, LOAD, PRINT, INIT, BACKUP):
            return False
        wanted = Wanted(int(order["ticket"]), str(order["do"]), bool(order["stop"]), bool(order["active"]), str(order.get("file", "")))
        self.waiting.append(wanted)
        return True

    def take(self) -> list[Wanted]:
        """What waits."""
        found, self.waiting = self.waiting, []
        return found


def refused(wanted: Wanted, *, option: bool, open_files: bool, running: bool) -> str:
    """Why neither is done now; empty: it may be."""
    found = (
        (not option, NO_OPTION),
        (not wanted.stop, NO_STOP),
        (open_files, OPEN),
        (running or wanted.active, ACTIVE),
    )
    return next((words for applies, words in found if applies), "")


def card_not_now(wanted: Wanted, *, option: bool, running: bool) -> str:
    """Why no SRAM card is initialised now (L11474-11526); empty: it may be."""
    found = ((not option, NO_CARD_OPTION), (not wanted.stop, NO_STOP_INPUT), (running or wanted.active, ACTIVE))
    return next((words for applies, words in found if applies), "")


def backup_refused(wanted: Wanted, *, error: bool, running: bool) -> str:
    """Why the user memory is not deleted now (AX-1732); empty: it is.  error: a system error of its memory is pending."""
    found = ((not error and not wanted.stop, NO_STOP), (running or wanted.active, ACTIVE))
    return next((words for applies, words in found if applies), "")


def save_refused(files: Mapping[str, bytes], memory: int, *, protected: bool) -> str:
    """Why the memory does not go into the EEPROM."""
    used = sum(len(data) for data in files.values())
    if used > EEPROM[memory]:
        return TOO_SMALL
    if memory - used < KEPT_FREE:
        return TOO_FULL
    return PROTECTED if protected else ""
