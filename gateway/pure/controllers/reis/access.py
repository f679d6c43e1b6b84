"""Access levels of the ROBOTstar V pendant.  Source: ROBOTstar V operating manual L1544-1558; robotstar 1.6, AX-491."""

from dataclasses import dataclass
from enum import Enum, IntEnum


class Level(IntEnum):
    """Who operates; the manual's table has four, its text speaks of five (doubt D46)."""

    OPERATOR = 1
    SETTER = 2
    PROGRAMMER = 3
    MANUFACTURER = 4


class Operation(Enum):
    """An operation and the access level it requires."""

    START = 1, "start"
    STOP = 1, "stop"
    HOME = 1, "home position with or without robot"
    RUN_MACRO = 2, "run macros"
    REPROGRAM = 2, "reprogram"
    EDIT = 2, "edit"
    ARCHIVE = 2, "archive"
    SELECT_PROGRAM = 2, "select program and step"
    PROGRAM_SYSTEM_INSTRUCTION = 3, "program user-specific system instructions"
    PROGRAM_MACRO = 3, "program macros"
    EVERY_SYSTEM_INSTRUCTION = 4, "all system instructions"

    @property
    def level(self) -> Level:
        """Lowest level that may."""
        return Level(self.value[0])


class Menus(Enum):
    """What a level is offered."""

    NONE = "none"
    MACROS = "application-specific operator macros"
    APPLICATION = "application-specific system instructions and macros"
    ALL = "all system instructions"


MENUS = {Level.OPERATOR: Menus.NONE, Level.SETTER: Menus.MACROS, Level.PROGRAMMER: Menus.APPLICATION, Level.MANUFACTURER: Menus.ALL}


@dataclass(frozen=True, slots=True)
class Codes:
    """The three secrets as entered on the pendant; an empty one opens nothing."""

    code_word_1: str = ""
    code_word_2: str = ""
    pin: str = ""


class Pendant:
    """One pendant: begins at level 1, a code word raises or lowers it to its own level, an unknown one changes nothing."""

    def __init__(self, codes: Codes) -> None:
        self._levels = {
            word: level
            for word, level in (
                (codes.code_word_1, Level.SETTER),
                (codes.code_word_2, Level.PROGRAMMER),
                (codes.pin, Level.MANUFACTURER),
            )
            if word
        }
        self.level = Level.OPERATOR

    def enter(self, code: str) -> bool:
        """EDIT mode, third menu, `Code word`; whether it was known.  An empty entry goes back to level 1."""
        if code and code not in self._levels:
            return False
        self.level = self._levels[code] if code else Level.OPERATOR
        return True

    def may(self, operation: Operation) -> bool:
        """Whether the present level is enough."""
        return self.level >= operation.level

    @property
    def menus(self) -> Menus:
        """What is offered at the present level."""
        return MENUS[self.level]
