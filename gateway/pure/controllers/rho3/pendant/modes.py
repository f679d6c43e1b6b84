"""Modes of the pendant and their direct selection.  Source: rho 3 Releases L3454-3560; mode tree rho3 7.1, AX-488."""

from collections.abc import Iterable

TREE = """
1 Reference points
2 Manual
3 Progr. BAPS/PIC
3.1 Programming BAPS
3.1.3 Teach in
3.2 Programming PIC
3.2.1 PIC editor
3.2.2 PIC functions
3.2.2.1 Timers and counters
3.2.5 SoftPIC run time
4 Define/Teach in
4.1 Define
4.2 Teach in
5 Test BAPS progr.
5.9 Single step
5.10 WITH/WITHOUT movem.
5.11 Write program line
5.14 Teach in
6 PIC monitor
6.1 PIC monitor on
6.4 Timer and counter
7 Diagnosis
7.1 Axis display
7.2 Errors, warnings
7.3 System conditions
7.3.2 Process conditions
7.3.3 Operating mode
7.8 Mach. parameter
7.8.2 Set parameters
7.8.3 Interfaces
7.9 Output test
7.12 Machine status
7.12.1 Machine status man.
7.12.2 Machine status auto
7.13 HS inputs
7.14 CAN inputs
7.15 CAN outputs
8 Deactivate PHG
9 Device/File I/O
9.1 Default
9.4 Print
9.4.1 Print QLL file
9.4.2 Print PKT file
9.4.3 Print file list
9.6 Memory -> EEPROM
9.7 EEPROM -> memory
9.8 Init SRAM card
10 Select program
10.1 Select processes
10.2 Stop processes
11 Help functions
11.1 Reset
11.4 VFACTOR
11.5 AFACTOR
11.6 DFACTOR
"""

Mode = tuple[int, ...]  # () is the basic level
BASIC: Mode = ()
RESET: Mode = (11, 1)


def parse_tree(text: str) -> dict[Mode, str]:
    """`7.3.2 Title` per line."""
    lines = (line.split(maxsplit=1) for line in text.strip().splitlines())
    return {tuple(map(int, number.split("."))): title for number, title in lines}


MODES = parse_tree(TREE)


def spoken(mode: Mode) -> str:
    """7.3.2, or 0 for the basic level."""
    return ".".join(map(str, mode)) or "0"


def select(level: Mode, entry: str, modes: Iterable[Mode] = MODES) -> Mode:
    """Level reached by `Mode=entry` from `level`.

    Numbers descend from the present level, a leading 0 begins at the basic level.  A sub-mode that does not exist ends the descent at the
    last valid level, without a message.  An entry with anything but digits and single points is refused: the level stays.
    """
    known = set(modes)
    steps = entry.split(".")
    if not all(step.isascii() and step.isdigit() for step in steps):
        return level
    numbers = [int(step) for step in steps]
    reached = BASIC if numbers[0] == 0 else level
    for number in numbers[1:] if numbers[0] == 0 else numbers:
        if (*reached, number) not in known:
            return reached
        reached = (*reached, number)
    return reached


def up(level: Mode) -> Mode:
    """CURSOR LEFT: one level back."""
    return level[:-1]
