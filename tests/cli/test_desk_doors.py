"""Who is let in at the desk: pages of other origins are not, and one client shuts out no other."""

import http.client
import re
import resource
import urllib.parse
import urllib.request
from pathlib import Path

import pytest

from .test_desk import WEBSOCKET, answer, asked, ended, served


FOREIGN = ("http://evil.example", "http://127.0.0.1:1", "http://localhost", "null", "file://")


@pytest.fixture(scope="module")
def server(tmp_path_factory):
    """A desk that writes nothing about its requests; its process and its address."""
    process, address = served(tmp_path_factory.mktemp("desk"))
    try:
        yield process, address
    finally:
        _, errors = ended(process)
    assert errors == "pathgene: Serving until Ctrl-C.\n"


@pytest.fixture
def desk(server):
    """Address, port and cookie of a desk."""
    _, address = server
    port, token = re.search(r":(\d+)/\?token=(.*)", address).groups()
    return address, port, f"pathgene-desk-{port}={token}"


def polled(port, cookie, *, sid="", body=None, origin="", **query):
    """Return status, headers and body of a request of long polling."""
    fields = {"EIO": "4", "transport": "polling", **query, **({"sid": sid} if sid else {})}
    url = f"http://127.0.0.1:{port}/_nicegui_ws/socket.io/?{urllib.parse.urlencode(fields)}"
    headers = {"Cookie": cookie, **({"Origin": origin} if origin else {})}
    request = urllib.request.Request(url, data=body, headers=headers)
    try:
        with urllib.request.urlopen(request, timeout=30) as reply:
            return reply.status, dict(reply.headers), reply.read()
    except urllib.error.HTTPError as error:
        return error.code, dict(error.headers), error.read()


def opened(port, cookie):
    """Fetch the page and open it, as a browser does; return whether the desk let it in."""
    page = answer(f"http://127.0.0.1:{port}/", {"Cookie": cookie}.items())[2].decode()
    if "Too many tabs" in page:
        return False
    own = re.search(r"client_id.{1,12}?([0-9a-f-]{36})", page)[1]
    tab = {"client_id": own, "tab_id": own, "document_id": own, "next_message_id": "0"}
    query = {**tab, "implicit_handshake": "true"}
    status, _, body = polled(port, cookie, **query)
    assert status == 200
    sid = re.search(rb'"sid":"(.*?)"', body)[1].decode()
    assert polled(port, cookie, sid=sid, body=b"40", **query)[2] == b"OK"
    # The first packet says that the page is known.
    assert polled(port, cookie, sid=sid, **query)[2].startswith(b"40{")
    return True


@pytest.mark.parametrize("origin", FOREIGN)
def test_pages_of_other_origins_are_refused(desk, origin):
    address, port, cookie = desk
    client, reply = asked(port, *WEBSOCKET, f"Cookie: {cookie}", f"Origin: {origin}")
    client.close()
    assert reply.startswith("HTTP/1.1 403 ")
    for url in (address, f"http://127.0.0.1:{port}/"):
        status, headers, _ = answer(url, {"Cookie": cookie, "Origin": origin}.items())
        assert status == 403
        assert not [name for name in headers if name.lower().startswith("access-control")]
    status, headers, body = polled(port, cookie, origin=origin)
    assert (status, body.count(b"sid")) == (403, 0)
    assert not [name for name in headers if name.lower().startswith("access-control")]


def test_its_own_page_is_let_in_and_no_origin_is_echoed(desk):
    address, port, cookie = desk
    origin = f"http://127.0.0.1:{port}"
    for status, headers, _ in (
        answer(address, {"Origin": origin}.items()),
        polled(port, cookie, origin=origin),
        polled(port, cookie),
    ):
        assert status == 200
        assert not [name for name in headers if name.lower().startswith("access-control")]
    # The helper sends the host "desk".
    client, reply = asked(port, *WEBSOCKET, f"Cookie: {cookie}", "Origin: http://desk")
    client.close()
    assert reply.startswith("HTTP/1.1 101 ")


def test_many_fast_requests_shut_nobody_out(desk):
    address, port, cookie = desk
    for _ in range(40):
        assert b"Too many tabs" not in answer(address)[2]
    assert opened(port, f"{cookie}; pathgene-desk-{port}-browser=somebody")


def test_the_tabs_of_a_browser_are_its_own_limit(desk):
    _, port, cookie = desk
    one, other = (f"{cookie}; pathgene-desk-{port}-browser={name}" for name in "ab")
    assert [opened(port, one) for _ in range(34)] == [True] * 32 + [False] * 2
    assert opened(port, other)


def memory_bytes(process):
    """Return the memory of a process that is its own."""
    pages = Path(f"/proc/{process.pid}/statm").read_text().split()[1]
    return int(pages) * resource.getpagesize()


def test_missing_pages_are_refused_in_a_line_and_kept_nowhere(server, desk):
    """A flood of them fills no memory, and the desk answers other clients meanwhile."""
    _, port, cookie = desk
    client = http.client.HTTPConnection("127.0.0.1", int(port), timeout=60)
    sizes = []
    for number in range(300):
        client.request("GET", f"/missing/{number}", headers={"Cookie": cookie})
        reply = client.getresponse()
        text = reply.read()
        assert (reply.status, reply.getheader("Content-Type")) == (404, "text/plain; charset=utf-8")
        assert text == b"No such page; the desk has one, at /.\n"
        if number % 150 == 149:
            sizes.append(memory_bytes(server[0]))
            assert opened(port, f"{cookie}; pathgene-desk-{port}-browser=somebody")
    client.close()
    assert sizes[1] - sizes[0] < 4e6
