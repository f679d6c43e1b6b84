"""Context of the parts below the command sources: the run, the shared image, the values, the dispatcher."""

from dataclasses import dataclass

from gateway.pure.arbitration.dispatcher import CommandDispatcher
from gateway.services.context import RunContext
from gateway.services.shared_image import SharedImage
from gateway.services.value_directory import ValueDirectory


@dataclass(frozen=True, slots=True)
class PartContext:
    """The four things most parts share; each exists once in a process."""

    run: RunContext
    image: SharedImage
    values: ValueDirectory
    dispatcher: CommandDispatcher
