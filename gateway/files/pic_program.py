"""Check a PIC program of the disk without a cell: its symbols are next to it, the numbered signals at their default places."""

import pathlib

from gateway.files.program_memory import folder_memory
from gateway.files.signal_lists import signal_list
from gateway.pure.languages.base.faults import Faults
from gateway.pure.languages.pic.reader import read_program
from gateway.pure.languages.pic.symbols import named_in, symbols_of


def check_pic(path: pathlib.Path, text: str) -> Faults:
    """Faults of a QLS file and of the SYM file of its name.  OSError: its folder cannot be read."""
    named, faults = named_in(signal_list()), Faults()
    beside = f"{path.stem}.SYM"
    symbols = symbols_of(folder_memory(path.resolve().parent).text(beside) or "", str(path.with_name(beside)), named, faults)
    read_program(text, str(path), symbols, faults)
    return faults
