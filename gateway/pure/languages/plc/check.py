"""Checks all programs of a folder, whether a start program reaches them or not."""

from collections.abc import Mapping

from gateway.pure.languages.base.faults import Faults
from gateway.pure.languages.base.source import Position
from gateway.pure.languages.plc.messages import TEXT_PROGRAM, read_texts
from gateway.pure.languages.plc.reader import lines_of
from gateway.pure.languages.plc.translation import Translation, key_of


def check_programs(sources: Mapping[str, str]) -> Faults:
    """Faults of the programs and of the texts of messages."""
    programs = {name: text for name, text in sources.items() if key_of(name).rpartition("/")[2] != TEXT_PROGRAM}
    translation = Translation(programs)
    translation.check_all()
    for name, text in sources.items():
        if name not in programs:
            read_texts(text, translation.faults, key_of(name))
    return _with_steps(sources, translation.faults)


def _with_steps(sources: Mapping[str, str], faults: Faults) -> Faults:
    """Return the faults with the step number before their texts, as the display counts it: the head is step 1."""
    steps = {key_of(name): {line.line: line.step for line in lines_of(text)} for name, text in sources.items()}
    found = Faults()
    for fault in faults:
        file, line = fault.position.file, fault.position.line
        found.error(fault.id, Position(file, line, fault.position.column), f"step {steps[file].get(line, 1)}: {fault.text}", fault.hint)
    return found
