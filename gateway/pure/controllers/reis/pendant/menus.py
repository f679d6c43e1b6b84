"""The menus of the PHG: what each function key does here, or why it does nothing.  Source: robotstar 8.2 (L1019-1548); AX-1660."""

from dataclasses import dataclass

from gateway.pure.controllers.reis.access import Operation

FILES = "a new program is a file: put it into the folder of the cell"
MARKS = "no marks: delete, copy and rename take one program"
EDITOR = "blocks and positions are edited in the file of the program; it is read again at START"
SERVICE = "customer service only: not in this control"
NONE = "this key has no function in the ROBOTstar either"
NO_DISK = "this control has no disk drive: copy files into its folder"
CLOCK = "the clock is the computer's: set it there"
WINDOWS = "one window here: open the pendant a second time"
REFERENCE = "reference the axes by RC inputs, the page Axes or axisgate jog"


@dataclass(frozen=True, slots=True)
class Item:
    """A function key.  label: as printed, at most two words of six letters; act: what it does, with `value`; absent: why it does nothing;
    needs: what the access level must permit."""

    label: str
    act: str = ""
    value: str = ""
    absent: str = ""
    needs: Operation | None = None


def _none(label: str, why: str) -> Item:
    return Item(label, absent=why)


TEST = Operation.SELECT_PROGRAM
MOVE = Operation.REPROGRAM
FILE = Operation.EDIT
_SELECT = Item("Prog sel", "ask", "program")  # opening is looking; START selects
_FIND = Item("Find repl", "ask", "find")
MENUS: dict[str, tuple[tuple[Item, ...], ...]] = {
    "dir": (  # L1108-1183
        (_none("Prog open", FILES), _none("Prog mark", MARKS), Item("Prog del", "ask", "delete", needs=FILE),
         Item("Prog copy", "ask", "copy", needs=FILE), _SELECT, _none("Undo", NONE)),
        (_FIND, _none("Disk read", NO_DISK), _none("Disk frmt", NO_DISK), _none("Mem edit", SERVICE),
         Item("Prog ren", "ask", "rename", needs=FILE)),
        (_none("Flsh read", SERVICE), _none("Flsh frmt", SERVICE)),
    ),
    "edit": (  # L1496-1548
        (Item("Step edit", "ask", "edit", needs=FILE), _none("Step mark", EDITOR), Item("Step del", "change", "delete", needs=FILE),
         Item("Step v/i", "change", "invert", needs=FILE), _SELECT,
         _none("Pos edit", EDITOR)),
        (_none("Blck imp", EDITOR), _none("Blck exp", EDITOR), _none("Blck del", EDITOR), _none("Blck vali", EDITOR),
         _none("Blck inv", EDITOR), _none("Blck copy", EDITOR)),
        (_FIND, Item("Code word", "ask", "code"), _none("Edit mem", SERVICE), _none("Undo", NONE)),
    ),
    "run": (  # L1215-1300
        (*(Item(f"Test {number}", "test", str(number), needs=TEST) for number in range(1, 6)), Item("Auto", "auto")),
        (_none("Cal/ Sync", REFERENCE), Item("Start PLC", "plc", needs=TEST), _none("Ref Pos", REFERENCE),
         Item("Test 6", "test", "6", needs=TEST), _none("Test PLC", "the test display of the PLC is on the page PLC")),
    ),
    "coor": (  # L1306-1337
        (Item("AXIS 1-6", "coor", "0", needs=MOVE), Item("tXYZ rABC", "coor", "1", needs=MOVE), Item("tUVW", "coor", "2", needs=MOVE),
         Item("tXYZ mouse", "mouse", "t", needs=MOVE), Item("rABC mouse", "mouse", "r", needs=MOVE),
         Item("AXIS 7-12", "coor", "3", needs=MOVE)),
        (*(Item(f"ACTI {name}", "macro", f"AKTI_{long}", needs=Operation.RUN_MACRO)
           for name, long in (("CAL1", "KAL1"), ("CAL2", "KAL2"), ("KPHG", "KPHG"))),
         *(Item(f"RUN {name}", "macro", f"MOUSE_{long}", needs=Operation.RUN_MACRO)
           for name, long in (("CAL1", "KAL1"), ("CAL2", "KAL2"), ("KPHG", "PHG")))),
    ),
    "info": (  # L1350-1368
        (Item("Achs", "show", "axes"), Item("Kart Istw", "show", "pose"), Item("Inkr Istw", "show", "increments"),
         Item("Vari able", "ask", "variable"), Item("Err Enab", "suppress", needs=TEST), Item("Stat Ums", "status")),
        (Item("Eing dig", "show", "inputs"), Item("Ausg dig", "show", "outputs"), Item("SPS Merk", "show", "markers")),
    ),
    "fkt": (  # L1383-1428
        (_none("Dat/ time", CLOCK), _none("DNC rst", "this control has no DNC interface"),
         Item("Prog prot", "ask", "protect", needs=FILE), _none("Order rst", "this control has no archive")),
    ),
    "cwin": ((_none("Tlng Hztl", WINDOWS), _none("Tlng Vrtk", WINDOWS), _none("Tlng aufh", WINDOWS)),),  # L1437-1447
}  # fmt: skip
LEVELS = Item("Level 0", "level", "f1"), Item("Level 1", "level", "f2")  # while an input is simulated (L1219)
