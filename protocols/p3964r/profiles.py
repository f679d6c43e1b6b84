"""Times, counters and open choices of 3964R stations: one frozen table for each.

Sources: [rho3] rho 3 Releases part 1, section 7.1; [CP340] SIMATIC CP 340 manual 04/2011; [CP341] SIMATIC CP 341 manual 09/2008;
[CP440] SIMATIC CP 440 manual 09/2007 and 03/2022; [BUEP64] Bosch R500 interface manual 1070 072 131-102, chapter 9; [VIPA] System 200V
manual HB97E-CP; [VIPA21] CPU 21x manual HB103E; [WAGO] WagoAppSerial_3964R_RK512 1.6.1.0; [BECKHOFF] TF6340; [VCP] R911305038 chapter 6;
[EUCHNER] HBAS-094594; [AEG] FX22-Z manual; [SYS350] 3 608 878 300 chapter 6.3; [LINUX] behaviour of the Linux R3964 line discipline;
[M] measured on running stations; AX-nnn: a decision where the manuals are silent.
"""

from dataclasses import dataclass, replace
from enum import Enum, auto

from protocols.base.machine import Ns, ms
from protocols.p3964r.characters import Char


class Priority(Enum):
    """Which station continues when both send STX at once; the two ends must be set opposite."""

    HIGH = auto()
    LOW = auto()


class Stray(Enum):
    """Answer of a station in idle to a character that is neither STX nor NAK."""

    SILENT = auto()  # [LINUX], [WAGO], AX-005
    NAK_AFTER_QUIET = auto()  # once, after the line was quiet for one character delay [CP340]
    NAK_AT_ONCE = auto()  # [VIPA]


class ConnectCounter(Enum):
    """Scope of the counter of connection attempts."""

    PER_JOB = auto()  # block repeats do not start it again (AX-003)
    PER_BLOCK = auto()  # every block attempt has its own full set of connection attempts
    SHARED = auto()  # connection and block attempts use up one counter [LINUX]


class BrokenPair(Enum):
    """A DLE inside a block that is followed by neither DLE nor the end."""

    NAK_AT_END = auto()  # noted, received to the end, then NAK [CP340]
    NAK_AT_ONCE = auto()  # [M]; the remainder of the block is then received in idle and may look like a new one (AX-221)
    DROP_DLE = auto()  # the lone DLE is left out, the next character is data [M]


class TooLong(Enum):
    """A block longer than max_data; nothing of it is delivered."""

    NAK_AT_END = auto()  # AX-008
    NAK_AT_ONCE = auto()


class Interruption(Enum):
    """The sender's reaction to a character other than NAK during its block."""

    IGNORE = auto()  # no manual names a reaction
    BACK_OFF = auto()  # break off, wait one character delay, NAK, start again [LINUX]


@dataclass(frozen=True, slots=True)
class Settable:
    """Times that the station's own parameter mask allows, in ms."""

    least: int
    most: int
    step: int


@dataclass(frozen=True, slots=True)
class Profile:
    """One station.  Defaults are those of the rho 3; `open_fields`: no source names these values, they are the usual ones."""

    name: str
    source: str
    ack_delay: Ns = ms(550)  # QVZ (Siemens: ADT): longest wait for the answer to STX and to the block check [rho3]
    ack_delay_plain: Ns = ms(550)  # the same under procedure 3964, without block check [CP341]
    char_delay: Ns = ms(220)  # ZVZ (Siemens: CDT): longest gap between two characters of a block [rho3]
    block_wait: Ns = ms(4000)  # BWZ: how long a refused block is waited for again; only reported [CP341], AX-050
    reaction_wait: Ns | None = None  # BWZ as VIPA means it: from the acknowledged command to STX of the reaction; None: by baud rate
    connect_attempts: int = 6  # the first one counts [rho3]
    block_attempts: int = 6  # the first one counts [rho3]
    connect_counter: ConnectCounter = ConnectCounter.PER_JOB
    silence_ends: bool = False  # an STX without an answer is not repeated [WAGO]
    retry_pause: Ns = 0  # before a repeat; no manual has one
    max_data: int = 138  # characters of a block, a doubled DLE counted once [rho3]
    max_received: int | None = None  # the same of a block received; None: as many [LINUX]
    block_check: bool = True  # False: procedure 3964 without the check character
    end: Char = Char.ETX  # end of our blocks; ETX and ETB are both understood
    follow_on_end: Char = Char.ETX  # the same at follow-on telegrams of the layer above [BUEP64]
    priority: Priority = Priority.LOW  # the station's own default; axisgate's is low (users.md 3.3)
    stray: Stray = Stray.SILENT
    broken_pair: BrokenPair = BrokenPair.NAK_AT_END
    too_long: TooLong = TooLong.NAK_AT_END
    interruption: Interruption = Interruption.IGNORE
    yields_to_second_conflict: bool = False  # with priority, but a repeat, of STX or of the block, met the partner's STX: receive [LINUX]
    no_buffer_wait: Ns = ms(400)  # STX without a free buffer: silence for this time, then NAK; 0: NAK at once [VIPA] (AX-006)
    no_buffer_poll: Ns = 0  # a buffer that gets free is noticed at these steps only [CP340]; 0: at once
    nak_at_start: bool = False  # one NAK when the interface becomes ready [CP340] (AX-009)
    nak_when_giving_up: bool = True  # [CP341]
    early_answer: Ns = ms(5)  # largest delay of a port's `sent` after the line was free (AX-052)
    bauds: tuple[int, int] = (300, 19200)  # usual least and largest
    settable: Settable | None = None  # None: fixed
    open_fields: tuple[str, ...] = ()

    @property
    def most_received(self) -> int:
        """Characters of a block that the station accepts."""
        return self.max_data if self.max_received is None else self.max_received

    def plain(self) -> "Profile":
        """The same station under procedure 3964: no block check, its own acknowledgement delay."""
        return replace(self, name=f"{self.name}{PLAIN}", block_check=False, ack_delay=self.ack_delay_plain)

    def over_network(self, latency: Ns = ms(500)) -> "Profile":
        """The same station on a serial server: every wait for the partner is longer by the round-trip time (AX-224)."""
        return replace(
            self,
            name=f"{self.name}{NETWORK}",
            source=f"{self.source}; {latency // ms(1)} ms for the network (AX-224)",
            ack_delay=self.ack_delay + latency,
            ack_delay_plain=self.ack_delay_plain + latency,
            char_delay=self.char_delay + latency,
            early_answer=max(self.early_answer, latency),
            stray=Stray.SILENT if self.stray is Stray.NAK_AT_ONCE else self.stray,
        )


PLAIN, NETWORK = "-3964", "-tcp"
SIEMENS = Settable(20, 65530, 10)
RHO3 = Profile("rho3", "rho 3 Releases part 1, section 7.1; AX-003..009", priority=Priority.HIGH, bauds=(300, 19200))
SIEMENS_CP341 = Profile(
    "siemens-cp341",
    "SIMATIC CP 341 manual 09/2008; idle and start as CP 340 (AX-051)",
    ack_delay=ms(2000),
    connect_counter=ConnectCounter.PER_BLOCK,
    stray=Stray.NAK_AFTER_QUIET,
    no_buffer_poll=ms(50),
    nak_at_start=True,
    bauds=(300, 115200),
    settable=SIEMENS,
    open_fields=("connect_counter", "interruption", "too_long"),
)
SIEMENS_CP340 = replace(
    SIEMENS_CP341,
    name="siemens-cp340",
    source="SIMATIC CP 340 manual 04/2011; its table prints ZVZ 20 ms, its text 220 (AX-220)",
    max_data=1024,
    bauds=(2400, 19200),
    settable=Settable(10, 65530, 10),
)
SIEMENS_CP440 = replace(
    SIEMENS_CP341,
    name="siemens-cp440",
    source="SIMATIC CP 440 manual 09/2007; a figure of it has QVZ 500 ms for 3964, its table 550 (AX-220)",
    max_data=400,
)
SIEMENS_CP525 = Profile(
    "siemens-cp525",
    "inferred: no readable manual of CP 525; BUEP64 was written to match it, and WinCC OA (AX-051)",
    ack_delay=ms(2000),
    connect_counter=ConnectCounter.PER_BLOCK,
    stray=Stray.NAK_AFTER_QUIET,
    no_buffer_poll=ms(50),
    bauds=(300, 9600),
    open_fields=(
        "ack_delay",
        "ack_delay_plain",
        "char_delay",
        "block_wait",
        "block_attempts",
        "connect_counter",
        "stray",
        "no_buffer_wait",
    ),
)
SIEMENS_CP524 = replace(SIEMENS_CP525, name="siemens-cp524")
BOSCH_BUEP64 = Profile(
    "bosch-buep64",
    "Bosch R500 interface manual 1070 072 131-102, chapter 9 (R500, CL400/500, CL300, PC600)",
    ack_delay=ms(2000),
    bauds=(110, 19200),
    open_fields=("char_delay", "connect_attempts", "block_attempts", "connect_counter", "stray", "no_buffer_wait"),
)
VIPA_CP240 = Profile(
    "vipa-cp240",
    "VIPA System 200V manual HB97E-CP; one table has 3 connection attempts, the other 5 (AX-220)",
    ack_delay=ms(500),
    ack_delay_plain=ms(500),
    char_delay=ms(200),
    block_wait=ms(2000),
    reaction_wait=ms(2000),
    connect_attempts=3,
    stray=Stray.NAK_AT_ONCE,
    no_buffer_wait=0,
    settable=Settable(0, 5100, 20),
    open_fields=("connect_counter", "too_long", "interruption"),
)
VIPA_21X = replace(
    VIPA_CP240,
    name="vipa-21x",
    source="VIPA CPU 21x manual HB103E (SER-2)",
    ack_delay=ms(2000),
    block_wait=ms(10_000),
    reaction_wait=ms(5000),
    priority=Priority.HIGH,
)
WAGO = Profile(
    "wago",
    "WagoAppSerial_3964R_RK512 library documentation 1.6.1.0",
    ack_delay=ms(2000),
    ack_delay_plain=ms(2000),
    silence_ends=True,
    open_fields=("block_wait", "connect_attempts", "connect_counter", "no_buffer_wait"),
)
BECKHOFF = Profile(
    "beckhoff",
    "TF6340 serial communication documentation",
    ack_delay=ms(2000),
    ack_delay_plain=ms(2000),
    open_fields=("connect_attempts", "block_attempts", "connect_counter", "priority", "stray", "no_buffer_wait"),
)
REXROTH_VCP = Profile(
    "rexroth-vcp",
    "Rexroth VCP operating concept R911305038 chapter 6",
    connect_attempts=3,
    open_fields=("ack_delay", "ack_delay_plain", "char_delay", "block_wait", "connect_counter", "priority", "stray", "no_buffer_wait"),
)
EUCHNER_HBAS = Profile(
    "euchner-hbas",
    "Euchner HBAS-094594 manual",
    ack_delay=ms(500),
    ack_delay_plain=ms(500),
    char_delay=ms(128),
    connect_attempts=3,
    block_attempts=3,
    open_fields=("block_wait", "connect_counter", "priority", "stray", "no_buffer_wait"),
)
AEG_FX22Z = Profile(
    "aeg-fx22z",
    "AEG FX22-Z panel manual, sections 5 and 7: frame and selectable check only",
    open_fields=("ack_delay", "ack_delay_plain", "char_delay", "block_wait", "connect_attempts", "block_attempts", "priority", "stray"),
)
LINUX = Profile(
    "linux",
    "behaviour of the Linux R3964 line discipline (no longer in the kernel)",
    connect_counter=ConnectCounter.SHARED,
    max_data=256,
    max_received=4000,
    priority=Priority.HIGH,
    broken_pair=BrokenPair.DROP_DLE,
    interruption=Interruption.BACK_OFF,
    yields_to_second_conflict=True,
)
BOSCH_SYSTEM350 = Profile(
    "bosch-system350-rk512",
    "Rexroth Tightening System 350 3 608 878 300 chapter 6.3; times not named there: those of BUEP64 (AX-220)",
    ack_delay=ms(2000),
    open_fields=BOSCH_BUEP64.open_fields + ("ack_delay", "ack_delay_plain", "block_wait"),
)
BOSCH_SYSTEM350_RAW = replace(BOSCH_SYSTEM350, name="bosch-system350-3964r")
PROFILES = {
    profile.name: profile
    for profile in (
        *(RHO3, SIEMENS_CP340, SIEMENS_CP341, SIEMENS_CP440, SIEMENS_CP524, SIEMENS_CP525, BOSCH_BUEP64, BOSCH_SYSTEM350),
        *(BOSCH_SYSTEM350_RAW, VIPA_CP240, VIPA_21X, WAGO, BECKHOFF, REXROTH_VCP, EUCHNER_HBAS, AEG_FX22Z, LINUX),
    )
}


def profile_named(name: str, block_check: bool = True) -> Profile:
    """A profile by the name in a cell file, which may end in -tcp; KeyError names the unknown part.  block_check False: procedure 3964."""
    profile = PROFILES[name.removesuffix(NETWORK)]
    profile = profile.over_network() if name.endswith(NETWORK) else profile
    return profile if block_check else profile.plain()


def least_char_delay(baud: int) -> Ns:
    """Least settable time by speed [CP341]: 60, 40, 30 ms at 300, 600, 1200 Bd, 20 ms from 2400 Bd on."""
    for limit, time in ((300, 60), (600, 40), (1200, 30)):
        if baud <= limit:
            return ms(time)
    return ms(20)


def priority_from_output_timeout(value: int) -> Priority:
    """rho 3: the interface parameter "output timeout time" holds the priority; -1 is without, all else is with [rho3]."""
    return Priority.LOW if value == -1 else Priority.HIGH
