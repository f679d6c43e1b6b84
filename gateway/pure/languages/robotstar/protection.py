"""Protection of programs: five letters, each locked or not.  Source: robotstar 1.3, L1064-1080, L1404-1423, D-47."""

DELETE, EXECUTE, EDIT, STRUCTURE, RENAME = LETTERS = "LAESU"
MEANINGS = {
    DELETE: "deletion",
    EXECUTE: "execution",
    EDIT: "editing of commands",
    STRUCTURE: "changes of its structure",
    RENAME: "renaming",
}


class Protected(ValueError):
    """An operation that is locked, or letters that are none; the text names them."""


def letters_of(text: str) -> str:
    """Letters that are to be locked, in their order; "-" and "" for none.  Protected."""
    wanted = set(text.upper()) - set("-/ ")
    if wrong := wanted - set(LETTERS):
        meant = ", ".join(f"{letter} {meaning}" for letter, meaning in MEANINGS.items())
        raise Protected(f"{''.join(sorted(wrong))}: not a letter of a protection; the letters are {meant}")
    return "".join(letter for letter in LETTERS if letter in wanted)


def shown(locked: str) -> str:
    """As the directory shows it: `-` for each locked letter."""
    return "/".join("-" if letter in locked else letter for letter in LETTERS)


def demand(program: str, locked: str, letter: str) -> None:
    """Protected where the operation is locked."""
    if letter in locked:
        raise Protected(f"{program} is protected against {MEANINGS[letter]} ({shown(locked)})")
