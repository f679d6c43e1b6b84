"""The words of a PIC program, English and German, and the meaning of words of other languages."""

from gateway.pure.languages.plc.commands import Code

IF, THEN, ELSE, JUMP = ("IF", "WENN"), ("THEN", "DANN"), ("ELSE", "SONST"), ("JUMP", "SPRUNG")
BEGIN, END = ("BEGIN", "ANFANG"), ("END", "ENDE")
NOT, AND, OR = ("NOT", "NICHT"), ("AND", "UND"), ("OR", "ODER")
RESERVED = frozenset((*IF, *THEN, *ELSE, *JUMP, *BEGIN, *END, *NOT, *AND, *OR))
LINKS = {"A": Code.AND, "U": Code.AND, "AN": Code.AND_NOT, "UN": Code.AND_NOT, "O": Code.OR, "ON": Code.OR_NOT}
OPENS = {"A": Code.OPEN_AND, "U": Code.OPEN_AND, "O": Code.OPEN_OR}
SETS = {"S": Code.SET, "R": Code.RESET}
JUMPS = {"JC": Code.JUMP_IF, "SPB": Code.JUMP_IF, "JU": Code.JUMP, "SPA": Code.JUMP}
NOTHING, ENDS = ("NOP1", "NOP0"), ("EP", "PE")
LIST = frozenset((*LINKS, *SETS, *JUMPS, *NOTHING, *ENDS))
SEVERAL = "put several statements between BEGIN and END"
REMEDIES = {  # for words of other languages
    "GOTO": "write JUMP",
    **dict.fromkeys(("ENDIF", "END_IF", "IF_END"), f"an IF has no end: {SEVERAL}"),
    **dict.fromkeys(("ELSEIF", "ELSIF"), "write ELSE IF"),
}
