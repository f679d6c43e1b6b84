"""The integrated PLC: one compiled form, two executors (an interpreter that counts commands, generated functions), timers, counters."""
