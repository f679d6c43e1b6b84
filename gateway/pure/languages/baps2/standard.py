"""Standard functions, variables, constants and special functions (rho 3 releases, spec 5.4 and 5.7)."""

from collections.abc import Callable

from gateway.pure.languages.baps2 import values
from gateway.pure.languages.baps2.types import CHAR, INTEGER, REAL, TEXT, Type

VERSION = 2.31  # of the compiler (L4348-4361); AX-692
CLS = "\f"

FUNCTIONS: dict[str, tuple[str, Type, str]] = {  # name -> type of the parameter, result, Python function
    "ORD": ("CHAR", INTEGER, "code"),
    "CHR": ("INTEGER", CHAR, "character"),
    "ROUND": ("NUMBER", INTEGER, "whole"),
    "TRUNC": ("NUMBER", INTEGER, "truncated"),
    "ABS": ("NUMBER", REAL, "abs"),
    "SQRT": ("NUMBER", REAL, "root"),
    "SIN": ("NUMBER", REAL, "sine"),
    "COS": ("NUMBER", REAL, "cosine"),
    "ATAN": ("NUMBER", REAL, "arc_tangent"),
}
ROUNDED: dict[str, Callable[[float], int]] = {"ROUND": values.whole, "TRUNC": values.truncated}
CONDITIONS = ("CONDITION", "STATUS", "ZUSTAND")
ENDS = ("END_OF_FILE", "DATEI_ENDE")
CONVERSIONS = {"WC": ("JC_POINT", "POINT"), "JC": ("POINT", "JC_POINT")}
POSITIONS = {"POS": "POINT", "@POS": "JC_POINT", "@MPOS": "JC_POINT"}
FACTORS = ("V", "A", "D", "V_PTP", "A_PTP", "D_PTP", "R", "R_PTP", "VFACTOR", "AFACTOR", "DFACTOR")
LIMITS = ("LIMIT_MIN", "LIMIT_MAX")
CONSTANTS: dict[str, tuple[Type, object]] = {"VERSION": (REAL, VERSION), "CLS": (TEXT, CLS)}
DEVICES = frozenset({"PHG", "TTY", *(f"V24_{n}" for n in range(1, 5)), *(f"SER_{n}" for n in range(1, 5))})
PROCEDURES = ("INT_ASC", "ASC_INT")
GERMAN = {  # axisgate's, as the manual prints no German ones (AX-1747)
    **{f"{letter}FAKTOR": f"{letter}FACTOR" for letter in "VAD"},
    "WK": "WC",
    "MK": "JC",
    "WK_SYSTEM": "WC_SYSTEM",
    "WK_UR": "WC_UR",
}
TAKEN = ("BREAK", "UNTERBRECHE")  # a standard subroutine, whose name no declaration may use (L11370)

_I, _R, _T = ("INTEGER", True), ("REAL", True), ("TEXT", False)
_JC, _WC, _OUT = ("JC_POINT", False), ("POINT", False), ("INTEGER", False)
_LOGIC = (_I, _I, _I, _R, _R, _I)
SPECIAL: dict[int, tuple[tuple[tuple[str, bool], ...], ...]] = {  # number -> the parameter lists that are reported
    1: (_LOGIC,),
    2: (_LOGIC,),
    3: ((_I, _JC),),
    4: ((_I, _T, _T, _OUT),),
    15: ((_I, _R, _R, _I),),
    16: ((_T, _T, _OUT),),
    21: ((_I, _I),),
    28: ((_I, _R),),
    29: ((_I, _I, _R),),
    30: ((_I, _OUT),),
    31: ((_I, _I, _JC, _WC),),
    41: ((_I, _R),),
    42: ((_I, _R),),
    43: ((_I, _I, ("INPUT", False)),),
    44: ((_I, _I, ("INPUT", False)), (_I, ("INPUT", False))),  # D-25
    45: ((_I, ("BNR_FILE", False), _I, _JC, ("INTEGER[]", True)),),
    46: ((_I, _I),),
}
NAMED_ONLY = (17, 27)  # any parameters (AX-693)
STANDARD_NAMES = frozenset((*POSITIONS, *FACTORS, *LIMITS, *CONSTANTS, "WC_SYSTEM", "WC_UR"))
