"""Finds usr/configs and usr/usrapp on a copy of a flash card, and reads them."""

import pathlib
from dataclasses import dataclass

from gateway.files.val3_disk import DiskUnreadable, read_disk
from gateway.pure.languages.val3.disk import Disk

LARGEST = 64 << 20


@dataclass(frozen=True, slots=True)
class CardFiles:
    """configs: files of usr/configs by their path in it; usrapp: the folder that is Disk://."""

    configs: dict[str, bytes]
    usrapp: pathlib.Path
    disk: Disk


def read_card(card: pathlib.Path) -> CardFiles:
    """`card`: the folder with usr, or usr itself.  DiskUnreadable: one sentence."""
    if not card.is_dir():
        raise DiskUnreadable(f"{card}: there is no such folder; give the copy of a flash card, the folder with usr in it")
    usr = _inside(card, "usr") or card
    usrapp, configs = _inside(usr, "usrapp"), _inside(usr, "configs")
    if usrapp is None:
        raise DiskUnreadable(f"{usr}: there is no folder usrapp; give the copy of a flash card, the folder with usr in it")
    return CardFiles({} if configs is None else _files(configs), usrapp, read_disk(usrapp))


def _inside(folder: pathlib.Path, name: str) -> pathlib.Path | None:
    """In any case: cards come from file systems of both kinds."""
    return next((each for each in sorted(folder.iterdir()) if each.name.lower() == name and each.is_dir()), None)


def _files(configs: pathlib.Path) -> dict[str, bytes]:
    found: dict[str, bytes] = {}
    size = 0
    for path in sorted(configs.rglob("*")):
        if path.suffix.lower() in (".cfx", ".xml") and path.is_file():
            size += path.stat().st_size
            if size > LARGEST:
                raise DiskUnreadable(f"{configs}: more than {LARGEST >> 20} MB of configuration")
            found[path.relative_to(configs).as_posix()] = path.read_bytes()
    return found
