"""Finds and reads configuration files; no other code opens one.

Search order: the path as given, $AXISGATE_CONFIGS (several folders separated by `:`), the packaged configs.
"""

import os
import pathlib
import tomllib
from collections.abc import Sequence

PACKAGED = pathlib.Path(__file__).resolve().parents[2] / "configs"
SUFFIX = {"cells": ".toml", "drives": "", "robots": ".toml", "signals": ".toml", "benches": ".toml", "programs": ".txt", "errors": ".toml"}


class ConfigNotFound(FileNotFoundError):
    """No such file; the message names every place searched and the files available."""


def find_config(name: str, kind: str, first: Sequence[pathlib.Path] = ()) -> pathlib.Path:
    """The file `name` of a kind (cells, drives, robots, signals, benches), `first` of these; a kind's own suffix may be left out."""
    wanted = pathlib.Path(name)
    for each in (*first, wanted):
        if each.is_file():
            return each
    if wanted.is_dir() and len(wanted.parts) != 1:
        raise ConfigNotFound(f"{name}: is a folder, not a file")
    searched = [str(each.absolute()) for each in (*first, wanted)]
    if not wanted.is_absolute():
        for folder in _folders():
            for candidate in _candidates(folder, kind, name):
                if candidate.is_file():
                    return candidate
                searched.append(str(candidate))
    raise ConfigNotFound(f"{name}: no such file; looked for {', '.join(dict.fromkeys(searched))}{_known(kind)}")


def beside(path: str, name: str, kind: str) -> pathlib.Path:
    """A file that another file names: search next to that file first, then like `find_config`."""
    folder, own = pathlib.Path(path).parent, SUFFIX[kind] != ".toml"  # cells are next to a cell, and may have the name of their robot
    return find_config(name, kind, first=[folder / each for each in (name, *(_names(name, kind) if own else ()))])


def read_text(path: pathlib.Path) -> str:
    """The text of a configuration file (UTF-8, with or without BOM); UnicodeDecodeError names the byte."""
    return path.read_text(encoding="utf-8-sig")


def read_octets(path: pathlib.Path, most: int) -> bytes:
    """Read a binary file completely; OSError if it has more than `most` bytes."""
    if path.stat().st_size > most:
        raise OSError(f"{path}: {path.stat().st_size} bytes, at most {most}")
    return path.read_bytes()


def read_signals(name: str = "rho3") -> list[dict[str, str | int]]:
    """The [[signal]] tables of a signal list."""
    tables: list[dict[str, str | int]] = tomllib.loads(read_text(find_config(name, "signals")))["signal"]
    return tables


def read_evidence() -> list[dict[str, object]]:
    """The [[function]] tables: how far each function was proved."""
    tables: list[dict[str, object]] = tomllib.loads(read_text(PACKAGED / "evidence.toml"))["function"]
    return tables


def _folders() -> list[pathlib.Path]:
    named = [pathlib.Path(part) for part in os.environ.get("AXISGATE_CONFIGS", "").split(":") if part]
    return [*named, PACKAGED]


def _candidates(folder: pathlib.Path, kind: str, name: str) -> list[pathlib.Path]:
    return [place / each for each in _names(name, kind) for place in (folder / kind, folder)]


def _names(name: str, kind: str) -> list[str]:
    return [name] if pathlib.Path(name).suffix else [name + SUFFIX.get(kind, "")]


def names_in(kind: str) -> list[str]:
    """Names that `find_config` finds without a path."""
    return sorted({path.stem for folder in _folders() for path in (folder / kind).glob("*" + (SUFFIX.get(kind) or ".*"))})


def _known(kind: str) -> str:
    found = names_in(kind)
    return f"; available: {', '.join(found)}" if found else ""
