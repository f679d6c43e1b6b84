"""Times, counters and open choices of the stations that speak 3964R: one frozen table for each.

Sources: [rho3] rho 3 Releases part 1, section 7.1; [CP340] SIMATIC CP 340 manual 04/2011; [CP341] SIMATIC CP 341 manual 09/2008;
[CP440] SIMATIC CP 440 manual 09/2007; [VIPA] System 200V manual HB97E-CP; [LINUX] behaviour of the Linux R3964 line discipline;
AX-nnn: a decision of ours where the manual is silent.
"""

from dataclasses import dataclass
from enum import Enum, auto

from protocols.base.machine import Ns, ms
from protocols.p3964r.characters import Char


class Priority(Enum):
    """Who goes on when both stations send STX at once; the two ends must be set opposite."""

    HIGH = auto()
    LOW = auto()


class Stray(Enum):
    """What a station in idle answers to a character that is neither STX nor NAK."""

    SILENT = auto()  # [LINUX], AX-005
    NAK_AFTER_QUIET = auto()  # once, after the line was quiet for one character delay [CP340]
    NAK_AT_ONCE = auto()  # [VIPA]


class ConnectCounter(Enum):
    """What the counter of connection attempts belongs to."""

    PER_JOB = auto()  # block repeats do not start it again (AX-003)
    PER_BLOCK = auto()  # every block attempt has its own full set of connection attempts
    SHARED = auto()  # connection and block attempts use up one counter [LINUX]


@dataclass(frozen=True, slots=True)
class Profile:
    """One station.  Defaults are those of the rho 3."""

    name: str
    source: str
    ack_delay: Ns = ms(550)  # QVZ: longest wait for the answer to STX and to the block check [rho3]
    char_delay: Ns = ms(220)  # ZVZ: longest gap between two characters of a block [rho3]
    block_wait: Ns = ms(4000)  # BWZ: how long a refused block is waited for again; only reported [CP341], AX-050
    connect_attempts: int = 6  # the first one counts [rho3]
    block_attempts: int = 6  # the first one counts [rho3]
    connect_counter: ConnectCounter = ConnectCounter.PER_JOB
    retry_pause: Ns = 0  # before a repeat; no manual has one
    max_data: int = 138  # characters of a block, a doubled DLE counted once [rho3]
    block_check: bool = True  # False: procedure 3964 without the check character
    end: Char = Char.ETX  # what we send; ETX and ETB are both understood
    stray: Stray = Stray.SILENT
    no_buffer_wait: Ns = ms(400)  # STX while no buffer is free: silence so long, then NAK; 0: NAK at once [VIPA] (AX-006)
    nak_at_start: bool = False  # one NAK when the interface becomes ready [CP340] (AX-009)
    nak_when_giving_up: bool = True  # [CP341]
    early_answer: Ns = ms(5)  # a port may report `sent` so much later than the line was free (AX-052)


RHO3 = Profile("rho3", "rho 3 Releases part 1, section 7.1; AX-003..009")
SIEMENS_CP525 = Profile(
    "siemens-cp525",
    "inferred: no readable manual of CP 525; BUEP64 was written to match it (AX-051)",
    ack_delay=ms(2000),
    connect_counter=ConnectCounter.PER_BLOCK,
    stray=Stray.NAK_AFTER_QUIET,
)
SIEMENS_CP341 = Profile(
    "siemens-cp341",
    "SIMATIC CP 341 manual 09/2008; idle and start as CP 340 (AX-051)",
    ack_delay=ms(2000),
    connect_counter=ConnectCounter.PER_BLOCK,
    stray=Stray.NAK_AFTER_QUIET,
    nak_at_start=True,
)
PROFILES = {profile.name: profile for profile in (RHO3, SIEMENS_CP525, SIEMENS_CP341)}


def priority_from_output_timeout(value: int) -> Priority:
    """rho 3: the interface parameter "output timeout time" holds the priority; -1 is without, all else is with [rho3]."""
    return Priority.LOW if value == -1 else Priority.HIGH
