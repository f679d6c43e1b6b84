"""A station of the line tools as a process of its own at a pty: `python -m hil_tests.lab.partners.line_station PTY PARTNER PROFILE
high|low`.

Prints `ready`; ends with its standard input.
"""

import sys
import threading

from drivers.ports.open import open_bytes
from gateway.conformance.serial.partners import make
from hil_tests.lab.partners.sync_line import SyncLine
from protocols.p3964r.profiles import PROFILES, Priority


def main(argv: list[str]) -> int:
    port, partner, profile, priority = argv
    ended = threading.Event()

    def wait() -> None:
        sys.stdin.read()
        ended.set()

    threading.Thread(target=wait, daemon=True).start()
    station = make(partner, PROFILES[profile], Priority[priority.upper()])
    with SyncLine(open_bytes(port, "9600 8E1"), station) as line:
        print("ready", flush=True)
        while not ended.is_set():
            line.run_for(0.2)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
