"""A VAL 3 variable of type sio.  Source: VAL 3 manual, 3.7.1."""


class Sio:
    """Made and deleted through SioCore; a link is a name; its channel need not exist."""

    def __init__(self, link: str | None) -> None:
        self.link = link
        self.deleted = False

    def __str__(self) -> str:
        return f'sio "{self.link}"' if self.link is not None else "sio without a link"
