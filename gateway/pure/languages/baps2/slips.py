"""Misspelt words of the language: which word a name was meant to be.  One slip is one fault, because the word is read as it was meant."""

from collections.abc import Collection

from gateway.pure.languages.baps2.words import Words
from gateway.pure.languages.base.near import nearest

HABITS = {"GOTO": "JUMP"}  # words of other languages
ELSE_IF = ("ELSEIF", "ELSIF", "ELIF")
STRANGERS = {  # those that BAPS2 has no word for: the remedy
    "BAPS2 has no WHILE: write a label, IF and JUMP": ("WHILE", "WHILE_END", "ENDWHILE", "END_WHILE", "WEND"),
    "BAPS2 has no FOR: write REPEAT n TIMES": ("FOR", "NEXT", "FOR_END", "ENDFOR", "END_FOR"),
    "an IF has no end: put several statements between BEGIN and END": ("ENDIF", "END_IF", "IF_END"),
    "a subroutine ends at SUB_END": ("RETURN", "RET"),
    "a subroutine is called by its name": ("CALL", "GOSUB"),
    "the word is WRITE": ("PRINT",),
}
REMEDIES = {word: remedy for remedy, words in STRANGERS.items() for word in words}
WHOLE_LINES = [word for remedy, words in STRANGERS.items() if remedy.startswith("BAPS2 has no") for word in words]
IN_FRONT = ("CALL", "GOSUB")  # a separate statement follows


def meant(text: str, words: Words, tokens: Collection[str], language: str) -> str:
    """The spelling nearest to the text, of these tokens, rather in this language; "": it is a name of its own."""
    if (habit := HABITS.get(text.upper(), "")) in tokens:
        return words.spellings[habit][0].text
    spellings = [spelling for token in tokens for spelling in words.spellings.get(token, ())]
    return nearest(text, [each.text for each in sorted(spellings, key=lambda each: each.language != language)])
