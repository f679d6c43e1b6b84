"""Misspelt words of the language: which word a name was meant to be.  One slip is one fault, because the word is read as it was meant."""

from collections.abc import Collection

from gateway.pure.languages.baps2.words import Words
from gateway.pure.languages.base.near import nearest

HABITS = {"GOTO": "JUMP"}  # words of other languages


def meant(text: str, words: Words, tokens: Collection[str], language: str) -> str:
    """The spelling nearest to the text, of these tokens, rather in this language; "": it is a name of its own."""
    if (habit := HABITS.get(text.upper(), "")) in tokens:
        return words.spellings[habit][0].text
    spellings = [spelling for token in tokens for spelling in words.spellings.get(token, ())]
    return nearest(text, [each.text for each in sorted(spellings, key=lambda each: each.language != language)])
