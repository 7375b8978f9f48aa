"""HTTP and WebSocket server of the page: on this computer only, with a secret token.

The server listens on the loopback address, answers only requests with its name (Host), from its own
page (Origin) and with the token, and serves nothing but the page and the opened objects. Threads
compute the answers, so that a slow one stops neither pictures nor other pages.
"""

from __future__ import annotations

import asyncio
import json
import logging
import secrets
import threading
import webbrowser
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from http import HTTPStatus
from typing import Any, Protocol
from urllib.parse import parse_qs, urlsplit

from websockets.asyncio.server import Server as Listening, ServerConnection, serve
from websockets.datastructures import Headers
from websockets.exceptions import ConnectionClosed
from websockets.http11 import Request, Response

from jousto.base.errors import InputError, JoustoError, Problem
from jousto.viewer.bundle import CSS, JS, policy, read_bundle, served_page
from jousto.viewer.container import pack
from jousto.viewer.file_watch import Renewed

HOST = "127.0.0.1"
LONGEST = 1 << 20  # bytes of a request
CLIENTS = 32  # pages at once
AT_ONCE = 4  # concurrent requests of a page; others wait
SLOW = ("worst", "extent", "history", "sensor")  # requests that may read a whole run
SAFE = {
    "Cache-Control": "no-store",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
}
LOG = logging.getLogger(__name__)
LOG.addHandler(logging.NullHandler())
LOG.propagate = False  # refused requests are not shown to the user


class Desk(Protocol):
    """Protocol: answers to the requests of a page."""

    @property
    def title(self) -> str:
        """Title of the page."""

    def answer(self, request: dict[str, Any]) -> dict[str, Any]:
        """Return the header of an answer with arrays; called in a thread of the server.

        ``request["page"]`` is the number of the requesting page.

        Raises
        ------
        JoustoError
            With the sentence that the page shows.
        """

    def page(self) -> bytes:
        """Return the self-contained page."""


class Server:
    """Server of the page of a desk until `close`.

    Parameters
    ----------
    desk : Desk
        Source of the answers.
    port : int
        Port of the server; 0 for any free port.

    Raises
    ------
    InputError
        If the port is taken, or the page was not built.
    """

    def __init__(self, desk: Desk, port: int = 0) -> None:
        self._desk, self._port = desk, port
        self._bundle = read_bundle()
        self._token = secrets.token_urlsafe(32)
        self._clients: set[_Client] = set()
        self._newest: bytes | None = None
        self._pages = 0
        # separate threads: slow requests must not block those of one instant
        self._threads = {slow: ThreadPoolExecutor(1, "jousto-viewer") for slow in (False, True)}
        self._loop = asyncio.new_event_loop()
        self._closed = threading.Event()
        self._end: Callable[[], None] = lambda: None
        started: list[BaseException | None] = []
        ready = threading.Event()
        thread = threading.Thread(target=self._run, args=(started, ready), daemon=True)
        thread.start()
        ready.wait()
        self._thread = thread
        if started:
            message = f"cannot be listened on: {started[0]}; choose another one, or 0 for any"
            raise InputError(Problem(f"port {port}", message))

    @property
    def port(self) -> int:
        """Port of the server."""
        return self._port

    @property
    def address(self) -> str:
        """Address of the page with the token; anyone with it can see the page."""
        return f"http://{HOST}:{self._port}/?token={self._token}"

    @property
    def running(self) -> bool:
        """Whether the server is open."""
        return not self._closed.is_set()

    def open(self) -> bool:
        """Open the page in the browser; return whether a browser exists."""
        return webbrowser.open(self.address)

    def push(self, data: bytes) -> None:
        """Send to all pages; a slow page gets the newest message only. Thread-safe."""
        if self.running:
            self._loop.call_soon_threadsafe(self._offer, data)

    def wait(self) -> None:
        """Wait until the server is closed; Ctrl-C closes it."""
        try:
            # an unlimited wait ignores Ctrl-C on Windows
            while not self._closed.wait(0.2):
                pass
        except KeyboardInterrupt:
            pass
        finally:
            self.close()

    def close(self) -> None:
        """Close the server; open pages keep their data. Further calls have no effect."""
        if not self._closed.is_set():
            self._closed.set()
            self._loop.call_soon_threadsafe(self._end)
        if threading.current_thread() is not self._thread:
            self._thread.join(5.0)

    # -- in the thread of the server --------------------------------------------------------

    def _run(self, started: list[BaseException | None], ready: threading.Event) -> None:
        asyncio.set_event_loop(self._loop)
        try:
            self._loop.run_until_complete(self._serve(ready))
        except OSError as error:
            started.append(error)
        finally:
            for threads in self._threads.values():
                threads.shutdown(wait=False, cancel_futures=True)
            self._loop.close()
            self._closed.set()
            ready.set()

    async def _serve(self, ready: threading.Event) -> None:
        ended = asyncio.Event()
        self._end = ended.set
        listening: Listening = await serve(
            self._talk,
            HOST,
            self._port,
            process_request=self._page,
            compression=None,
            max_size=LONGEST,
            max_queue=AT_ONCE,
            server_header=None,
            logger=LOG,
            close_timeout=1,
        )
        self._port = next(iter(listening.sockets)).getsockname()[1]
        ready.set()
        await ended.wait()
        listening.close()
        await listening.wait_closed()

    async def _page(self, connection: ServerConnection, request: Request) -> Response | None:
        """Return the response to a request for a file; None means to accept a WebSocket."""
        method = getattr(request, "method", "GET")  # websockets before version 16 accepts GET only
        if method != "GET":
            text = "" if method == "HEAD" else f"{method} is not allowed here, GET alone."
            return _response(HTTPStatus.METHOD_NOT_ALLOWED, text, more={"Allow": "GET"})
        refusal = self._refusal(request)
        path = urlsplit(request.path).path
        if refusal is not None:
            return _response(*refusal)
        if path == "/socket":
            if request.headers.get("Upgrade", "").lower() != "websocket":
                return _response(HTTPStatus.BAD_REQUEST, "This address is for the page alone.")
            if len(self._clients) >= CLIENTS:
                return _response(HTTPStatus.SERVICE_UNAVAILABLE, "Too many pages are open.")
            return None
        query = urlsplit(request.path).query
        if path in (f"/{JS}", f"/{CSS}"):
            kind = "text/javascript" if path == f"/{JS}" else "text/css"
            return _response(HTTPStatus.OK, self._bundle[path[1:]], f"{kind}; charset=utf-8")
        if path == "/":
            more = {"Content-Security-Policy": policy(f"ws://{request.headers['Host']}")}
            page = served_page(self._desk.title, query)
            return _response(HTTPStatus.OK, page, "text/html; charset=utf-8", more)
        if path == "/page.html":
            return await self._saved()
        return _response(HTTPStatus.NOT_FOUND, "There is nothing at this address.")

    def _refusal(self, request: Request) -> tuple[HTTPStatus, str] | None:
        """Return the reason to refuse a request; None means to accept it."""
        hosts = (f"{HOST}:{self._port}", f"localhost:{self._port}")
        given, origins = request.headers.get_all("Host"), request.headers.get_all("Origin")
        if len(given) != 1 or given[0] not in hosts:
            return HTTPStatus.FORBIDDEN, "This server answers to 127.0.0.1 and localhost alone."
        own = f"http://{given[0]}"
        socket = urlsplit(request.path).path == "/socket"
        if (origins and origins != [own]) or (socket and not origins):
            return HTTPStatus.FORBIDDEN, "This server answers to its own page alone."
        tokens = parse_qs(urlsplit(request.path).query).get("token", [""])
        if not secrets.compare_digest(tokens[0].encode(), self._token.encode()):
            return HTTPStatus.FORBIDDEN, (
                "The token in this address is missing or wrong: take the whole address that "
                "jousto printed."
            )
        return None

    async def _saved(self) -> Response:
        try:
            data = await self._loop.run_in_executor(self._threads[True], self._desk.page)
        except JoustoError as error:
            return _response(HTTPStatus.CONFLICT, str(error))
        except Exception as error:
            LOG.exception("a page could not be created")
            return _response(HTTPStatus.INTERNAL_SERVER_ERROR, unexpected(error))
        more = {"Content-Disposition": 'attachment; filename="jousto.html"'}
        return _response(HTTPStatus.OK, data, "text/html; charset=utf-8", more)

    async def _talk(self, connection: ServerConnection) -> None:
        self._pages += 1
        client = _Client(connection, self._answer, self._pages)
        self._clients.add(client)
        if self._newest is not None:
            client.offer(self._newest)
        try:
            await client.serve()
        finally:
            self._clients.discard(client)

    async def _answer(self, text: str | bytes, page: int) -> bytes | str:
        """Return the answer to a message of a page."""
        known: Any = None
        more: dict[str, Any] = {}
        try:
            request = _request(text) | {"page": page}
            known = request["id"]
            threads = self._threads[request.get("ask") in SLOW]
            return await self._loop.run_in_executor(threads, self._worked_out, request)
        except JoustoError as error:
            message = str(error)
            more = {"renewed": True} if isinstance(error, Renewed) else {}
        except Exception as error:
            LOG.exception("a request failed")
            message = unexpected(error)
        return json.dumps({"id": known, "kind": "error", "message": message, **more})

    def _worked_out(self, request: dict[str, Any]) -> bytes:
        return pack(self._desk.answer(request) | {"id": request["id"]})

    def _offer(self, data: bytes) -> None:
        self._newest = data
        for client in self._clients:
            client.offer(data)


class _Client:
    """One page: its requests in order, and the newest pushed message."""

    def __init__(
        self, connection: ServerConnection, answer: Callable[[str | bytes, int], Any], number: int
    ) -> None:
        self.connection, self.answer, self.number = connection, answer, number
        self.newest: bytes | None = None
        self.fresh = asyncio.Event()

    async def serve(self) -> None:
        """Answer requests until the page disconnects."""
        room = asyncio.Semaphore(AT_ONCE)
        tasks = {asyncio.ensure_future(self._pushed())}
        try:
            async for message in self.connection:
                # back-pressure: a page that does not read its answers gets no further ones
                await room.acquire()
                task = asyncio.ensure_future(self._reply(message, room))
                tasks.add(task)
                task.add_done_callback(tasks.discard)
        except ConnectionClosed:
            pass
        finally:
            for task in tuple(tasks):
                task.cancel()

    async def _reply(self, message: str | bytes, room: asyncio.Semaphore) -> None:
        try:
            await self.connection.send(await self.answer(message, self.number))
        except ConnectionClosed:
            pass
        finally:
            room.release()

    def offer(self, data: bytes) -> None:
        """Store the newest message for this page; an unsent older one is dropped."""
        self.newest = data
        self.fresh.set()

    async def _pushed(self) -> None:
        while True:
            await self.fresh.wait()
            self.fresh.clear()
            data, self.newest = self.newest, None
            if data is not None:
                try:
                    await self.connection.send(data)
                except ConnectionClosed:
                    return


def unexpected(error: BaseException) -> str:
    """Return a message for an unexpected exception."""
    return f"This failed unexpectedly ({type(error).__name__}: {error}); please report it."


def _request(text: str | bytes) -> dict[str, Any]:
    """Return the request in a message.

    Raises
    ------
    InputError
        If the text is not a request.
    """
    if isinstance(text, bytes):
        raise InputError(Problem("request", "is binary, must be JSON text"))
    try:
        found = json.loads(text, parse_constant=_no_number)
    except (ValueError, RecursionError) as error:
        raise InputError(Problem("request", f"is not JSON: {error}")) from None
    if not isinstance(found, dict):
        raise InputError(Problem("request", "must be a JSON object"))
    number = found.get("id")
    if isinstance(number, bool) or not isinstance(number, int):
        raise InputError(Problem("request", 'needs its number, such as "id": 1'))
    return found


def _no_number(text: str) -> Any:
    raise ValueError(f"{text} is not a number")


def _response(
    status: HTTPStatus,
    body: str | bytes,
    kind: str = "text/plain; charset=utf-8",
    more: dict[str, str] | None = None,
) -> Response:
    data = body.encode() if isinstance(body, str) else body
    headers = {"Content-Type": kind, "Content-Length": str(len(data)), "Connection": "close"}
    return Response(status.value, status.phrase, Headers({**headers, **SAFE, **(more or {})}), data)
