"""Memory of a process in pages of 2 MB where its kernel has them: fewer of its accesses wait for the page tables (AX-1791).

Source: madvise(2), MADV_COLLAPSE (Linux 6.1); Documentation/admin-guide/mm/transhuge.rst.
"""

import contextlib
import ctypes
from collections.abc import Iterator

PAGE = 1 << 21
MADV_HUGEPAGE, MADV_COLLAPSE = 14, 25
HEAP = "[heap]"

_libc = ctypes.CDLL(None, use_errno=True)


def use_huge_pages() -> int:
    """Collect the memory of this process in huge pages; return how many bytes are in them.

    Call it when everything is built, before a loop that must not wait: it takes 2 to 4 ms per page.  A kernel without huge pages, or
    without memory for them, changes nothing.
    """
    collected = 0
    with contextlib.suppress(OSError, ValueError, AttributeError):
        advise = _libc.madvise
        advise.argtypes = (ctypes.c_void_p, ctypes.c_size_t, ctypes.c_int)
        for start, size in _ranges():
            if advise(start, size, MADV_HUGEPAGE) == 0 and advise(start, size, MADV_COLLAPSE) == 0:
                collected += size
    return collected


def _ranges() -> Iterator[tuple[int, int]]:
    """(address, size) of complete huge pages within private memory of this process without a file.  Source: proc(5), maps."""
    with open("/proc/self/maps", encoding="utf-8", errors="replace") as file:
        lines = file.readlines()
    for line in lines:
        place, rights, _, _, inode, *name = line.split(maxsplit=5)
        if rights != "rw-p" or inode != "0" or (name and name[0].strip() != HEAP):
            continue
        low, high = (int(end, 16) for end in place.split("-"))
        start, end = -(-low // PAGE) * PAGE, high // PAGE * PAGE
        if start < end:
            yield start, end - start
