"""The desk from the command line: its address, its token, its end."""

import contextlib
import json
import os
import re
import signal
import socket
import subprocess
import sys
import time
import urllib.error
import urllib.request
from pathlib import Path

import pytest

from pathgene.host.cli import main
from tests.support.host.processes import Started


ROOT = Path(__file__).resolve().parents[2]


def served(tmp_path, *arguments, **variables):
    """Start a desk in a folder; return it once it answers, and its address."""
    # NiceGUI behaves differently within pytest.
    environment = {key: value for key, value in os.environ.items() if "PYTEST" not in key}
    environment |= {"PYTHONPATH": str(ROOT), **variables}
    command = [sys.executable, "-m", "pathgene", "desk", *arguments]
    desk = Started(
        command,
        cwd=tmp_path,
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    return desk, desk.stdout.readline().strip()


def ended(desk, number=signal.SIGINT):
    desk.send_signal(number)
    try:
        _, errors = desk.communicate(timeout=60)
    finally:
        desk.kill()
    return desk.returncode, errors


def answer(url, headers=()):
    request = urllib.request.Request(url, headers=dict(headers))
    try:
        with urllib.request.urlopen(request) as reply:
            return reply.status, reply.headers, reply.read()
    except urllib.error.HTTPError as error:
        return error.code, error.headers, error.read()


def is_closed(client, timeout_s):
    """Wait until the far end closes a connection; unread bytes reset it."""
    client.settimeout(timeout_s)
    try:
        while client.recv(4096):
            pass
    except ConnectionResetError:
        return True
    except TimeoutError:
        return False
    return True


#: It writes its arguments to a file, prints much more, and keeps running.
BROWSER = """#!/bin/sh
echo noise
echo noise >&2
echo $$ "$*" > opened.part
mv opened.part opened
exec sleep 100
"""


@pytest.fixture
def browser(tmp_path, monkeypatch):
    """Command of a browser that writes the file ``opened``; there is no screen."""
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    program = tmp_path / "browser"
    program.write_text(BROWSER)
    program.chmod(0o755)
    return f"{program} %s"


def test_a_desk_answers_to_its_token_and_ends_at_a_signal(tmp_path, browser):
    """Without a screen, ``--open`` opens nothing."""
    desk, address = served(tmp_path, "--open", BROWSER=browser)
    try:
        base, token = re.fullmatch(
            r"(http://127\.0\.0\.1:\d+/)\?token=([\w-]{32})", address
        ).groups()
        status, headers, page = answer(address)
        assert status == 200
        assert b"pathgene desk" in page
        # The page loads nothing from elsewhere.
        assert re.findall(rb"(?:src|href)=\"https?://", page) == []
        cookies = [each.partition(";")[0] for each in headers.get_all("set-cookie")]
        (cookie,) = (each for each in cookies if each.endswith(token))
        assert answer(base)[0] == 403
        assert answer(f"{base}?token={token[:-1]}")[0] == 403
        assert answer(base, {"Cookie": cookie}.items())[0] == 200
        for path in (
            "plans/../x/path.kml",
            "plans/x/summary.json",
            "plans/%2e%2e/passwd",
            "meshes/x",
        ):
            assert answer(base + path, {"Cookie": cookie}.items())[0] == 404, path
    finally:
        status, errors = ended(desk)
    assert status == 128 + signal.SIGINT
    assert errors == "pathgene: Serving until Ctrl-C.\n"
    assert (tmp_path / "out" / "desk").is_dir()
    assert not (tmp_path / ".nicegui").exists()
    assert not (tmp_path / "opened").exists()


@pytest.mark.parametrize(
    "screen", ["DISPLAY", pytest.param("WAYLAND_DISPLAY", marks=pytest.mark.ci)]
)
def test_open_opens_the_page_where_there_is_a_screen(tmp_path, browser, screen):
    desk, address = served(tmp_path, "--open", BROWSER=browser, **{screen: ":7"})
    opened = tmp_path / "opened"
    try:
        deadline = time.monotonic() + 60
        while not opened.exists() and time.monotonic() < deadline:
            time.sleep(0.05)
    finally:
        status, errors = ended(desk)
    assert status == 128 + signal.SIGINT
    assert errors == "pathgene: Serving until Ctrl-C.\n"
    assert re.fullmatch(r"http://127\.0\.0\.1:\d+/\?token=[\w-]{32}", address)
    number, url = opened.read_text().split()
    assert url == address
    # The browser keeps running after the desk has ended.
    os.kill(int(number), signal.SIGKILL)


def test_make_desk_opens_the_page():
    recipes = subprocess.run(
        ["make", "-n", "desk"], cwd=ROOT, capture_output=True, text=True, check=True
    ).stdout
    assert "desk --open --out " in recipes


@pytest.mark.ci
def test_clients_that_ask_for_nothing_stop_nobody(tmp_path):
    desk, address = served(tmp_path)
    port = int(re.search(r":(\d+)/", address)[1])
    with contextlib.ExitStack() as stack:
        stack.callback(ended, desk)
        begun = time.monotonic()
        assert answer(address)[0] == 200
        usual_s = time.monotonic() - begun
        first = stack.enter_context(socket.create_connection(("127.0.0.1", port)))
        first.sendall(b"GET / HTTP/1.1\r\nHost: desk\r\n")
        clients = [
            stack.enter_context(socket.create_connection(("127.0.0.1", port))) for _ in range(300)
        ]
        begun = time.monotonic()
        assert answer(address)[0] == 200
        assert time.monotonic() - begun < usual_s + 1
        # The oldest connections are closed immediately, the rest after a while.
        assert is_closed(first, 5)
        assert is_closed(clients[-1], 20)
        assert time.monotonic() - begun > 5
        assert answer(address)[0] == 200


def asked(port, *lines):
    """Send a request on a new connection, and read the immediate part of the answer."""
    client = socket.create_connection(("127.0.0.1", port))
    client.settimeout(20)
    client.sendall("\r\n".join([*lines, "Host: desk", "", ""]).encode())
    # Frames of a WebSocket, which are not text, may follow immediately.
    return client, client.recv(4096).decode("latin-1")


WEBSOCKET = (
    "GET /_nicegui_ws/socket.io/?EIO=4&transport=websocket HTTP/1.1",
    "Connection: Upgrade",
    "Upgrade: websocket",
    "Sec-WebSocket-Version: 13",
    "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==",
)


@pytest.mark.long
def test_clients_that_have_asked_stop_nobody_afterwards(tmp_path):
    desk, address = served(tmp_path)
    port, token = re.search(r":(\d+)/\?token=(.*)", address).groups()
    cookie = f"Cookie: pathgene-desk-{port}={token}"
    with contextlib.ExitStack() as stack:
        stack.callback(ended, desk)
        begun = time.monotonic()
        assert answer(address)[0] == 200
        usual_s = time.monotonic() - begun
        # Refused, each is closed.
        for lines in (("GET / HTTP/1.1",), WEBSOCKET):
            client, reply = asked(port, *lines)
            stack.enter_context(client)
            assert reply.startswith("HTTP/1.1 403 ")
            assert is_closed(client, 2)
        tab, reply = asked(port, *WEBSOCKET, cookie)
        stack.enter_context(tab)
        assert reply.startswith("HTTP/1.1 101 ")
        # After its answer, each begins another request, as if it were not idle.
        clients = []
        for _ in range(300):
            client, reply = asked(port, "GET /meshes/x HTTP/1.1", cookie)
            clients.append(stack.enter_context(client))
            assert reply.startswith("HTTP/1.1 404 ")
            client.sendall(b"G")
        begun = time.monotonic()
        assert answer(address)[0] == 200
        assert time.monotonic() - begun < usual_s + 1
        assert is_closed(clients[0], 5)
        assert is_closed(clients[-1], 20)
        assert time.monotonic() - begun > 5
        # The page of a tab is not among them: it answers a ping.
        tab.sendall(b"\x89\x80" + bytes(4))
        frames = b""
        while b"\x8a\x00" not in frames:
            part = tab.recv(4096)
            assert part
            frames += part


def test_beyond_this_machine_it_warns_and_open_needs_no_browser(tmp_path):
    no_browser = {"DISPLAY": ":7", "PATH": str(tmp_path), "BROWSER": "none"}
    desk, text = served(tmp_path, "--open", "--host", "0.0.0.0", "--json", **no_browser)
    try:
        for _ in range(3):
            text += desk.stdout.readline()
        assert answer(json.loads(text)["url"])[0] == 200
        assert json.loads(text)["url"].startswith("http://0.0.0.0:")
        assert json.loads(text)["pid"] == desk.pid
    finally:
        status, errors = ended(desk, signal.SIGTERM)
    assert status == 128 + signal.SIGTERM
    assert errors == (
        "pathgene: Anybody who reaches 0.0.0.0 and knows this address can plan here and read the "
        "saved plans; nothing is encrypted.\n"
        "pathgene: Serving until Ctrl-C.\n"
    )


def test_bad_arguments_are_one_sentence(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "bad.toml").write_text("[mission]\nstart = 3\n")
    with socket.create_server(("127.0.0.1", 0)) as other:
        taken = str(other.getsockname()[1])
        for arguments, sentence in (
            (["--port", "70000"], "The port must be from 0 to 65535, not 70000."),
            (["--host", "no.such.host.invalid"], "There is no address 'no.such.host.invalid' ("),
            (
                ["--host", "x" * 64 + ".de"],
                f"There is no address '{'x' * 64}.de' (a part of it is empty or over 63 letters",
            ),
            (["--jobs", "0"], "The desk must do 1 job at a time or more, not 0 (--jobs)."),
            (
                ["--port", taken],
                f"Nothing can listen at 127.0.0.1:{taken} (Address already in use)",
            ),
            (["none.toml"], "Cannot read the problem 'none.toml' (No such file or directory)."),
            (["bad.toml"], "bad.toml: start in [mission] must be a list of three numbers, not 3."),
            (["--max-cells", "0"], "A terrain must be allowed 1 cell or more, not 0."),
            (["--out", "bad.toml"], "Cannot write to the directory 'bad.toml' ("),
        ):
            assert main(["desk", *arguments]) == 2, arguments
            error = capsys.readouterr().err
            assert error.startswith(f"pathgene: {sentence}"), arguments
            assert error.count("\n") == 1


@pytest.mark.parametrize("name", ["nicegui", "uvicorn"])
def test_without_the_extra_it_says_what_to_install(name, capsys, monkeypatch, tmp_path):
    for module in [each for each in sys.modules if each.startswith("pathgene.host.web.desk.s")]:
        monkeypatch.delitem(sys.modules, module)
    monkeypatch.setitem(sys.modules, name, None)
    monkeypatch.chdir(tmp_path)
    assert main(["desk"]) == 2
    assert capsys.readouterr().err == (
        "pathgene: The desk needs the extra pathgene[desk]: pip install 'pathgene[desk]'.\n"
    )
