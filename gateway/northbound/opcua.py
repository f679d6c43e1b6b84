"""Values as nodes of an OPC UA server that can be read and subscribed to, never written (AX-429).  asyncua does the protocol."""

import datetime
import logging
from typing import Any

import asyncua
from asyncua.crypto.permission_rules import User, UserRole
from asyncua.server.server import Server
from asyncua.server.user_managers import UserManager

from gateway.northbound.snapshot import Value
from gateway.pure.cell.northbound import NorthOpcua

ua: Any = asyncua.ua  # its own number types are cast by the library
NAMESPACE = "urn:axisgate"
TYPES = {bool: ua.VariantType.Boolean, int: ua.VariantType.Int64, float: ua.VariantType.Double, str: ua.VariantType.String}


class OnlyReaders(UserManager):
    """Every client may read."""

    def get_user(self, iserver: object, username: str | None = None, password: str | None = None, certificate: Any = None) -> User:
        """The library's default makes every client an administrator."""
        return User(role=UserRole.User)


class OpcuaOut:
    """One server, its address space made of the names of the first look."""

    def __init__(self, settings: NorthOpcua, slug: str, title: str) -> None:
        self._settings, self._slug, self._title = settings, slug, title
        self._server = Server(user_manager=OnlyReaders())
        self._last: dict[str, Value] = {}
        self._nodes: dict[str, Any] = {}
        logging.getLogger("asyncua").setLevel(logging.ERROR)

    async def start(self, values: dict[str, Value]) -> None:
        """Nodes Objects/axisgate/SLUG/name, identifier `ns=N;s=name`.  OSError: the port is in use."""
        server = self._server
        await server.init()
        server.set_endpoint(f"opc.tcp://{self._settings.bind}/axisgate")
        server.set_server_name(f"axisgate {self._title}")
        server.set_security_policy([ua.SecurityPolicyType.NoSecurity])
        space = await server.register_namespace(NAMESPACE)
        folder = await (await server.nodes.objects.add_folder(space, "axisgate")).add_folder(space, self._slug)
        for name, value in values.items():
            node = await folder.add_variable(ua.NodeId(name, space), name, ua.Variant(value, TYPES[type(value)]))
            self._nodes[name] = node.nodeid
        self._last = dict(values)
        await server.start()

    async def publish(self, values: dict[str, Value], stale: bool) -> None:
        """Publish changed values; `stale`: they are no longer updated, and their status shows it."""
        moment = datetime.datetime.now(datetime.UTC)
        status = ua.StatusCode(ua.StatusCodes.UncertainLastUsableValue if stale else ua.StatusCodes.Good)
        for name, value in values.items():
            node = self._nodes.get(name)
            if node is not None and (stale or self._last.get(name) != value):
                variant = ua.Variant(value, TYPES[type(value)])
                await self._server.write_attribute_value(node, ua.DataValue(variant, status, SourceTimestamp=moment))
        self._last = {} if stale else dict(values)

    async def stop(self) -> None:
        """Clients see the end of their connection."""
        await self._server.stop()
