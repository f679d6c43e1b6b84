"""A PIC program of the disk judged without a cell: its symbols lie beside it, the numbered signals are where they are shipped."""

import pathlib

from gateway.files.find import read_signals
from gateway.files.program_memory import folder_memory
from gateway.pure.image.signals import from_tables
from gateway.pure.languages.base.faults import Faults
from gateway.pure.languages.pic.reader import read_program
from gateway.pure.languages.pic.symbols import named_in, symbols_of


def check_pic(path: pathlib.Path, text: str) -> Faults:
    """Faults of a QLS file and of the SYM file of its name.  OSError: its folder cannot be read."""
    named, faults = named_in(from_tables(read_signals())), Faults()
    beside = f"{path.stem}.SYM"
    symbols = symbols_of(folder_memory(path.resolve().parent).text(beside) or "", str(path.with_name(beside)), named, faults)
    read_program(text, str(path), symbols, faults)
    return faults
