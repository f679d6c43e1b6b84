"""A standby process: its modules are loaded, its regions inherited, and it does nothing until a line on its standard input.

Loading them is most of a start: a second on a small computer, in which a PLC would have no partner (AX-561).
"""

import subprocess
import sys

OPTION = "--spare"


def called() -> bool:
    """In the spare: wait.  True: take over.  False: the supervisor no longer needs it, or is gone."""
    return sys.stdin.buffer.readline() == b"go\n"


class Spare:
    """In the supervisor: a process started with OPTION and a pipe as its standard input."""

    def __init__(self, process: "subprocess.Popen[bytes]") -> None:
        self.process = process

    @property
    def is_standby(self) -> bool:
        return self.process.poll() is None

    def call(self) -> bool:
        """False: it is dead, another one has to be started."""
        assert self.process.stdin is not None
        try:
            self.process.stdin.write(b"go\n")
            self.process.stdin.close()
        except OSError:
            return False
        return self.is_standby

    def end(self) -> None:
        """Also a dead or a stopped one."""
        self.process.kill()
        self.process.wait()
        for pipe in (self.process.stdin, self.process.stdout):
            if pipe is not None:
                pipe.close()
