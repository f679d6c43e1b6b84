"""Reads a DBC file into plain layouts; the text is judged by protocols.base.dbc."""

import pathlib

from protocols.base.dbc import DbcError, compile_dbc
from protocols.base.errors import EncodeError
from protocols.base.layout import Layout
from protocols.servodyn.codec import Codec


def load_layouts(path: pathlib.Path) -> dict[str, Layout]:
    """Layouts by message name.  Raises DbcError naming file, line, message, signal; OSError when the file cannot be read."""
    try:
        text = path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError:
        text = path.read_text(encoding="cp1252")  # encoding of most DBC editors
    return compile_dbc(text, str(path))


def load_servodyn(path: pathlib.Path) -> Codec:
    """The codec a SERVODYN bus runs on.  Raises DbcError also when the layout misses messages or signals."""
    try:
        return Codec(load_layouts(path))
    except EncodeError as error:
        raise DbcError([f"{path}: {error}"]) from error
