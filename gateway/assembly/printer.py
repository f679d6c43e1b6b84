"""The printer of a rho 3: a file that grows, or a device such as /dev/usb/lp0 (AX-1755)."""

import os
import pathlib

LINE_END, PAGE_END = "\r\n", "\f"


def print_text(path: pathlib.Path, title: str, text: str) -> None:
    """Print a page in the code page of the old printers.  OSError, also if the printer accepts nothing more, so that no program waits."""
    page = LINE_END.join([title, "", *text.splitlines()]) + LINE_END + PAGE_END
    handle = os.open(path, os.O_WRONLY | os.O_APPEND | os.O_CREAT | os.O_NONBLOCK, 0o644)
    try:
        data = page.encode("cp437", "replace")
        while data:
            data = data[os.write(handle, data) :]
    finally:
        os.close(handle)
