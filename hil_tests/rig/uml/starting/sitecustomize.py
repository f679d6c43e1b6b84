"""Delay the start of every Python program by half a second, as on the host.

In a guest with a clock of its own, computing takes no time (AX-562): a process that died would be back before its silence could be
noticed, and tests of deaths need that silence.  Python imports this module automatically where PYTHONPATH names this folder.
"""

import time

time.sleep(0.5)
