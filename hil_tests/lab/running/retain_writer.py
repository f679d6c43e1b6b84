"""Writes retained data as fast as it can until it is killed: every write is the same number in all of its values.

python -m hil_tests.lab.running.retain_writer FILE FIRST: prints the number of each write that has reached the disk.
"""

import os
import pathlib
import sys

from gateway.runtime.retained.store import open_file

NAMES = tuple(f"flags.M{n}" for n in range(40)) + ("counter.1", "order.number")


def main() -> None:
    file, number = open_file(pathlib.Path(sys.argv[1])).file, int(sys.argv[2])
    while True:
        number += 1
        file.write(dict.fromkeys(NAMES, number), [("error", {"number": number})])
        os.write(1, f"{number}\n".encode())


if __name__ == "__main__":
    main()
