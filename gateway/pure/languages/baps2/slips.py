"""Misspelt words of the language: which word a name was meant to be.  One slip is one fault, because the word is read as it was meant."""

from collections.abc import Collection

from gateway.pure.languages.baps2.words import Words
from gateway.pure.languages.base.near import nearest


def meant(text: str, words: Words, tokens: Collection[str]) -> str:
    """The spelling nearest to the text, of these tokens; "": it is a name of its own."""
    return nearest(text, (spelling.text for token in tokens for spelling in words.spellings.get(token, ())))
