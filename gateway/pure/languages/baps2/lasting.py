"""What stays when its program ends: teach points, and PUBLIC variables.  Pure."""

from gateway.pure.languages.baps2.errors import fault
from gateway.pure.languages.baps2.feed import Feed
from gateway.pure.languages.baps2.handle import Handle
from gateway.pure.languages.baps2.library import Library
from gateway.pure.languages.baps2.machine import Machine
from gateway.pure.languages.baps2.memory import Memory
from gateway.pure.languages.baps2.teach_points import TeachPoints
from gateway.pure.languages.baps2.values import Shared


class LastingValues:
    """Of all programs of a memory."""

    def __init__(self, library: Library, memory: Memory, feed: Feed) -> None:
        self.points = TeachPoints(memory, feed, library.file_of)
        self._public: dict[str, Shared] = {}

    def public(self, program: str, machine: Machine) -> Shared:
        """The PUBLIC variables of a program, made when first asked for."""
        if program not in self._public:
            space = self._public[program] = Shared()
            unit, _ = machine.library.unit(program)
            if unit is None or unit.share is None:
                raise fault(1092, program)
            unit.share(Handle(machine, None), space)
        return self._public[program]

    def file_changed(self, name: str, library: Library) -> None:
        """A file of the memory was replaced or deleted: it is read again at the next start of a program."""
        program, _, kind = name.rpartition(".")
        if kind == "PKT":
            self.points.forget(program)
        else:
            library.forget(program)
            self.points.forget_sources()
