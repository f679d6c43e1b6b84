"""Cross checks of [web]: access from other computers is encrypted, and a certificate has its key."""

import pathlib

from gateway.checks.context import Context
from gateway.pure.cell.web import Web


def reachable(context: Context) -> None:
    """AX-470: beyond loopback only with TLS; a proxy for the page uses loopback."""
    web = context.cell.web
    if web is None:
        return
    if not 1 <= web.port <= 65535:
        context.fault("web.bind", web.bind, range_="port 1..65535")
    if bool(web.tls_certificate) != bool(web.tls_key):
        context.fault("web.tls_certificate", web.tls_certificate, "tls_certificate and tls_key belong together")
    elif not web.local and not web.tls_certificate:
        context.fault("web.bind", web.bind, "reached from other computers: set tls_certificate and tls_key, or bind 127.0.0.1")
    _files(context, web)


def _files(context: Context, web: Web) -> None:
    for key, name in (("tls_certificate", web.tls_certificate), ("tls_key", web.tls_key)):
        if name and not (pathlib.Path(context.cell.file).parent / name).is_file():
            context.fault(f"web.{key}", name, "no such file (looked for in the folder of the cell file)")


CHECKS = (reachable,)
