"""Differences between RK512 stations: one frozen table for each, under the name of its link profile.

Sources: [CP341] SIMATIC CP 341 manual 09/2008; [CP441] Siemens text on RK 512 with CP 441; [VIPA] System 200V manual HB97E-CP; [VIPA21]
CPU 21x manual HB103E; [WAGO] WagoAppSerial_3964R_RK512 1.6.1.0; [SYS350] Rexroth 3 608 878 300 chapter 6.3.
"""

from dataclasses import dataclass

from protocols.base.machine import Ns, ms
from protocols.rk512.header import MOST_BYTES, ErrorNumber

BY_SPEED = ((300, 10_000), (600, 7_000), (19_200, 5_000), (1 << 30, 3_000))  # up to this baud rate: ms [CP341]


@dataclass(frozen=True, slots=True)
class Dialect:
    """One station.  Defaults are those of Siemens."""

    name: str = "rk512"
    source: str = "SIMATIC CP 341 manual 09/2008; total of CP 441"
    db_address_unit: str = "word"  # unit of byte 6 of the header: word | byte [SYS350]
    reaction: bool = True  # False: no reaction telegrams, no follow-on telegrams
    unknown_block: int = ErrorNumber.BLOCK  # error number for this partner when the store answers BLOCK
    coordination_flag: str = "refuse"  # a job that names one: refuse (32h, there are none) | ignore | serve
    follow_on_reaction: bool = True  # reactions to follow-ons begin with FF [CP341] [VIPA]; False: 00 [SYS350]; both are understood
    send_kinds: bytes = b"DX"  # types a SEND may go to
    extended_send: bytes = b"OX"  # bytes 3 and 4 of a SEND to DX; OD and OX are both understood (AX-223)
    most_bytes: int = 4096  # of one job; above 128 with follow-on telegrams [CP441]
    served_bytes: int = 4096  # the same of a job we serve
    most_word: int = 255  # byte 6 at most, in words
    nesting: bool = True  # a command that comes while we wait for a reaction is served; False: it ends our job
    reaction_wait: Ns | None = None  # None: by_speed
    by_speed: tuple[tuple[int, int], ...] = BY_SPEED

    def waits(self, baud: int) -> Ns:
        """Longest wait for a reaction, from when the command was acknowledged."""
        if self.reaction_wait is not None:
            return self.reaction_wait
        return ms(next(time for limit, time in self.by_speed if baud <= limit))


STANDARD = Dialect()
DIALECTS = {
    dialect.name: dialect
    for dialect in (
        Dialect("siemens-cp341", "SIMATIC CP 341 manual 09/2008: SEND to D only", send_kinds=b"D"),
        Dialect("vipa-cp240", "VIPA System 200V manual HB97E-CP: block wait time 2 s up to STX of the reaction", reaction_wait=ms(2000)),
        Dialect("vipa-21x", "VIPA CPU 21x manual HB103E: reaction wait 5 s", reaction_wait=ms(5000)),
        Dialect("wago", "WagoAppSerial_3964R_RK512 1.6.1.0: no follow-on, 62 words", most_bytes=MOST_BYTES, served_bytes=124),
        Dialect(
            "bosch-system350-rk512",
            "Rexroth Tightening System 350, 3 608 878 300 chapter 6.3: byte 6 counts bytes, DW 64 is sent as 80h",
            db_address_unit="byte",
            follow_on_reaction=False,
            unknown_block=ErrorNumber.NOT_ALLOWED,
            most_word=127,
        ),
        Dialect(
            "bosch-system350-3964r",
            "Rexroth Tightening System 350, 3 608 878 300 chapter 6.3: header of 10 bytes, no reaction, no follow-on",
            db_address_unit="byte",
            reaction=False,
            most_bytes=MOST_BYTES,
            served_bytes=MOST_BYTES,
            most_word=127,
        ),
    )
}


def dialect_of(profile: str) -> Dialect:
    """The RK512 side of a station known by its link profile; STANDARD where its source names nothing else."""
    return DIALECTS.get(profile.removesuffix("-tcp"), STANDARD)
