"""Finds usr/configs and usr/usrapp on a copy of a flash card, in a folder or a ZIP file, and reads them."""

import pathlib
import shutil
import stat
import zipfile
import zlib
from collections.abc import Iterator
from dataclasses import dataclass

from gateway.files.val3_disk import DiskUnreadable, read_disk
from gateway.pure.languages.val3.disk import Disk

LARGEST = 64 << 20
LARGEST_CARD = 256 << 20  # unpacked
DEEPEST = 4  # folders above usrapp
ENCRYPTED = 0x1


@dataclass(frozen=True, slots=True)
class CardFiles:
    """configs: files of usr/configs by their path in it; usrapp: the folder that is Disk://."""

    configs: dict[str, bytes]
    usrapp: pathlib.Path
    disk: Disk


def read_card(card: pathlib.Path) -> CardFiles:
    """`card`: the folder with usr, however deep, or one with applications alone.  DiskUnreadable: one sentence."""
    if not card.is_dir():
        raise DiskUnreadable(f"{card}: there is no such folder; name the copy of a flash card, the folder with usr in it, or its .zip")
    usrapp = next(_named(card, "usrapp", DEEPEST), None)
    if usrapp is None:
        usrapp = _of_applications(card)
        return CardFiles({}, usrapp, read_disk(usrapp))
    configs = next(_named(usrapp.parent, "configs", 1), None)
    return CardFiles({} if configs is None else _files(configs), usrapp, read_disk(usrapp))


def _named(folder: pathlib.Path, name: str, depth: int) -> Iterator[pathlib.Path]:
    """Folders of that name in any case (cards come from file systems of both kinds), the nearest ones first."""
    inside = sorted(each for each in folder.iterdir() if each.is_dir() and not each.is_symlink())
    yield from (each for each in inside if each.name.lower() == name)
    if depth > 1:
        for each in inside:
            yield from _named(each, name, depth - 1)


def _of_applications(card: pathlib.Path) -> pathlib.Path:
    """Without usrapp: the folder that holds the folders of applications."""
    projects = sorted(path for path in card.rglob("*") if path.suffix.lower() == ".pjx" and path.is_file())
    if not projects:
        raise DiskUnreadable(
            f"{card}: there is no folder usrapp and no .pjx file; name the copy of a flash card, the folder with usr in it"
        )
    own = [path.parent for path in projects if path.stem.lower() == path.parent.resolve().name.lower()] or [projects[0].parent]
    return min((folder.resolve().parent for folder in own), key=lambda folder: len(folder.parts))


def unpack_card(archive: pathlib.Path, folder: pathlib.Path) -> None:
    """Unpack the ZIP of a card into a new folder; DiskUnreadable, and nothing is left, if a part of it is not acceptable."""
    if folder.exists():
        raise DiskUnreadable(f"{folder} exists already and is not changed; name another cell file with --out, its folder receives the card")
    try:
        with zipfile.ZipFile(archive) as opened:
            files = {name: each for each in opened.infolist() if (name := _safe(archive, each))}
            if sum(each.file_size for each in files.values()) > LARGEST_CARD:
                raise DiskUnreadable(f"{archive}: more than {LARGEST_CARD >> 20} MB; unpack only usr/usrapp and usr/configs")
            contents = {name: opened.read(each) for name, each in files.items()}
    except (zipfile.BadZipFile, zlib.error, EOFError, NotImplementedError, RuntimeError, ValueError) as error:
        raise DiskUnreadable(f"{archive}: the ZIP file is damaged or of a kind that is not read ({error})") from None
    for name, data in contents.items():
        path = folder / name
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(data)
        except OSError as error:
            shutil.rmtree(folder, ignore_errors=True)
            raise DiskUnreadable(f"{archive}: {name} cannot be written: {error.strerror}") from None


def _safe(archive: pathlib.Path, each: zipfile.ZipInfo) -> str:
    """Its path below the folder; "" for a folder."""
    name = each.filename.replace("\\", "/")
    if each.is_dir() or name.endswith("/"):
        return ""
    if each.flag_bits & ENCRYPTED:
        raise DiskUnreadable(f"{archive}: {name} is encrypted; unpack the file with its password first")
    parts = name.split("/")
    if name.startswith("/") or ":" in name or ".." in parts or stat.S_ISLNK(each.external_attr >> 16):
        raise DiskUnreadable(f"{archive}: {name} leads out of the folder; the file is not unpacked")
    return name


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
