"""Modbus/TCP Security: TLS with certificates on both sides, the partner's role from its certificate, rights by role.

Source: MODBUS/TCP Security Protocol Specification V21 (mutual authentication, TLS 1.2 or newer, role in extension
1.3.6.1.4.1.50316.802.1 as a UTF8String; authorisation is the server's own: AX-348).
"""

import asyncio
import pathlib
import ssl
from collections.abc import Mapping

from cryptography import x509

from drivers.ports.base import PortError
from gateway.pure.cell.modbus import ModbusTls
from protocols.modbus.rights import Rights

ROLE_OID = "1.3.6.1.4.1.50316.802.1"
UTF8_STRING = 0x0C
NO_RIGHTS = Rights(read=False, write=False)


def server_context(settings: ModbusTls, folder: pathlib.Path) -> ssl.SSLContext:
    """A context that accepts only partners whose certificate `ca` signed; PortError names the file that is missing or bad."""
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    _equip(context, settings, folder)
    return context


def client_context(settings: ModbusTls, folder: pathlib.Path) -> ssl.SSLContext:
    """The other side: shows our certificate, believes servers that `ca` signed (their addresses are not looked at: plants use numbers)."""
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    context.check_hostname = False
    _equip(context, settings, folder)
    return context


def _equip(context: ssl.SSLContext, settings: ModbusTls, folder: pathlib.Path) -> None:
    context.minimum_version = ssl.TLSVersion.TLSv1_2
    context.verify_mode = ssl.CERT_REQUIRED
    try:
        context.load_cert_chain(folder / settings.certificate, folder / settings.key)
        context.load_verify_locations(folder / settings.ca)
    except OSError as error:  # ssl.SSLError too
        files = ", ".join(str(folder / name) for name in (settings.certificate, settings.key, settings.ca))
        raise PortError(f"Modbus TLS: {error.strerror or error}: certificate, key and ca must be readable PEM files: {files}") from error


def role_of(certificate: bytes) -> str:
    """The role in a certificate (DER); "" when it has none, or one that cannot be read."""
    try:
        extensions = x509.load_der_x509_certificate(certificate).extensions
        found = extensions.get_extension_for_oid(x509.ObjectIdentifier(ROLE_OID)).value
    except (ValueError, x509.ExtensionNotFound, x509.DuplicateExtension):
        return ""
    data = found.value if isinstance(found, x509.UnrecognizedExtension) else b""
    if len(data) < 2 or data[0] != UTF8_STRING or data[1] != len(data) - 2 or data[1] > 127:
        return ""
    return data[2:].decode("utf-8", "replace")


class TlsRights:
    """Rights by role; an undeclared role has no rights and is answered 01 for every request."""

    def __init__(self, roles: Mapping[str, Rights]) -> None:
        self._roles = dict(roles)

    def __call__(self, transport: asyncio.Transport) -> tuple[Rights, str] | None:
        """None: a connection without a certificate."""
        tls = transport.get_extra_info("ssl_object")
        certificate = tls.getpeercert(binary_form=True) if tls is not None else None
        if certificate is None:
            return None
        role = role_of(certificate)
        return self._roles.get(role, NO_RIGHTS), role
