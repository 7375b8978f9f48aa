"""The server of the page: who gets an answer, who a sentence, and that it stays alive."""

from __future__ import annotations

import http.client
import json
import socket
import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any
from urllib.parse import parse_qs, urlsplit

import numpy as np
import pytest
from websockets.exceptions import ConnectionClosed, ConnectionClosedError, InvalidStatus
from websockets.sync.client import ClientConnection, connect

from jousto.base.errors import InputError, Problem
from jousto.viewer import bundle
from jousto.viewer.container import pack, unpack
from jousto.viewer.server import AT_ONCE, LONGEST, Server


class Echo:
    """A desk that says what it was asked, after waiting or failing where it was told to."""

    title = "an <b>arm</b>"

    def __init__(self) -> None:
        self.seen: list[dict[str, Any]] = []

    def answer(self, request: dict[str, Any]) -> dict[str, Any]:
        self.seen.append(request)
        if request.get("ask") == "sentence":
            raise InputError(Problem("probe", "there is no such vertex"))
        if request.get("ask") == "bug":
            raise KeyError("a bug")
        if request.get("ask") == "worst":
            time.sleep(0.5)
        return {"kind": "echo", "block": np.zeros(int(request.get("size", 1)))}

    def page(self) -> bytes:
        return b"<!DOCTYPE html>saved"


@pytest.fixture
def built(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "viewer.js").write_text("let a = 1;")
    (tmp_path / "viewer.css").write_text("body {}")
    (tmp_path.parent / "secret.txt").write_text("a secret")
    monkeypatch.setattr(bundle, "FOLDER", tmp_path)


@pytest.fixture
def server(built: None) -> Iterator[Server]:
    with_desk = Server(Echo())
    yield with_desk
    assert talk(with_desk, {"ask": "scene"})["kind"] == "echo"  # it is alive after every test
    with_desk.close()
    assert not with_desk.running


def get(server: Server, path: str, **headers: str) -> http.client.HTTPResponse:
    link = http.client.HTTPConnection("127.0.0.1", server.port, timeout=60)
    link.request("GET", path, headers=headers)
    found = link.getresponse()
    found.body = found.read().decode()  # type: ignore[attr-defined]
    link.close()
    return found


def token(server: Server) -> str:
    return parse_qs(urlsplit(server.address).query)["token"][0]


def join(server: Server, **changes: Any) -> ClientConnection:
    given = {"origin": f"http://127.0.0.1:{server.port}", "max_size": None} | changes
    word = given.pop("token", token(server))
    return connect(f"ws://127.0.0.1:{server.port}/socket?token={word}", **given)


def ask(page: ClientConnection, text: str | bytes | dict[str, Any]) -> dict[str, Any]:
    page.send(json.dumps({"id": 1} | text) if isinstance(text, dict) else text)
    while True:
        answer = page.recv(timeout=60)
        found = unpack(answer) if isinstance(answer, bytes) else json.loads(answer)
        if found["kind"] != "live":  # a state that was pushed
            return dict(found)


def talk(server: Server, request: dict[str, Any]) -> dict[str, Any]:
    with join(server) as page:
        return ask(page, request)


# -- what is served -------------------------------------------------------------------------


def test_it_listens_on_this_computer_alone(server: Server) -> None:
    assert server.address.startswith("http://127.0.0.1:")
    own = socket.gethostbyname(socket.gethostname())
    if not own.startswith("127."):
        with pytest.raises(OSError):
            socket.create_connection((own, server.port), timeout=2)


def test_page_script_and_style_need_the_token_and_have_a_policy(server: Server) -> None:
    word = token(server)
    page = get(server, f"/?token={word}")
    policy = str(page.getheader("Content-Security-Policy"))
    assert page.status == 200
    assert "default-src 'none'" in policy and "unsafe" not in policy
    assert f"connect-src 'self' ws://127.0.0.1:{server.port}" in policy
    assert "an &lt;b&gt;arm" in page.body and "<b>arm" not in page.body  # type: ignore[attr-defined]
    assert f'src="viewer.js?token={word}"' in page.body  # type: ignore[attr-defined]
    script = get(server, f"/viewer.js?token={word}")
    assert script.body == "let a = 1;"  # type: ignore[attr-defined]
    assert script.getheader("X-Content-Type-Options") == "nosniff"
    assert "javascript" in str(script.getheader("Content-Type"))
    assert get(server, f"/viewer.css?token={word}").body == "body {}"  # type: ignore[attr-defined]
    saved = get(server, f"/page.html?token={word}")
    assert saved.body.endswith("saved")  # type: ignore[attr-defined]
    assert "attachment" in str(saved.getheader("Content-Disposition"))


@pytest.mark.parametrize("path", ["/", "/viewer.js", "/viewer.css", "/page.html", "/socket", "/x"])
@pytest.mark.parametrize("query", ["", "?token=", "?token=wrong", "?token=%C3%A4", "?other=1"])
def test_without_the_token_nothing_is_served(server: Server, path: str, query: str) -> None:
    found = get(server, path + query)
    assert found.status == 403
    assert "token" in found.body or "own page" in found.body  # type: ignore[attr-defined]


@pytest.mark.parametrize(
    "path",
    [
        *("/../secret.txt", "/..%2fsecret.txt", "/%2e%2e/secret.txt", "//secret.txt"),
        *("/viewer.js/../../secret.txt", "/page/viewer.js", "/C:/secret.txt", "/viewer.js%00"),
        "/etc/passwd",
    ],
)
def test_no_other_file_is_served(server: Server, path: str) -> None:
    found = get(server, f"{path}?token={token(server)}")
    assert found.status in (403, 404)
    assert "secret" not in found.body  # type: ignore[attr-defined]


@pytest.mark.parametrize("host", ["evil.example", "evil.example:80", "127.0.0.1", "0.0.0.0:{}"])
def test_another_host_name_is_refused(server: Server, host: str) -> None:
    # a page whose name is made to point here (DNS rebinding) has its own name in Host
    found = get(server, f"/?token={token(server)}", Host=host.format(server.port))
    assert found.status == 403 and "127.0.0.1" in found.body  # type: ignore[attr-defined]


def test_the_page_of_another_origin_is_refused(server: Server) -> None:
    for origin in ("http://evil.example", "null", f"http://127.0.0.1:{server.port + 1}", None):
        with pytest.raises(InvalidStatus) as refused:
            join(server, origin=origin)
        assert refused.value.response.status_code == 403
    found = get(server, f"/?token={token(server)}", Origin="http://evil.example")
    assert found.status == 403


def test_a_wrong_token_does_not_connect(server: Server) -> None:
    for word in ("", "wrong", token(server)[:-1], token(server) + "x"):
        with pytest.raises(InvalidStatus) as refused:
            join(server, token=word)
        assert refused.value.response.status_code == 403


def test_tokens_differ(built: None) -> None:
    servers = [Server(Echo()) for _ in range(2)]
    words = [token(one) for one in servers]
    for one in servers:
        one.close()
    assert words[0] != words[1] and min(map(len, words)) >= 32


@pytest.mark.parametrize("method", ["POST", "PUT", "DELETE", "TRACE", "HEAD", "OPTIONS", "PATCH"])
def test_methods_other_than_get_are_not_allowed(server: Server, method: str) -> None:
    """RFC 9110: 405 with the methods that are; TRACE would show the token to other pages."""
    for path in ("/", "/socket", "/page.html", "/viewer.js"):
        link = http.client.HTTPConnection("127.0.0.1", server.port, timeout=60)
        link.request(method, f"{path}?token={token(server)}")
        found = link.getresponse()
        said = found.read().decode()
        link.close()
        assert (found.status, found.getheader("Allow")) == (405, "GET")
        assert "token" not in said and (method == "HEAD") == (said == "")


def test_other_methods_and_garbage_do_not_hurt(server: Server) -> None:
    for data in (b"POST / HTTP/1.1\r\nHost: x\r\n\r\n", b"\x16\x03\x01\x02", b"GET\r\n\r\n"):
        with socket.create_connection(("127.0.0.1", server.port), timeout=60) as line:
            line.sendall(data)
            line.shutdown(socket.SHUT_WR)
            assert b"200" not in line.recv(1000)
    plain = get(server, f"/socket?token={token(server)}", Origin=f"http://127.0.0.1:{server.port}")
    assert plain.status == 400


# -- requests -------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("message", "said"),
    [
        ("{", "is not JSON"),
        ("", "is not JSON"),
        ("[" * 100_000, "is not JSON"),
        ('{"id": 1, "ask": "rows", "first": NaN}', "NaN is not a number"),
        ("[1, 2]", "must be a JSON object"),
        ('"text"', "must be a JSON object"),
        ("{}", "needs its number"),
        ('{"id": "one", "ask": "scene"}', "needs its number"),
        ('{"id": true, "ask": "scene"}', "needs its number"),
        (b"\x00\x01", "is binary"),
        ("9" * 100_000, "is not JSON"),
    ],
)
def test_what_is_no_request_gets_a_sentence(server: Server, message: str, said: str) -> None:
    with join(server) as page:
        answer = ask(page, message)
        assert answer["kind"] == "error" and said in answer["message"]
        assert "Traceback" not in answer["message"]
        assert ask(page, {"id": 5, "ask": "scene"})["id"] == 5  # the same page goes on


def test_an_error_of_the_desk_is_a_sentence(server: Server) -> None:
    with join(server) as page:
        answer = ask(page, {"id": 7, "ask": "sentence"})
        assert answer == {"id": 7, "kind": "error", "message": "probe: there is no such vertex"}
        answer = ask(page, {"id": 8, "ask": "bug"})
        assert answer["id"] == 8 and "unexpectedly (KeyError" in answer["message"]


def test_a_huge_message_ends_its_page_alone(server: Server) -> None:
    with join(server) as other, join(server) as page:
        page.send("x" * (LONGEST + 1))
        with pytest.raises(ConnectionClosedError, match="too big"):
            page.recv(timeout=60)
        assert ask(other, {"ask": "scene"})["kind"] == "echo"


def test_a_slow_answer_does_not_hold_up_the_others(server: Server) -> None:
    with join(server) as page:
        page.send(json.dumps({"id": 1, "ask": "worst"}))
        page.send(json.dumps({"id": 2, "ask": "rows"}))
        assert [unpack(page.recv(timeout=60))["id"] for _ in range(2)] == [2, 1]  # type: ignore[arg-type]


def test_a_page_that_does_not_read_gets_no_more(server: Server) -> None:
    desk = server._desk
    assert isinstance(desk, Echo)
    with join(server, max_queue=1, close_timeout=0.2) as lazy:
        for k in range(60):  # answers of 8 MB each
            lazy.send(json.dumps({"id": k, "ask": "rows", "size": 1_000_000}))
        time.sleep(1.0)
        done = sum(request.get("size") == 1_000_000 for request in desk.seen)
        # those worked on, and what the buffers of the sockets and of this client contain
        assert done <= AT_ONCE + 4
        with join(server) as other:
            assert ask(other, {"ask": "scene"})["kind"] == "echo"


def test_pushes_reach_all_pages_and_a_slow_one_gets_the_newest(server: Server) -> None:
    lazily = {"max_queue": 1, "close_timeout": 0.2}
    with join(server, **lazily) as page, join(server, **lazily) as lazy:
        ask(page, {"ask": "scene"}), ask(lazy, {"ask": "scene"})
        block = np.zeros(1_000_000)
        last = 40
        for k in range(last + 1):
            server.push(pack({"kind": "live", "number": k, "block": block}))
            if k == 0:
                assert unpack(page.recv(timeout=60))["number"] == 0  # type: ignore[arg-type]
            time.sleep(0.01)
        got = []
        while not got or got[-1] != last:
            got.append(unpack(lazy.recv(timeout=60))["number"])  # type: ignore[arg-type]
        assert got == sorted(got) and len(got) < last / 2


def test_who_connects_late_gets_the_newest_state(server: Server) -> None:
    server.push(pack({"kind": "live", "number": 3}))
    time.sleep(0.1)
    with join(server) as page:
        assert unpack(page.recv(timeout=60))["number"] == 3  # type: ignore[arg-type]


# -- start and end --------------------------------------------------------------------------


def test_several_pages_at_once(server: Server) -> None:
    with ExitStack() as open_pages:
        pages = [open_pages.enter_context(join(server)) for _ in range(8)]
        assert all(ask(page, {"ask": "scene"})["kind"] == "echo" for page in pages)


def test_closing_ends_the_pages_and_waiting(built: None) -> None:
    server = Server(Echo())
    with join(server) as page:
        waiting = threading.Thread(target=server.wait)
        waiting.start()
        server.close()
        server.close()
        waiting.join(60)
        assert not waiting.is_alive() and not server.running
        with pytest.raises(ConnectionClosed):
            page.recv(timeout=60)
    server.push(b"late")  # does nothing


def test_a_taken_port_is_an_error(server: Server) -> None:
    with pytest.raises(InputError, match=f"port {server.port}: cannot be listened on"):
        Server(Echo(), server.port)


def test_without_its_page_it_says_how_to_build_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(bundle, "FOLDER", tmp_path / "none")
    with pytest.raises(InputError, match="make page"):
        Server(Echo())
