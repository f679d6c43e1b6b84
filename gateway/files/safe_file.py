"""Files that must survive a power failure: written completely next to their place, flushed to the disk, then put in place."""

import contextlib
import errno
import os
import pathlib


def write_whole(path: pathlib.Path, octets: bytes, mode: int = 0o644) -> None:
    """The old file or the new one, never a part of either.  OSError, which names the file: the old one."""
    path.parent.mkdir(mode=0o755, parents=True, exist_ok=True)
    partial = path.with_name(f".{path.name}.part")
    fd = os.open(partial, os.O_WRONLY | os.O_CREAT | os.O_TRUNC | os.O_CLOEXEC, mode)
    try:
        with os.fdopen(fd, "wb") as file:
            file.write(octets)
            file.flush()
            os.fsync(file.fileno())
        put_in_place(partial, path)
    except OSError as error:
        with contextlib.suppress(OSError):
            partial.unlink()
        raise OSError(error.errno, error.strerror, str(path)) from error


def append_line(path: pathlib.Path, line: str, mode: int = 0o644) -> None:
    """Append a line to a history; an earlier line that was cut stays separate.  On return it has reached the disk."""
    path.parent.mkdir(mode=0o755, parents=True, exist_ok=True)
    fd = os.open(path, os.O_RDWR | os.O_APPEND | os.O_CREAT | os.O_CLOEXEC, mode)
    with os.fdopen(fd, "r+b", buffering=0) as file:
        size = os.fstat(fd).st_size
        torn = size > 0 and os.pread(fd, 1, size - 1) != b"\n"
        octets = (b"\n" if torn else b"") + line.encode() + b"\n"
        if file.write(octets) != len(octets):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(path))
        os.fsync(fd)
    flush_folder(path.parent)


def put_in_place(written: pathlib.Path, path: pathlib.Path) -> None:
    """A file written before becomes `path`; both its content and its name have reached the disk on return."""
    flush(written)
    os.replace(written, path)
    flush_folder(path.parent)


def flush(path: pathlib.Path) -> None:
    """On return the written data are on the disk."""
    fd = os.open(path, os.O_RDONLY | os.O_CLOEXEC)
    try:
        os.fsync(fd)
    finally:
        os.close(fd)


def flush_folder(folder: pathlib.Path) -> None:
    """Names in it are on the disk; file systems that cannot do that (some of the network) keep them as they do."""
    with contextlib.suppress(OSError):
        flush(folder)
