"""One Modbus TCP server in a process of its own, for the bench: `python -m hil_tests.bench.modbus_served ours|pymodbus`.

Prints its port and serves until it is killed.  Both answer unit 1 from tables of 64 registers.
"""

import asyncio
import sys
from typing import Any

from gateway.links.modbus.tcp_server import Limits, ModbusServer
from gateway.pure.image.records.cell import InputImage
from gateway.pure.modbus.rho3_view import RhoView


async def ours() -> None:
    """axisgate's server as a cell has it: the rho3 view, limits as they are by default but for the number of clients."""
    view = RhoView(InputImage(), range(128), lambda octets: None, None)
    server = ModbusServer(lambda unit: view if unit == 1 else None, port=0, limits=Limits(clients=256))
    await server.start()
    print(server.address[1], flush=True)
    await asyncio.Event().wait()


async def theirs() -> None:
    """The server pymodbus comes with."""
    from pymodbus.datastore import ModbusDeviceContext, ModbusSequentialDataBlock, ModbusServerContext
    from pymodbus.server import ModbusTcpServer

    block: Any = ModbusSequentialDataBlock  # comes without types
    tables = {name: block(1, [0] * 64) for name in ("di", "co", "hr", "ir")}
    context = ModbusServerContext(devices={1: ModbusDeviceContext(**tables)}, single=False)
    server: Any = ModbusTcpServer(context, address=("127.0.0.1", 0))
    await server.listen()
    print(server.transport.sockets[0].getsockname()[1], flush=True)
    await asyncio.Event().wait()


if __name__ == "__main__":
    asyncio.run(theirs() if sys.argv[1:] == ["pymodbus"] else ours())
