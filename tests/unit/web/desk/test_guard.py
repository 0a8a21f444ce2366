"""Requests that reach the desk: with its token, and of limited size."""

import asyncio
from concurrent.futures import ThreadPoolExecutor

import pytest

from pathgene.host.web.desk.guard import Guard


TOKEN = "secret"


def call(*, path="/", query="", cookie=None, body=(), kind="http", length=None, most=5_000_000):
    """Return the status and headers of a request, and the bytes that the application has read."""
    read, sent = [], []

    async def behind(scope, receive, send):
        more = True
        while more:
            message = await receive()
            read.append(message)
            more = message.get("more_body", False)
        await send({"type": "http.response.start", "status": 200, "headers": []})
        await send({"type": "http.response.body", "body": b""})

    chunks = [
        {"type": "http.request", "body": each, "more_body": number + 1 < len(body)}
        for number, each in enumerate(body)
    ] or [{"type": "http.request", "body": b""}]

    async def receive():
        return chunks.pop(0)

    async def send(message):
        sent.append(message)

    headers = [] if cookie is None else [(b"cookie", cookie.encode())]
    headers += [] if length is None else [(b"content-length", str(length).encode())]
    scope = {"type": kind, "path": path, "query_string": query.encode(), "headers": headers}
    # The tests of pages leave a loop in this thread.
    with ThreadPoolExecutor(1) as pool:
        guard = Guard(behind, TOKEN, 80, most)
        pool.submit(lambda: asyncio.run(guard(scope, receive, send))).result()
    return sent, read


def status(sent):
    return sent[0]["status"]


@pytest.mark.parametrize(
    "given",
    [
        {},
        {"query": "token="},
        {"query": "token=wrong"},
        {"query": "token=secrets"},
        {"query": "token=s%C3%A9cret"},
        {"cookie": "pathgene-desk-80=wrong"},
        {"cookie": "pathgene-desk-81=secret"},
        {"cookie": ";;=\x7f"},
    ],
)
def test_without_the_token_nothing_is_passed_on(given):
    sent, read = call(**given)
    assert status(sent) == 403
    assert b"open the whole address" in sent[1]["body"]
    assert read == []
    closed, read = call(kind="websocket", **given)
    assert closed == [{"type": "websocket.close", "code": 1008}]
    assert read == []


def test_the_token_of_the_address_becomes_a_cookie():
    sent, read = call(query="a=b&token=secret")
    assert status(sent) == 200
    assert len(read) == 1
    headers = dict(sent[0]["headers"])
    cookie = headers[b"set-cookie"].decode()
    assert cookie == "pathgene-desk-80=secret; HttpOnly; SameSite=Strict; Path=/"
    assert b"default-src 'self'" in headers[b"content-security-policy"]
    assert headers[b"referrer-policy"] == b"no-referrer"
    later, _ = call(cookie="x=y; pathgene-desk-80=secret")
    assert status(later) == 200
    assert b"set-cookie" not in dict(later[0]["headers"])


def test_long_requests_are_refused_before_they_are_read():
    sent, read = call(query="token=secret", length=1_000_001)
    assert status(sent) == 413
    assert b"--max-cells" in sent[1]["body"]
    assert read == []
    assert status(call(query="token=secret", length=1_000_000)[0]) == 200
    assert status(call(query="token=secret", length="9" * 5000)[0]) == 413
    upload = {"path": "/_nicegui/client/1/upload/2", "query": "token=secret"}
    assert status(call(length=5_000_000, **upload)[0]) == 200
    assert status(call(length=5_000_001, **upload)[0]) == 413


def test_a_body_that_is_longer_than_it_states_ends_as_if_the_browser_had_left():
    _, read = call(query="token=secret", length=10, body=[b"x" * 600_000] * 3)
    assert [message["type"] for message in read] == ["http.request", "http.disconnect"]
