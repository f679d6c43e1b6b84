"""The disk of a controller: files by path, paths as VAL 3 writes them.  Source: VAL 3 reference 6.6, L3949-3968, codes L3974-4006."""

from dataclasses import dataclass, field

ROOTS = ("disk",)  # existing roots; Floppy, USB0 and FTP are known to the language, but do not exist here
ABSENT_ROOTS = ("floppy", "usb0")


class PathFault(Exception):
    """`code`: what the instructions on libraries return."""

    def __init__(self, code: int, text: str) -> None:
        super().__init__(text)
        self.code = code


@dataclass(slots=True)
class Disk:
    """Files in memory, by their path from the root of the disk with `/`.  Names are compared without case, as on the controller."""

    files: dict[str, bytes] = field(default_factory=dict)
    _names: dict[str, str] = field(init=False, default_factory=dict)  # in small letters -> as written
    _sealed: dict[str, bytes] = field(init=False, default_factory=dict)  # of encrypted libraries, in small letters; never written

    def __post_init__(self) -> None:
        self._names = {path.lower(): path for path in self.files}

    def read(self, path: str) -> bytes | None:
        """The content; None: no such file."""
        name = self._names.get(path.lower())
        return self._sealed.get(path.lower()) if name is None else self.files[name]

    def unseal(self, folder: str, files: dict[str, bytes]) -> None:
        """The content of an encrypted library, as if it lay in a folder of that name."""
        self._sealed.update({f"{folder}/{name}".lower(): data for name, data in files.items()})

    def secret(self, folder: str) -> bool:
        """Whether it is an encrypted library that was opened."""
        return any(path.startswith(folder.lower() + "/") for path in self._sealed)

    def write(self, path: str, data: bytes) -> None:
        """Creates or replaces a file."""
        name = self._names.setdefault(path.lower(), path)
        self.files[name] = data

    def delete(self, folder: str) -> bool:
        """All files of a folder, or an encrypted library; whether there was one."""
        name = folder.lower()
        found = [path for path in self.files if path.lower().startswith(name + "/") or (name.endswith(".zip") and path.lower() == name)]
        for path in found:
            del self.files[path]
            del self._names[path.lower()]
        return bool(found)

    def entries(self, folder: str) -> list[str]:
        """Names directly inside a folder, sorted."""
        start = f"{folder}/" if folder else ""
        inside = [path[len(start) :] for path in self.files if path.lower().startswith(start.lower())]
        return sorted({path.split("/")[0] for path in inside if path})


def resolve(path: str, current: str) -> str:
    """A VAL 3 path as a path from the root of the disk, without the project file.  `current`: folder of the calling application."""
    root, separator, rest = path.strip().replace("\\", "/").partition("://")
    if not separator:
        root, rest = "Disk", path.strip().replace("\\", "/")
    if root.lower() in ABSENT_ROOTS:
        raise PathFault(32, f"{path}: there is no device {root}")
    if root.lower() not in ROOTS:
        raise PathFault(20, f"{path}: the root {root} is unknown; known are Disk, Floppy and USB0")
    parts = current.split("/") if rest.startswith("./") and current else []
    for part in rest.split("/"):
        if part in ("", "."):
            continue
        if part == "..":
            if not parts:
                raise PathFault(21, f"{path} leads out of the disk")
            parts.pop()
        elif any(ord(letter) < 32 or letter in ':*?"<>|' for letter in part):
            raise PathFault(22, f"{path}: {part!r} is not a name of a file")
        else:
            parts.append(part)
    if not parts:
        raise PathFault(22, f"{path!r} names nothing")
    return "/".join(parts)


def application_of(path: str, current: str) -> tuple[str, str]:
    """Folder and name of the application a path points to: `Disk://A/A.pjx`, `./A.pjx`, `A`."""
    found = resolve(path, current)
    folder, _, last = found.rpartition("/")
    if last.lower().endswith(".pjx"):
        return folder, last[:-4]
    return found, last
