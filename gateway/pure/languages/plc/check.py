"""Checks all programs of a folder, whether a start program reaches them or not."""

from collections.abc import Mapping

from gateway.pure.languages.base.faults import Faults
from gateway.pure.languages.plc.messages import TEXT_PROGRAM, read_texts
from gateway.pure.languages.plc.translation import Translation, key_of


def check_programs(sources: Mapping[str, str]) -> Faults:
    """Faults of the programs and of the texts of messages."""
    programs = {name: text for name, text in sources.items() if key_of(name).rpartition("/")[2] != TEXT_PROGRAM}
    translation = Translation(programs)
    translation.check_all()
    for name, text in sources.items():
        if name not in programs:
            read_texts(text, translation.faults, key_of(name))
    return translation.faults
