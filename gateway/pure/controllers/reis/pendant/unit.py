"""The keys of the PHG.  Source: robotstar 8.2 (L150-193, L1019-1478)."""

from gateway.pure.controllers.unit import LETTERS, HandUnit

COLUMNS, LINES = 40, 20  # 20 lines (L1027); "more than 37 characters" run out of the window after the number of the step (L1474)
MODE_KEYS = {"DIR": "dir", "RUN": "run", "COORD": "coor", "INFO": "info", "FUNCT": "fkt", "WINDOW": "cwin"}
FUNCTION_KEYS = ("F1", "F2", "F3", "F4", "F5", "F6")
MOVEMENT = {f"{number}{sign}": (number, 1 if sign == "+" else -1) for number in range(1, 7) for sign in "-+"}
SIGNS = {  # key of a keyboard -> character of an entry, in addition to letters and the keys of the unit
    "underscore": "_", "dollar_sign": "$", "left_square_bracket": "[", "right_square_bracket": "]", "colon": ":", "quotation_mark": '"',
    "number_sign": "#", "equals_sign": "=", "less_than_sign": "<", "greater_than_sign": ">", "left_parenthesis": "(", "percent_sign": "%",
    "right_parenthesis": ")", "plus": "+", "semicolon": ";", "apostrophe": "'", "asterisk": "*",
}  # fmt: skip
SPACE = "SPACE"
CHARACTERS = frozenset((*LETTERS, *"0123456789", ".", "-", ",", "/", SPACE, *SIGNS.values()))
KEYPAD = (
    (*MODE_KEYS, "", ""),
    ("MENU-", *FUNCTION_KEYS, "MENU+"),
    ("STEP", "7", "8", "9", "UP", "SHIFT", "1-", "1+"),
    ("/", "4", "5", "6", "DOWN", "ALT", "2-", "2+"),
    (",", "1", "2", "3", "LEFT", "DELETE", "3-", "3+"),
    ("-", "0", ".", "ENTER", "RIGHT", "QUIT", "4-", "4+"),
    ("START", "STOP", "EXEC", "OV-", "OV+", "", "5-", "5+"),
    ("PC-I", "PC-O", "", "", "", "", "6-", "6+"),
)
TYPED = {
    "enter": "ENTER", "backspace": "DELETE", "delete": "DELETE", "escape": "QUIT", "up": "UP", "down": "DOWN", "left": "LEFT",
    "right": "RIGHT", "full_stop": ".", "comma": ",", "minus": "-", "slash": "/", "pageup": "MENU-", "pagedown": "MENU+",
    "space": SPACE, **SIGNS,
}  # fmt: skip
FACES = {"MENU-": "◀", "MENU+": "▶", "OV-": "% -", "OV+": "% +", "PC-I": "I", "PC-O": "O"}
UNIT = HandUnit(
    "ROBOTstar V", COLUMNS, LINES, KEYPAD, TYPED, (*LETTERS, SPACE, *SIGNS.values()), ("START", "EXEC", *MOVEMENT), FACES
)  # fmt: skip
