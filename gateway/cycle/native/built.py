"""Names, libraries and loading of the parts in C.

A library's name contains a hash of its sources and of its interpreter: a library of another state of the tree is not found, and the Python
twin runs.
"""

import hashlib
import importlib.machinery
import importlib.util
import os
import pathlib
import sysconfig
from types import ModuleType

FOLDER = pathlib.Path(__file__).parent
PARTS = ("axes", "telegrams", "memory", "alarm", "foresight", "servo")
HEADER = "slots.h"
PYTHON_ONLY = "AXISGATE_PYTHON_CYCLE"  # any value but 0: the twins run, built or not


def library(part: str) -> pathlib.Path:
    """Path of the library of a part once built."""
    suffix = str(sysconfig.get_config_var("EXT_SUFFIX"))
    text = b"".join((FOLDER / name).read_bytes() for name in (f"{part}.c", HEADER)) + suffix.encode()
    return FOLDER / f"{part}-{hashlib.blake2b(text, digest_size=6).hexdigest()}{suffix}"


def wanted() -> bool:
    """The twins were not requested."""
    return os.environ.get(PYTHON_ONLY, "0") in ("", "0")


def load(part: str) -> ModuleType:
    """ImportError: it was not built from these sources, or cannot be loaded here."""
    try:
        path = library(part)
    except OSError as error:
        raise ImportError(f"{part}: its sources are not there ({error})") from error
    loader = importlib.machinery.ExtensionFileLoader(part, str(path))
    spec = importlib.util.spec_from_loader(part, loader)
    if not path.is_file() or spec is None:
        raise ImportError(f"{part}: {path.name} is not there; python -m gateway.cycle.native.build makes it")
    module = importlib.util.module_from_spec(spec)
    loader.exec_module(module)
    return module
