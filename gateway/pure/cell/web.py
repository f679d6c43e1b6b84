"""[web] of a cell: the page and its interface, a process of its own; no table, no page (AX-470)."""

from dataclasses import dataclass

from gateway.pure.cell.marks import Bind

PAGE_SOURCE = 91  # its number among the command sources of the cell; 90 is the commissioning tools'
LOOPBACK = ("127.0.0.1", "::1", "localhost")


@dataclass(frozen=True, slots=True)
class Web:
    """Where the page is served, and what it may do."""

    bind: Bind = "127.0.0.1:8480"  # address:port
    names: tuple[str, ...] = ()  # host names a browser may use in addition to the bound address: a guard against rebinding (AX-473)
    read_only: bool = False  # nothing can be changed through the page; stop on the path stays
    tls_certificate: str = ""  # PEM; both or none; asked for beyond loopback
    tls_key: str = ""
    data: str = ""  # folder of users, sessions and audit; "": web/ next to the cell file

    @property
    def host(self) -> str:
        return self.bind.rsplit(":", 1)[0].strip("[]")

    @property
    def port(self) -> int:
        return int(self.bind.rsplit(":", 1)[1])

    @property
    def local(self) -> bool:
        """Only programs of this computer reach it."""
        return self.host in LOOPBACK or self.host.startswith("127.")
