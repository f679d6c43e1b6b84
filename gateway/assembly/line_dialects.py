"""The RK512 dialect of a [[line]]: that of its layer, of its station, and the settings of the file."""

from dataclasses import replace

from gateway.pure.cell.cell import Line, Rk512
from gateway.registry import layer_spoken
from protocols.base.machine import ms
from protocols.rk512.dialects import Dialect, dialect_of


def rk512_dialect(line: Line) -> Dialect:
    """The station's own dialect; a setting in the file that differs from the general default overrides it (AX-227)."""
    spoken = layer_spoken(line)
    dialect = spoken.dialect(line) if spoken.dialect else dialect_of(line.profile)
    given, usual = line.rk512, Rk512()
    if given.db_address_unit != usual.db_address_unit:
        dialect = replace(dialect, db_address_unit=given.db_address_unit, most_word=min(dialect.most_word, 127))
    if given.reaction != usual.reaction:
        dialect = replace(dialect, reaction=given.reaction)
    if given.unknown_block != usual.unknown_block:
        dialect = replace(dialect, unknown_block=given.unknown_block)
    if line.times.reaction is not None:
        dialect = replace(dialect, reaction_wait=ms(line.times.reaction))
    flag = (
        "serve" if given.coordination_flag == "keep" else given.coordination_flag
    )  # who resets it is the command source's business (AX-251)
    return replace(dialect, coordination_flag=flag, nesting=dialect.nesting if line.choices.nesting is None else line.choices.nesting)
