"""Faults reported by the cycle, as coded errors of the interface.  Group 3 is servo, INPOS, interpolator stop, drive-on; group 4 PIC, PLC
and other (rho3 L2945-3017).  The manual at hand prints no numbers of single servo errors: those below are AX-335, except 528.
"""

from dataclasses import dataclass, field

from gateway.pure.controllers.rho3.signals.errors import Faults
from gateway.pure.image.reasons import Reason
from gateway.pure.image.records.cell import AxisFlag, CellState
from gateway.pure.languages.baps2.errors import TEXTS as BAPS
from protocols.base.machine import Ns

DRIVE_FAULT, DRIVE_LOST, CODED = 768, 788, 20  # + axis - 1; axes after the 20th are listed by axisgate's own numbers only
CAUSES = {
    Reason.FOLLOWING_ERROR: 808,
    Reason.REFERENCE_FAILED: 809,
    Reason.OVERRUN: 810,  # interpolator stop
    Reason.SET_VALUE: 811,
    Reason.LINK_LOST: 1270,
    Reason.INPUT_LOST: 1271,
    Reason.SERVICES_LOST: 1272,
    Reason.PLANNER_LOST: 1273,
}
PLC_SILENT, PIC_TIMER, EMERGENCY_STOP = 1274, 1275, 528
_TEXTS = {
    808: ("following error", "Schleppfehler"),
    809: ("referencing failed", "Referenzieren fehlgeschlagen"),
    810: ("interpolator stop: the cycle was late", "Interpolator-Stop: Takt verspaetet"),
    811: ("set value out of range", "Sollwert ausserhalb"),
    1270: ("no telegrams from the active command source", "keine Telegramme von der aktiven Befehlsquelle"),
    1271: ("an enabling input is lost", "ein Freigabeeingang ist ausgefallen"),
    1272: ("services restarted under motion", "Dienste-Neustart in Bewegung"),
    1273: ("planner restarted under motion", "Planer-Neustart in Bewegung"),
    PLC_SILENT: ("the PLC does not answer", "die SPS antwortet nicht"),
    PIC_TIMER: ("PIC timer error: stopped until a restart", "PIC-Zeitfehler: steht bis zum Neustart"),
    EMERGENCY_STOP: ("EMERGENCY STOP - Input", "NOT-AUS-Eingang"),
    3622: ("Error SRAM - Card", "Fehler SRAM-Karte"),
    3883: ("CHECKSUM, SRAM card missing", "CHECKSUM, SRAM-Karte fehlt"),
    250: ("Inadmis. in manual op.", "Inadmis. in manual op."),
    251: ("AUTO/MANUAL switching", "AUTO/MANUAL switching"),
    252: ("kinematic is not in manual mode", "Kinematik nicht in Hand"),
    253: ("the move was refused or aborted", "Bewegung abgelehnt oder abgebrochen"),
    254: ("inadmissable input", "unzulaessiger Eingang"),
    1255: ("a process broke down inside", "ein Prozess ist innen zusammengebrochen"),
    1276: ("the interpreter ended, and its processes with it", "Interpreter beendet, seine Prozesse auch"),
    1278: ("Error in PHGCODE.DAT", "Fehler PHGKODE.DAT"),
}


def code_text(code: int, language: str = "en") -> str:
    """Subject of an error of axisgate or of this table; "" for others."""
    german = language == "de"
    if DRIVE_FAULT <= code < DRIVE_FAULT + CODED:
        return f"{'Antriebsfehler Achse' if german else 'drive fault, axis'} {code - DRIVE_FAULT + 1}"
    if DRIVE_LOST <= code < DRIVE_LOST + CODED:
        return f"{'Antrieb antwortet nicht, Achse' if german else 'drive does not answer, axis'} {code - DRIVE_LOST + 1}"
    if 1408 <= code <= 1427:
        return f"{'Achse gesperrt, Achse' if german else 'axis disabled, axis'} {code - 1407}"
    return _TEXTS.get(code, (BAPS.get(code, ""),) * 2)[german]


@dataclass(slots=True)
class CycleErrors:
    """Enters the cycle's reports into the list: each axis fault while present, each stop once."""

    faults: Faults
    names: tuple[str, ...]  # of the axes
    _active: set[tuple[int, str]] = field(default_factory=set)
    _cause: int = 0

    def look(self, state: CellState, now: Ns) -> None:
        """Once per cycle; a cycle that does not run reports nothing."""
        if not state.generation:
            return
        seen = {
            (code + number, name)
            for number, name in enumerate(self.names[:CODED])
            for flag, code in ((AxisFlag.FAULT, DRIVE_FAULT), (AxisFlag.LOST, DRIVE_LOST))
            if state.axes[number].flags & flag
        }
        for code, name in sorted(seen - self._active):
            self.faults.came(code, active=True, where=name, now=now)
        for code, name in self._active - seen:
            self.faults.gone(code, name)
        self._active = seen
        if state.stop_cause != self._cause:
            self._cause = state.stop_cause
            cause = CAUSES.get(Reason(state.stop_cause)) if state.stop_cause in Reason._value2member_map_ else None
            if cause is not None:
                self.faults.came(cause, now=now)
