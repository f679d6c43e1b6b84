"""Runtime errors of the CAN inputs and outputs, as the pendant shows them and in words.

Source: rho 3 Releases part 5, 6.14.2 (L7502-7527).  One number pair for three messages: "rho3 D-12", read as 380 for bus 1 and 381
for bus 2 (AX-262).
"""

from enum import Enum
from typing import NamedTuple

FIRST_NUMBER = 380


class Trouble(Enum):
    """Value: PHG text, then the sentence in German and English."""

    INADMISSIBLE = (
        "inadm. data CAN {bus} I{block}",
        "Eingangsblock {block} an CAN {bus} sendet zur falschen Zeit oder in falscher Laenge: Baugruppe passt nicht oder ist defekt",
        "input block {block} on CAN {bus} sends at a wrong time or in a wrong length: the module does not fit or is defective",
    )
    WRITE_DISABLED = (
        "imperm. data CAN{bus} O{block}",
        "Ausgangsblock {block} an CAN {bus} kann nicht gesendet werden: CAN-Anschluss gesperrt oder defekt",
        "output block {block} on CAN {bus} cannot be sent: CAN interface disabled or defective",
    )
    SILENT = (
        "no transm. CAN{bus} I{block}",
        "keine Daten von Eingangsblock {block} an CAN {bus}: Stecker, Kabel, Baugruppe oder Partnersteuerung pruefen",
        "no data from input block {block} on CAN {bus}: check plug, cable, module or the coupled control",
    )
    SAME_IDENTIFIER = (
        "same id CAN{bus} O{block}",
        "eine andere Steuerung sendet an CAN {bus} unter dem Identifier unseres Ausgangsblocks {block}",
        "another control on CAN {bus} sends under the identifier of our output block {block}",
    )

    def phg(self, bus: int, block: int) -> str:
        """As the pendant shows it; the last one is axisgate's, the manual has no text for it (L10998 only forbids it)."""
        return self.value[0].format(bus=bus, block=block)

    def words(self, bus: int, block: int, language: str = "en") -> str:
        """A sentence in `language` (de | en)."""
        return self.value[1 if language == "de" else 2].format(bus=bus, block=block)


class IoError(NamedTuple):
    """One error of one block: it came, or (`active` False) its cause is gone."""

    trouble: Trouble
    bus: int
    block: int  # 1.. in the order of P31 or P32
    active: bool = True

    @property
    def number(self) -> int:
        """380 or 381; 0 for the one without a number."""
        return 0 if self.trouble is Trouble.SAME_IDENTIFIER else FIRST_NUMBER + self.bus - 1

    @property
    def text(self) -> str:
        return self.trouble.phg(self.bus, self.block)

    def __str__(self) -> str:
        number = f"{self.number} " if self.number else ""
        return f"{number}{self.text}{'' if self.active else ': recovered'}"
