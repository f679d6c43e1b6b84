"""Runtime errors with the manual's number and text (rho 3 releases, chapter of each); texts printed without a number count from 200."""

from gateway.pure.languages.base.requests import RuntimeFault

TEXTS = {
    20: "Belt-sync. n.possible",
    23: "PTP not allowed for belt synchronous or sensor movement",
    38: "Inad. Real-Expression",
    63: "READ_BEGIN expected",
    89: "beltdistance is zero",
    90: "Point is invalid",
    91: "Inadmiss. meas. sys.",
    92: "wrong belt-kind/-tol",
    93: "Inadmiss. Belt-No",
    95: "MF: Version identification",
    96: "MF: No. of axes",
    97: "MF: Read marker err.",
    98: "MF: Time base",
    99: "MF: IP-PL base",
    100: "MF: Format error",
    101: "MF: MOD flag not init.",
    102: "MF: No endless axis",
    **dict.fromkeys(range(928, 938), "wrong belt direction"),  # by kinematic
    1051: "User process already exists",
    1057: "File repeatedly open",
    1073: "Program can only be run as an external subroutine",
    1079: "sub-process tries to stop its own main process",
    1092: "selected program not available",
    200: "point not defined",
    201: "Protocol error READ",
    202: "file name n. allowed",
    203: "file seq. failed.",
    204: "option not found",
    205: "point not reachable",
    206: "inadmissable input",
    207: "IRD Stack Overflow",
    208: "integer overflow",
    209: "division by zero",
    210: "index out of range",
    211: "real overflow",
    212: "interface error",
    213: "file not available",
    214: "file is not open for this",
    216: "IOL:Fkt. still in use",
    217: "PPO:Fkt. still in use",
    218: "value out of range",
    219: "end of file",
    220: "no kinematic",
    221: "wrong number of components",
    222: "not possible in a cell",
    223: "a circle has two points",
    224: "inadmissable output",
    225: "outside the working range",
}
OURS = range(208, 1_000)  # texts that the manual does not print


def fault(code: int, more: str = "") -> RuntimeFault:
    """The runtime error of a code.  `more` is added to axisgate's texts; the manual's texts are used as printed."""
    return RuntimeFault(code, TEXTS[code] + (f": {more}" if more and code in OURS else ""))
