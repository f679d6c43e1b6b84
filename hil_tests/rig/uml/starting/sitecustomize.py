"""A Python program takes half a second to start, also where computing takes no time (a guest with a clock of its own, AX-562).

What dies is back at once there, before anybody missed it; tests of deaths want the silence that every real restart is.
Python imports this by itself where PYTHONPATH names this folder.
"""

import time

time.sleep(0.5)
