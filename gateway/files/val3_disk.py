"""Reads the disk of a VAL 3 controller: a folder, into memory, so that a virtual run changes nothing on it."""

import pathlib

from gateway.pure.languages.val3.disk import Disk

KINDS = (".pjx", ".dtx", ".pgx", ".html", ".zip")
BINDINGS = ".bindings.json"  # next to a page
LARGEST = 64 << 20  # bytes of all files together


class DiskUnreadable(Exception):
    """One sentence: fault, place, remedy."""


def read_disk(folder: pathlib.Path) -> Disk:
    """All files of applications below a folder."""
    files: dict[str, bytes] = {}
    size = 0
    try:
        for path in sorted(folder.rglob("*")):
            if (path.suffix.lower() in KINDS or path.name.lower().endswith(BINDINGS)) and path.is_file():
                files[path.relative_to(folder).as_posix()] = data = path.read_bytes()
                size += len(data)
                if size > LARGEST:
                    raise DiskUnreadable(
                        f"{folder}: more than {LARGEST >> 20} MB of applications; give the folder that is Disk:// with --disk"
                    )
    except OSError as error:
        raise DiskUnreadable(f"{error.filename or folder}: {error.strerror}") from None
    return Disk(files)


def place_of(application: pathlib.Path, disk: pathlib.Path | None) -> tuple[pathlib.Path, str, str]:
    """Folder that is Disk://, folder of the application on it, its name.  `application`: its folder or its project file."""
    if not application.exists():
        raise DiskUnreadable(f"{application}: there is no such folder or file; name the folder of an application or its .pjx file")
    if application.is_dir():
        projects = sorted(each for each in application.iterdir() if each.suffix.lower() == ".pjx")
        own = [each for each in projects if each.stem.lower() == application.resolve().name.lower()]
        if len(own or projects) != 1:
            there = ", ".join(each.name for each in projects) or "none"
            raise DiskUnreadable(f"{application}: one project file expected, found {there}; name the .pjx file")
        application = (own or projects)[0]
    elif application.suffix.lower() != ".pjx":
        raise DiskUnreadable(f"{application}: a .pjx file or the folder of an application is expected")
    folder = application.resolve().parent
    root = disk.resolve() if disk is not None else folder.parent
    if not folder.is_relative_to(root):
        raise DiskUnreadable(f"{application} is not on the disk {root}; name a folder above the application with --disk")
    place = folder.relative_to(root).as_posix()
    return root, "" if place == "." else place, application.stem
