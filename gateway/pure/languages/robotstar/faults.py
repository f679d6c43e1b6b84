"""What stops a running program: text, number and class of the message.  Source: L209-211, L4152-4222, L4753-4770, L3814-3826."""

from gateway.pure.languages.base.requests import RuntimeFault
from gateway.pure.languages.robotstar.program import Program

NOT_FOUND = "Definition not found!"
IS_ARRAY = "Definition is an array!"
NO_ARRAY = "Definition is no array!"
INDEX_NOT_FOUND = "Index variable not found!"
INDEX_UNSET = "Index variable not initialized!"
INDEX_RANGE = "Index too big or too small!"
NO_VARIABLE = "The operand is no variable!"
WRONG_TYPES = "Wrong operand types!"
UNSET = "Variable not initialized!"
NO_READING = "Reading not allowed!"
NO_WRITING = "Writing not allowed!"
STEP_UNDEFINED = "Step not defined!"
IN_THE_STACK = "program in the stack"
INPUT_WRITTEN = "an input is not written"


class StepFault(RuntimeFault):
    """A step cannot be executed.  `code` 0: the manual prints no number.  `kind`: the class of the message."""

    def __init__(self, text: str, code: int = 0, kind: str = "programming") -> None:
        super().__init__(code, text)
        self.kind = kind
        self.display: tuple[Program | None, int] = (None, 0)  # program and step that the display goes to once it is acknowledged


def operating(code: int) -> StepFault:
    """An operating error by its number."""
    return StepFault(f"Operating error {code}", code, "operating")


def path_fault(code: int, text: str) -> StepFault:
    """A path error by its number (L4753-4770)."""
    return StepFault(f"path error {code}: {text}", code, "path")
