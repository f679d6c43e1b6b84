"""The application: interface, live connection and the files of the page, with the headers a browser is to obey."""

import asyncio
import contextlib
import pathlib
from collections.abc import AsyncIterator

from starlette.applications import Starlette
from starlette.datastructures import MutableHeaders
from starlette.requests import Request
from starlette.responses import FileResponse, JSONResponse, Response
from starlette.routing import Mount, Route, WebSocketRoute
from starlette.staticfiles import StaticFiles
from starlette.types import ASGIApp, Message, Receive, Send
from starlette.types import Scope as Connection

from gateway.assembly.jog import jog_of
from gateway.assembly.run import RunPlan
from gateway.observer.names import Names
from gateway.observer.regions import Regions
from gateway.observer.tool_link import GLANCE_S, ServicesLink
from gateway.pure.cell.web import Web
from gateway.web.access import Access, Denied
from gateway.web.api import Api, endpoints
from gateway.web.cell_view import described
from gateway.web.endpoints import openapi, routes
from gateway.web.german import says
from gateway.web.live import Live
from gateway.web.operator_control import OperatorControl
from gateway.web.plant_view import Plant
from gateway.web.scope import Scope
from gateway.web.socket import Sockets
from gateway.web.store import Store

STATIC = pathlib.Path(__file__).parent / "static"
PAGES = (
    "overview",
    "axes",
    "signals",
    "scope",
    "lines",
    "bus",
    "motion",
    "programs",
    "val3",
    "plc",
    "pendant",
    "events",
    "cell",
    "emulator",
    "access",
)
HEADERS = {
    "content-security-policy": "default-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data:; object-src 'none'; "
    "base-uri 'none'; frame-ancestors 'none'; form-action 'self'",
    "x-content-type-options": "nosniff",
    "referrer-policy": "same-origin",
    "x-frame-options": "DENY",
    "cross-origin-opener-policy": "same-origin",
}


class Headers:
    """Adds them to every answer; answers of the interface are not cached, the page's files are revalidated."""

    def __init__(self, app: ASGIApp, *, tls: bool) -> None:
        self._app, self._more = app, {"strict-transport-security": "max-age=31536000"} if tls else {}

    async def __call__(self, scope: Connection, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return

        async def sent(message: Message) -> None:
            if message["type"] == "http.response.start":
                headers = MutableHeaders(scope=message)
                headers.update({**HEADERS, **self._more})
                headers["cache-control"] = "no-store" if scope["path"].startswith("/api") else "no-cache"
            await send(message)

        await self._app(scope, receive, sent)


def make_app(plan: RunPlan, web: Web, regions: Regions, store: Store, scope: Scope) -> Starlette:
    """Everything of one run, wired."""
    services_link, looker = ServicesLink(plan.slug), ServicesLink(plan.slug, GLANCE_S)
    operator_control = OperatorControl(services_link, regions, plan.cell.axis, jog_of(plan.cell))
    plant = Plant(plan)
    names = Names(plan.cell)
    live = Live(plan, regions, looker, operator_control, plant, scope, names)
    access = Access(store, web, simulated=plan.simulated)
    api = Api(live, names, access, described(plan, plant, live.skeleton))
    sockets = Sockets(live, operator_control, access)
    api.accounts.judge = sockets.judge
    table = endpoints(api)
    description = openapi(table, "1")

    async def described_api(request: Request) -> Response:
        return JSONResponse(description)

    async def page(request: Request) -> Response:
        try:
            access.host(request)
        except Denied as denied:
            return JSONResponse({"error": denied.words, "say": says(denied.words)}, denied.status)
        return FileResponse(STATIC / "index.html")

    @contextlib.asynccontextmanager
    async def lifespan(app: Starlette) -> AsyncIterator[None]:
        tasks = [asyncio.create_task(live.run()), asyncio.create_task(operator_control.run()), asyncio.create_task(sockets.run())]
        yield
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
        plant.close()
        services_link.close()
        looker.close()

    app = Starlette(
        routes=[
            *routes(table, access),
            Route("/api/openapi.json", described_api),
            WebSocketRoute("/live", sockets.serve),
            Route("/", page),
            *(Route(f"/{name}", page) for name in PAGES),
            Mount("/static", StaticFiles(directory=STATIC)),
        ],
        lifespan=lifespan,
    )
    app.add_middleware(Headers, tls=bool(web.tls_certificate))
    return app
