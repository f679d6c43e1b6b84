"""The file that is the EEPROM of a rho 3: a zip archive of its user memory (AX-1041)."""

import io
import pathlib
import zipfile
import zlib
from collections.abc import Mapping

from gateway.files.safe_file import write_whole

LARGEST = 1 << 20
WRITABLE = 0o222


def is_protected(path: pathlib.Path) -> bool:
    """It exists and is read-only."""
    return path.exists() and not path.stat().st_mode & WRITABLE


def save_eeprom(path: pathlib.Path, files: Mapping[str, bytes], memory: int) -> None:
    """Save all files, or keep the former ones.  OSError."""
    data = io.BytesIO()
    with zipfile.ZipFile(data, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.comment = str(memory).encode()
        for name in sorted(files):
            archive.writestr(zipfile.ZipInfo(name), files[name])
    write_whole(path, data.getvalue())


def load_eeprom(path: pathlib.Path) -> tuple[int, dict[str, bytes]] | None:
    """Size of the user memory that was saved, and its files; None: there is nothing valid."""
    try:
        with zipfile.ZipFile(path) as archive:
            if sum(each.file_size for each in archive.infolist()) > LARGEST:
                return None
            return int(archive.comment), {each.filename: archive.read(each) for each in archive.infolist() if "/" not in each.filename}
    except (OSError, ValueError, zipfile.BadZipFile, zipfile.LargeZipFile, NotImplementedError, RuntimeError, EOFError, zlib.error):
        return None
