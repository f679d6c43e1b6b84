"""What the INFO key shows: why a chosen function does not run.  Source: rho 3 Releases L2743-2941; rho3 7.3, AX-489.

Each condition has the text the manual prints; a mode shows those of its list that hold, in the printed order.
"""

from collections.abc import Callable, Collection, Sequence
from enum import Enum

from gateway.pure.controllers.rho3.pendant.modes import Mode
from gateway.pure.image.records.cell import Permit


class Condition(Enum):
    """A reason, with its text on the 20 columns of the panel."""

    MANUAL_DISABLED = "Manual disabled"
    MODES_DISABLED = "Dis.M4.1,9.1,11.4..6"
    BAPS_DISABLED = "Progr. BAPS disabled"
    PIC_DISABLED = "Progr. PIC disabled"
    FILES_DISABLED = "Device/file IO disab"
    START_DISABLED = "Progr.start disabled"
    RESTART_DISABLED = "Restart of RC disabl"
    KEYS_DISABLED = "PHG keys disabled"
    CHANGES_DISABLED = "Del/mod files disabl"
    DEFINE_DISABLED = "Def/teach in disable"
    REFERENCING_DISABLED = "Refence points disab"
    MESSAGES_DISABLED = "Disable system mess."
    ONLINE_DISABLED = "Disable online funct"
    COUPLING_DISABLED = "Disable coupling PG"
    PRINTER_DISABLED = "Disable printer"
    SER_1_DISABLED = "READ/WR. SER 1 disab"
    SER_2_DISABLED = "READ/WR. SER 2 disab"
    SER_3_DISABLED = "READ/WR. SER 3 disab"
    SER_4_DISABLED = "READ/WR. SER 4 disab"
    NOT_REFERENCED = "no reference points"
    NO_REFERENCING = "No referenc.(P402=0)"
    EMERGENCY_MODE = "emerg.op. without RC"
    NOT_IN_POSITION = "notINPOS of all axis"
    FEED_HOLD = "FEED HOLD"
    NO_FEED_ALLOW = "FEED ALLOW n.avail."
    NO_CONTROL_ALLOW = "CONTRL.ALLOW n.avail"
    NO_DRIVE_ON = "DRIVE ON not avail."
    NO_TRAVEL_ALLOW = "TRAVEL ALLOW n.avail"
    NO_COORDINATES = "Coord. not selected"
    PIC_STOPPED = "Stop of PIC250"
    PIC_CHECKSUM = "PIC checksum error"
    EEPROM_PROTECTED = "EEPROM write protect"
    NO_TEST_BIT = "TEST bit not select."
    PROCESS_ERROR = "error in USER-TASK"
    ERRORS_PENDING = "errors and warnings"
    NO_INTERFACE = "Interface: n.avail."
    DOUBLE_INTERFACE = "Interface: u.double"
    FACTORS_DISABLED = "V/A/D Factor disable"


C = Condition
GENERAL = tuple(C)[: tuple(C).index(C.NOT_REFERENCED)]  # manual and automatic
_MOTION = (
    C.EMERGENCY_MODE,
    C.NOT_IN_POSITION,
    C.FEED_HOLD,
    C.NO_FEED_ALLOW,
    C.NO_CONTROL_ALLOW,
    C.NO_DRIVE_ON,
    C.NO_TRAVEL_ALLOW,
)
_PIC = (C.PIC_STOPPED, C.PIC_CHECKSUM, C.EEPROM_PROTECTED)
LISTS: dict[Mode, tuple[Condition, ...]] = {
    (1,): (C.NOT_REFERENCED, C.NO_REFERENCING, *_MOTION),
    (2,): (C.NOT_REFERENCED, C.NO_COORDINATES, *_MOTION),
    (3,): (C.BAPS_DISABLED, C.PIC_DISABLED),
    (3, 1): (C.BAPS_DISABLED,),
    (3, 2): (C.PIC_DISABLED, *_PIC),
    (4,): (C.DEFINE_DISABLED,),
    (4, 1): (),
    (4, 2): (C.NO_REFERENCING, C.NO_COORDINATES, *_MOTION),
    (5,): (C.NO_TEST_BIT,),
    (6,): _PIC,
    (6, 1): (C.PIC_STOPPED,),
    (6, 4): (C.CHANGES_DISABLED,),
    (7,): (),
    (7, 1): (C.NOT_IN_POSITION,),
    (7, 3): (),
    (7, 3, 2): (C.PROCESS_ERROR, C.ERRORS_PENDING),
    (7, 8): (),
    (7, 8, 2): (C.CHANGES_DISABLED,),
    (9,): (),
    (9, 1): (C.NO_INTERFACE, C.DOUBLE_INTERFACE),
    (10,): (),
    (10, 1): (C.START_DISABLED,),
    (10, 2): (),
    (11,): (C.RESTART_DISABLED, C.FACTORS_DISABLED),
}
WITH_KINEMATICS = ((1,), (2,), (4, 2))  # these name the kinematics concerned
NOTHING = "No info available"
NOT_THIS_MODE = "no INFO messages"


def infos(mode: Mode, holding: Collection[Condition], kinematics: Sequence[int] = (), selected: str = "") -> list[str]:
    """Texts the INFO key shows in a mode, never empty.

    `kinematics`: numbers of those that a condition of motion concerns; `selected`: name of the kinematic chosen in mode 2.
    """
    if mode not in LISTS:
        return [NOT_THIS_MODE]
    own = [condition for condition in LISTS[mode] if condition in holding]
    general = [condition for condition in GENERAL if condition in holding and condition not in own]
    texts = [condition.value for condition in [*general, *own]]
    if mode == (2,) and selected:
        texts.insert(0, f"Kinem.: {selected:.<12}"[:20])
    if kinematics and mode in WITH_KINEMATICS and set(own) & {C.NOT_REFERENCED, *_MOTION}:
        texts += ["kinematics:", "".join(f"{number};" for number in kinematics)]
    return texts or [NOTHING]


SINGLE = ((C.FEED_HOLD, Permit.RUN), (C.NO_FEED_ALLOW, Permit.FEED))  # also of one kinematic (AX-1787)
# Signal of the interface (configs/signals/rho3.toml), and whether the condition holds while it is 0.
SIGNALS: tuple[tuple[Condition, str, bool], ...] = (
    (C.NO_CONTROL_ALLOW, "CTRL_ALLOW_RCI", True),
    (C.NO_FEED_ALLOW, "FEED_ALLOW_RCI", True),
    (C.FEED_HOLD, "FEED_HOLD_N_RCI", True),
    (C.NO_TRAVEL_ALLOW, "TRAVEL_ALLOW_RCI", True),
    (C.NO_DRIVE_ON, "DRIVE_ON_RCI", True),
    (C.EMERGENCY_MODE, "EMERGOP_RCI", False),
    (C.COUPLING_DISABLED, "DISCOUPL_RCI", False),
    (C.PRINTER_DISABLED, "DISPRINT_RCI", False),
    (C.SER_1_DISABLED, "DISSER_1_RCI", False),
    (C.SER_2_DISABLED, "DISSER_2_RCI", False),
    (C.SER_3_DISABLED, "DISSER_3_RCI", False),
    (C.SER_4_DISABLED, "DISSER_4_RCI", False),
    (C.MESSAGES_DISABLED, "DIS_PHGM_RCI", False),
)


def conditions_of(
    signal: Callable[[str], bool], *, referenced: bool, in_position: bool, test: bool = True, withheld: int = 0
) -> set[Condition]:
    """Conditions that follow from RC inputs (by symbol) and from the axes; withheld: bits of Permit that some kinematic lacks."""
    holding = {condition for condition, name, while_off in SIGNALS if signal(name) != while_off}
    holding |= {condition for condition, permit in SINGLE if withheld & permit}
    if not referenced:
        holding.add(C.NOT_REFERENCED)
    if not in_position:
        holding.add(C.NOT_IN_POSITION)
    if not test:
        holding.add(C.NO_TEST_BIT)
    return holding
