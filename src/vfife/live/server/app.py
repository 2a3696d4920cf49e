"""HTTP routes of a session, and the guard that accepts only browsers of this machine that know the secret.

The secret is a part of every address. A cookie would also be sent to servers on other ports of this machine.
"""

from __future__ import annotations

import asyncio
import json
import logging
import secrets
import socket
import threading
from collections.abc import AsyncIterator, Awaitable, Callable, Iterable, Iterator
from contextlib import asynccontextmanager, contextmanager
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import Any

import uvicorn
from starlette.applications import Starlette
from starlette.concurrency import run_in_threadpool
from starlette.datastructures import Headers
from starlette.requests import Request
from starlette.responses import HTMLResponse, JSONResponse, PlainTextResponse, Response, StreamingResponse
from starlette.routing import Route
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from ...errors import VfifeError
from .documents import LARGEST, Conflict, Document, Draft, Json, fault_list, text_in
from .pages import drawing
from .session import MOST_BROWSERS, Mailbox, Session

LOCALHOST = "127.0.0.1"
PATIENCE = 20.0  # s, limit for the server to start
LEFT = 0.8  # s, limit for the server to stop
BROWSER = Path(__file__).resolve().parents[1] / "browser" / "served"
SCHEMA = Path(__file__).resolve().parents[2] / "modelfile" / "model.schema.json"
KINDS = {".html": "text/html", ".js": "text/javascript", ".css": "text/css"}
SERVED_FILES = (
    "shell.html", "shell.js", "shell.css", "form.js", "places.js", "labels.js", "paper.js", "tools.js",
    "additions.js", "sketch.js", "editor.js",
)  # fmt: skip
COMMON = ("theme.js", "pen.js", "theme.css")  # with pages
BEAT = 10.0  # s between two comments on an idle event stream
FAULT = "<!doctype html><meta charset=utf-8><body data-said=1><pre style='white-space: pre-wrap'>{}</pre>"
POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; img-src 'self' data:;"
    " frame-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
# Policy of a page that runs a mechanism; the page itself declares that it may load nothing.
WITHIN = "frame-ancestors 'self'"
HEADERS = {
    "referrer-policy": "no-referrer",
    "x-content-type-options": "nosniff",
    "cross-origin-resource-policy": "same-origin",
    "cross-origin-opener-policy": "same-origin",
    "cache-control": "no-store",
}

Answer = Callable[[Request], Awaitable[Response]]


def app(session: Session, secret: str, hosts: tuple[str, ...]) -> Guard:
    """Return the application with its guard. ``hosts`` are the accepted values of the Host header."""

    @asynccontextmanager
    async def alive(_: Starlette) -> AsyncIterator[None]:
        watching = asyncio.create_task(session.watch())
        yield
        watching.cancel()
        session.close()

    def doing(act: Callable[[Request, Json], Any]) -> Answer:
        async def answer(request: Request) -> Response:
            return await answer_of(request, act)

        return answer

    async def running(request: Request) -> Response:
        return await page(request, session)

    async def shown(request: Request) -> Response:
        return await gallery_drawing(request, session)

    def of(request: Request) -> str:
        return str(request.path_params["which"])

    def take_text(request: Request, body: Json) -> Json:
        new, drawn = text_in(body, "text"), body.get("sketch") is True
        return session.change(of(request), lambda document: document.take(new, body["version"]), not drawn)

    actions: dict[str, Callable[[Request, Json], Any]] = {
        "text": take_text,
        "sketch": lambda request, body: session.sketch(of(request), body),
        "set": lambda request, body: session.change(
            of(request), lambda document: document.set(changes(body), body["version"])
        ),
        "undo": lambda request, _: session.change(of(request), Document.undo),
        "redo": lambda request, _: session.change(of(request), Document.redo),
        "save": lambda request, body: session.save(of(request), name_in(body)),
        "run": lambda request, _: session.run(of(request)),
        "stop": lambda request, _: session.runs.stop(of(request)),
    }
    routes = [
        Route("/", lambda _: file("shell.html")),
        Route("/{name}.js", lambda request: file(f"{request.path_params['name']}.js")),
        Route("/{name}.css", lambda request: file(f"{request.path_params['name']}.css")),
        Route("/schema", lambda _: Response(SCHEMA.read_bytes(), media_type="application/json")),
        Route("/events", lambda _: listening(session)),
        Route("/shelf", doing(lambda *_: session.shelf.json())),
        Route("/model/{which}", doing(lambda request, _: session.shelf[of(request)].json())),
        Route("/model/{which}/page", running),
        Route("/drawing/{name}", shown),
        Route("/open", doing(lambda _, body: session.open(body)), methods=["POST"]),
        *(Route(f"/model/{{which}}/{name}", doing(act), methods=["POST"]) for name, act in actions.items()),
    ]
    return Guard(Starlette(routes=routes, lifespan=alive), secret, hosts)


def file(name: str) -> Response:
    """Return one of the static files of the page."""
    if name not in (*SERVED_FILES, *COMMON):
        return Response(status_code=404)
    folder = BROWSER if name in SERVED_FILES else BROWSER.parent
    return Response((folder / name).read_bytes(), media_type=KINDS[Path(name).suffix])


def name_in(body: Json) -> str | None:
    """Return the name under which a model is to be saved, None for its present one. Raises TypeError for
    anything but a text.
    """
    return None if body.get("name") is None else text_in(body, "name")


def changes(body: Json) -> list[tuple[tuple[str | int, ...], str | None]]:
    """Return the paths and new values that a browser sent. Raises ValueError for an invalid form."""
    pairs = []
    for change in body["changes"]:
        path, value = change["path"], change["value"]
        if (
            not isinstance(path, list)
            or not path
            or not all(isinstance(part, str | int) for part in path)
            or not isinstance(value, str | None)
        ):
            raise ValueError("a change is a path, which is a list of names, and a text or nothing")
        pairs.append((tuple(path), value))
    return pairs


async def answer_of(request: Request, act: Callable[[Request, Json], Any]) -> Response:
    """Return the answer of an action, or its faults with status 404 (no such model), 409 (changed meanwhile)
    or 422 (invalid).
    """
    try:
        content = json.loads(await body(request)) if request.method == "POST" else {}
        if not isinstance(content, dict):
            raise TypeError
    except (ValueError, TypeError, RecursionError):
        return fault_answer(ValueError("what was sent is no object of JSON"), 400)
    try:
        return JSONResponse(await run_in_threadpool(act, request, content))
    except Conflict as error:
        return fault_answer(error, 409)
    except Draft as error:
        return fault_answer(error, 422, draft={"text": error.text, "values": error.values})
    except LookupError:
        return fault_answer(ValueError("this model is not open here; choose one"), 404)
    except OSError as error:
        return fault_answer(ValueError(f"it cannot be written: {error.strerror or error}"), 422)
    except (VfifeError, ValueError, TypeError) as error:
        return fault_answer(error, 422)


def fault_answer(error: Exception, status: int, **entries: Any) -> JSONResponse:
    """Return the answer with the faults of an error, and further entries."""
    return JSONResponse({"faults": fault_list(error), **entries}, status)


async def body(request: Request) -> bytes:
    """Return the body of a request. Raises ValueError if it is larger than any model."""
    received = b""
    async for part in request.stream():
        received += part
        if len(received) > 2 * LARGEST:
            raise ValueError
    return received


async def page(request: Request, session: Session) -> Response:
    """Return the page that runs a model, or a page with the reason why it cannot run."""
    headers = {"content-security-policy": WITHIN}
    try:
        document = session.shelf[request.path_params["which"]]
        text = await run_in_threadpool(
            session.pages.page, document, request.query_params.get("sliders") == "1"
        )
        return HTMLResponse(text, headers=headers)
    except LookupError:
        return HTMLResponse(FAULT.format("This model is not open here; choose one."), 404, headers)
    except (VfifeError, ValueError, ArithmeticError) as error:
        return HTMLResponse(FAULT.format(escape(str(error))), 422, headers)
    except Exception as error:  # also for a programming error the browser must get a page, not wait for one
        return HTMLResponse(
            FAULT.format(escape(f"This cannot be shown: {type(error).__name__}: {error}")), 500, headers
        )


async def gallery_drawing(request: Request, session: Session) -> Response:
    """Return a drawing of the gallery or of a model file: one at a time, after pages in progress, and none if
    the browser has left.
    """
    async with session.drawing:
        while session.pages.building.locked():
            await asyncio.sleep(0.02)
        if await request.is_disconnected():
            return Response(status_code=204)
        name = request.path_params["name"]
        try:
            path = session.shelf.files().get(name)
            changed = path.stat().st_mtime_ns if path else 0
            picture = await run_in_threadpool(drawing, name, path, changed)
        except (LookupError, VfifeError, OSError):
            return Response(status_code=404)
        return Response(picture, media_type="image/svg+xml")


def listening(session: Session) -> Response:
    """Return the event stream of a session; 503 if so many browsers listen that it must be a mistake."""
    if len(session.listeners) >= MOST_BROWSERS:
        return Response("vfife live: too many browsers listen; close some\n", 503, {"retry-after": "10"})
    return StreamingResponse(events(session), media_type="text/event-stream")


async def events(session: Session) -> AsyncIterator[str]:
    """Yield events as they occur, and a comment every ``BEAT`` seconds that keeps the connection open."""
    mailbox = Mailbox()
    if len(session.listeners) >= MOST_BROWSERS:
        return
    session.listeners.add(mailbox)
    try:
        yield "retry: 500\n\n"
        while True:
            try:
                (kind, _), event = await mailbox.take(BEAT)
            except TimeoutError:
                yield ": here\n\n"
                continue
            yield event
            if kind == "end":
                return
    finally:
        session.listeners.discard(mailbox)


class Guard:
    """Refuse, with status 403, requests with a foreign host name (DNS rebinding), from a foreign page, or
    without the secret.
    """

    def __init__(self, app: ASGIApp, secret: str, hosts: Iterable[str]) -> None:
        self.app, self.secret, self.hosts = app, secret, frozenset(hosts)
        self.origins = frozenset(f"http://{host}" for host in self.hosts)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer or refuse a request."""
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return
        if (reason := self.refusal(scope)) is not None:
            await PlainTextResponse(f"vfife live: {reason}\n", 403, HEADERS)(scope, receive, send)
            return

        async def marked(message: Message) -> None:
            if message["type"] == "http.response.start":
                headers = list(message.get("headers", ()))
                names = {name for name, _ in headers}
                ours = {**HEADERS, "content-security-policy": POLICY}
                message["headers"] = headers + [
                    (k.encode(), v.encode()) for k, v in ours.items() if k.encode() not in names
                ]
            await send(message)

        # The secret becomes part of the root path, so that routes and relative links do not contain it.
        _, secret, path = scope["path"].split("/", 2)
        root = f"/{secret}"
        await self.app({**scope, "path": f"{root}/{path}", "root_path": root}, receive, marked)

    def refusal(self, scope: Scope) -> str | None:
        """Return why a request is refused, None if it is accepted."""
        headers = Headers(scope=scope)
        # The Host header is checked first: a foreign name that resolves to this machine (DNS rebinding) would
        # make the requests of a foreign page same-origin.
        if headers.get("host", "") not in self.hosts:
            return "the host name is not that of this machine"
        origin = headers.get("origin")
        if origin is not None and origin not in self.origins:
            return "the request comes from a foreign page"
        # Following a link is accepted, because terminals in a browser show the address as one. A link only
        # loads the page for the user; the foreign page that contains it cannot read the answer.
        followed = scope["method"] == "GET" and headers.get("sec-fetch-dest") == "document"
        if headers.get("sec-fetch-site", "none") not in ("same-origin", "none") and not followed:
            return "the request comes from a foreign page"
        # Forms of foreign pages can send other content types without a preflight request.
        if (
            scope["method"] not in ("GET", "HEAD")
            and headers.get("content-type", "").partition(";")[0] != "application/json"
        ):
            return "the body of the request is not JSON"
        parts = scope["path"].split("/", 2)
        if len(parts) < 3 or not secrets.compare_digest(parts[1].encode(), self.secret.encode()):
            return (
                "the address is not the one that was printed when it was started; the secret in it is another"
            )
        return None


# ---------------------------------------------------------------------------------------------------- serving


@dataclass(frozen=True)
class Serving:
    """A session that answers at ``address``, on ``port``."""

    address: str
    port: int
    thread: threading.Thread

    def wait(self) -> None:
        """Wait until a signal interrupts."""
        while self.thread.is_alive():
            self.thread.join(0.2)


def bound_socket(port: int) -> socket.socket:
    """Return a socket on a port of the loopback interface, 0 for a free one. Raises ValueError if the port is
    in use.
    """
    listening = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        listening.bind((LOCALHOST, port))
        listening.listen(128)
    except (OSError, OverflowError) as error:
        listening.close()
        reason = getattr(error, "strerror", None) or "there is no such port"
        raise ValueError(
            f"--port {port}: {reason}; name another one from 1024 to 65535, or leave it out for one that is"
            " free"
        ) from None
    return listening


@contextmanager
def served(session: Session, port: int = 0) -> Iterator[Serving]:
    """Serve a session in a thread of its own; at the end connections are closed. Raises ValueError if the
    port is in use.
    """
    # Connections that are closed at the end would be logged as errors.
    logging.getLogger("uvicorn").addHandler(logging.NullHandler())
    logging.getLogger("uvicorn").propagate = False
    listening = bound_socket(port)
    port, secret = listening.getsockname()[1], secrets.token_urlsafe(24)
    hosts = (f"{LOCALHOST}:{port}", f"localhost:{port}")
    config = uvicorn.Config(
        app(session, secret, hosts), http="h11", ws="none", loop="asyncio", lifespan="on", log_config=None,
        access_log=False, server_header=False,
        proxy_headers=False, timeout_graceful_shutdown=0,
    )  # fmt: skip
    server = uvicorn.Server(config)
    thread = threading.Thread(target=server.run, kwargs={"sockets": [listening]}, name="serving", daemon=True)
    thread.start()
    try:
        waited = threading.Event()
        for _ in range(int(PATIENCE / 0.01)):
            if server.started or not thread.is_alive():
                break
            waited.wait(0.01)
        if not server.started:
            raise ValueError("it could not be served here")
        yield Serving(f"http://{LOCALHOST}:{port}/{secret}/", port, thread)
    finally:
        session.close()
        server.should_exit = server.force_exit = True
        thread.join(LEFT)
