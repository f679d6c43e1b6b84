"""Why statements of STEP 5 and STEP 7 have no counterpart in the integrated PLC."""

INDIRECT = "operands cannot be indirect"
NO_STATUS = "there are no condition bits; compare"
REST = "DI leaves the rest in ACCU2, where STEP leaves the dividend; load what the next statement uses"
REASONS = {
    "SS": "the integrated PLC has no latching switch-on delay; use a marker that keeps the start",
    "FR": "timers and counters cannot be freed",
    "LC": "timers and counters cannot be loaded",
    "B": INDIRECT,
    **dict.fromkeys(("LAR1", "LAR2", "TAR1", "TAR2", "CAR", "+AR1", "+AR2"), INDIRECT),
    "LIR": "there is no access by address",
    "TIR": "there is no access by address",
    "TNB": "there is no access by address",
    "STP": "a program cannot stop the PLC",
    "STS": "a program cannot stop the PLC",
    "AS": "there are no interrupts",
    "AF": "there are no interrupts",
    "CALL": "subprograms have no parameters",
    **dict.fromkeys(("SU", "RU"), "bits are set and reset by the result only; write O M0.0, ON M0.0 in front of S or R"),
    **dict.fromkeys(("P", "PN"), "a bit is tested with U or UN"),
    "E": "the integrated PLC has no data blocks",
    "SAVE": "there is no bit BIE; keep the result in a marker",
    **dict.fromkeys(("PUSH", "POP", "ENT", "LEAVE"), "there are two accumulators; TA exchanges them"),
    **dict.fromkeys(("MCRA", "MCRD", "MCR(", ")MCR"), "there is no master control relay; put its condition into each chain"),
    **dict.fromkeys(("LOOP", "JL"), "no jump counts or selects by a number; compare and jump"),
    **dict.fromkeys(("SVW", "SVD", "SSI", "SSD"), "shifts fill with 0, also those of a negative number"),
    **dict.fromkeys(
        ("ITD", "DTR", "RND", "RND+", "RND-", "TRUNC", "+R", "-R", "*R", "/R"), "numbers have 32 bits; there are no real numbers"
    ),
    **dict.fromkeys(("SPZ", "SPN", "SPP", "SPM", "SPO", "SPMZ", "SPPZ", "SPS", "SPU", "SPL", "SPBI", "SPBIN"), NO_STATUS),
}
WORD_ORDER = "byte order of words: STEP has the high byte first, the integrated PLC the low one; give the word a marker with --words"
