"""Gateway's side of the parameter download: one request at a time, repeated twice, read back; once per cycle `step`.

Source: rho 3 Releases part 5, 7.2 (L7539-7547): parameters are transmitted in the start-up phase.  The transport is AX-266.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum, IntEnum, auto

from protocols.servodyn.parameters import Answer, Request, Status, Value

WAIT_CYCLES = 25  # for an answer
ATTEMPTS = 3
NEAR = 1e-6  # a float read back may differ by its four bytes


class DownloadState(Enum):
    RUNNING = auto()
    DONE = auto()
    FAILED = auto()


class Cause(IntEnum):
    """Why a parameter was rejected; the first three are answers of the drive."""

    UNKNOWN = Status.UNKNOWN
    RANGE = Status.RANGE
    DRIVES_ON = Status.DRIVES_ON
    SILENT = 4
    OTHER_VALUE = 5


TEXTS = {  # number of the error list, German, English; 645 and 650: robotstar 8.1 (L4694, L4702)
    Cause.UNKNOWN: (0, "Parameter {0} kennt der Antrieb nicht", "the drive does not have parameter {0}"),
    Cause.RANGE: (650, "Parameter {0} ausserhalb des Wertebereichs", "parameter {0} exceeds its value range"),
    Cause.DRIVES_ON: (
        645,
        "Parameter {0}: Aenderung bei eingeschalteten Antrieben nicht zulaessig",
        "parameter {0}: data change not admitted with drives active",
    ),
    Cause.SILENT: (0, "Antrieb antwortet nicht auf Parameter {0}", "no answer to parameter {0}"),
    Cause.OTHER_VALUE: (0, "Parameter {0}: anderer Wert gelesen als gesendet", "parameter {0}: another value read back than sent"),
}


@dataclass(frozen=True, slots=True)
class DownloadError:
    """Why it ended; `number` 0: no manual has one."""

    number: int
    parameter: int
    german: str
    english: str
    cause: Cause


def download_error(cause: Cause, parameter: int) -> DownloadError:
    """With its number and sentences."""
    number, german, english = TEXTS[cause]
    return DownloadError(number, parameter, german.format(parameter), english.format(parameter), cause)


class Download:
    """All parameters of one drive, in the given order."""

    def __init__(self, parameters: Sequence[tuple[int, Value]]) -> None:
        self._left = list(parameters)
        self._sequence = 0
        self._waited = self._attempts = 0
        self.error: DownloadError | None = None
        self.taken: dict[int, Value] = {}  # as read back

    @property
    def state(self) -> DownloadState:
        """DONE only when every parameter was accepted and read back."""
        if self.error is not None:
            return DownloadState.FAILED
        return DownloadState.RUNNING if self._left else DownloadState.DONE

    def step(self, answer: Answer | None) -> Request | None:
        """`answer`: what the drive sent since the last step.  Return the request to send now, or None."""
        if answer is not None:
            self._judge(answer)
        if self.state is not DownloadState.RUNNING:
            return None
        number, value = self._left[0]
        if self._attempts and self._waited < WAIT_CYCLES:
            self._waited += 1
            return None
        if self._attempts == ATTEMPTS:
            self.error = download_error(Cause.SILENT, number)
            return None
        self._attempts, self._waited = self._attempts + 1, 0
        return Request(number, value, self._sequence)

    def _judge(self, answer: Answer) -> None:
        if not self._left or self._attempts == 0 or answer.sequence != self._sequence or answer.number != self._left[0][0]:
            return  # of an earlier attempt, or unknown
        number, value = self._left[0]
        if answer.status is not Status.TAKEN:
            self.error = download_error(Cause(answer.status), number)
        elif abs(float(answer.value) - float(value)) > NEAR * max(1.0, abs(float(value))):
            said = f"parameter {number}: {value} sent, {answer.value} read back"
            german = f"Parameter {number}: {value} gesendet, {answer.value} gelesen"
            self.error = DownloadError(0, number, german, said, Cause.OTHER_VALUE)
        else:
            self.taken[number] = answer.value
            self._left.pop(0)
            self._sequence = self._sequence + 1 & 0xFF
            self._attempts = self._waited = 0
