"""The witness of a conformance run, in real time."""

import signal
import threading
import time

from gateway.conformance.framework.witness import Witness
from protocols.base.machine import ms


def test_the_worst_of_a_long_case_is_not_forgotten_while_the_host_is_late_all_the_time() -> None:
    """A witness that was held up once for long, then a hundred times a little."""
    witness, wait = Witness(), threading.Event().wait
    try:
        child = witness._children[0]
        end = time.monotonic() + 20
        while len(witness._asleep()) < len(witness._children) and time.monotonic() < end:
            wait(0.05)  # on a busy host it takes its time to start
        witness.begin()
        for held in (0.15, *[0.004] * 100):
            child.send_signal(signal.SIGSTOP)
            wait(held)
            child.send_signal(signal.SIGCONT)
            wait(0.004)
        assert witness.late() > ms(120)
    finally:
        witness.close()


def test_one_that_has_not_woken_yet_is_late_already() -> None:
    """A wait that is not over counts while it lasts, not only afterwards."""
    witness, wait = Witness(), threading.Event().wait
    try:
        end = time.monotonic() + 20
        while len(witness._asleep()) < len(witness._children) and time.monotonic() < end:
            wait(0.05)
        witness._children[0].send_signal(signal.SIGSTOP)
        wait(0.3)
        since = time.monotonic_ns() - ms(200)
        assert witness.late(since) > ms(150)
        witness._children[0].send_signal(signal.SIGCONT)
    finally:
        witness.close()
