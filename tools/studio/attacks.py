"""What must not work: attackers, and guests who want the wheel."""

import json
import socket

from .page import Server, expect


def talk(port, lines, wait=3.0):
    """Sends a raw request and returns the first line of the answer."""
    with socket.create_connection(("127.0.0.1", port), timeout=wait) as link:
        link.sendall("\r\n".join([*lines, "", ""]).encode())
        answer = b""
        while b"\r\n" not in answer:
            part = link.recv(4096)
            if not part:
                break
            answer += part
    return answer.split(b"\r\n")[0].decode()


def attack(server):
    """Everything that must not work, and what must."""
    port, token, host = server.port, server.token, f"Host: 127.0.0.1:{server.port}"
    upgrade = ["Connection: Upgrade", "Upgrade: websocket", "Sec-WebSocket-Version: 13",
               "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ=="]
    own = f"Origin: http://127.0.0.1:{port}"
    live = f"GET /{token}/live HTTP/1.1"
    trials = [
        ("the page with its token", [f"GET /{token}/ HTTP/1.1", host], "200"),
        ("a socket from the page", [live, host, own, *upgrade], "101"),
        ("no token", ["GET / HTTP/1.1", host], "403"),
        ("a wrong token", [f"GET /{'0' * 32}/ HTTP/1.1", host], "403"),
        ("a token with a wrong end", [f"GET /{token[:-1]}/ HTTP/1.1", host], "403"),
        ("DNS rebinding", [f"GET /{token}/ HTTP/1.1", "Host: evil.example"], "421"),
        ("a name that looks local", [f"GET /{token}/ HTTP/1.1", "Host: localhost.evil.example"], "421"),
        ("no host", [f"GET /{token}/ HTTP/1.0"], "421"),
        ("a socket of another page", [live, host, "Origin: http://evil.example", *upgrade], "403"),
        ("a socket of another port", [live, host, "Origin: http://127.0.0.1:1", *upgrade], "403"),
        ("a socket of nowhere", [live, host, "Origin: null", *upgrade], "403"),
        ("a socket without origin", [live, host, *upgrade], "403"),
        ("a socket without token", ["GET /live HTTP/1.1", host, own, *upgrade], "403"),
        ("a request of another page", [f"GET /{token}/world.json HTTP/1.1", host, "Sec-Fetch-Site: cross-site"], "403"),
        ("a file above", [f"GET /{token}/../../etc/passwd HTTP/1.1", host], "404"),
        ("a file above, disguised", [f"GET /{token}/%2e%2e%2f%2e%2e%2fetc%2fpasswd HTTP/1.1", host], "404"),
        ("a drawing that is a path", [f"GET /{token}/draw/..%2f..%2frun.json HTTP/1.1", host], "404"),
        ("the kept token", [f"GET /{token}/studio.token HTTP/1.1", host], "404"),
        ("writing", [f"POST /{token}/ HTTP/1.1", host, "Content-Length: 0"], "405"),
        ("deleting", [f"DELETE /{token}/ HTTP/1.1", host], "405"),
    ]
    for what, lines, wanted in trials:
        status = (talk(port, lines).split() + ["", "nothing"])[1]
        expect(status == wanted, f"{what}: {status}, not {wanted}")
    return len(trials)


def abroad(program, scratch):
    """On another address than this machine's own the studio warns, and still wants its token."""
    with open(scratch / "warning.txt", "w+") as said:
        server = Server(program, None, extra=["--bind", "0.0.0.0", "--out", str(scratch / "abroad")], stderr=said)
        try:
            host = f"Host: 127.0.0.1:{server.port}"
            for what, path, wanted in (("no token", "/", "403"), ("the token", f"/{server.token}/", "200")):
                status = talk(server.port, [f"GET {path} HTTP/1.1", host]).split()[1]
                expect(status == wanted, f"abroad, {what}: {status}, not {wanted}")
        finally:
            server.end()
        said.seek(0)
        words = said.read()
    expect("0.0.0.0" in words and "token" in words, f"it warns: {words!r}")


class Wire:
    """A WebSocket by hand, for a page that misbehaves."""

    def __init__(self, server):
        self.link = socket.create_connection(("127.0.0.1", server.port), timeout=5)
        host = f"127.0.0.1:{server.port}"
        lines = [f"GET /{server.token}/live HTTP/1.1", f"Host: {host}", f"Origin: http://{host}", "Connection: Upgrade",
                 "Upgrade: websocket", "Sec-WebSocket-Version: 13", "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==", "", ""]
        self.link.sendall("\r\n".join(lines).encode())
        self.buffer = b""
        while b"\r\n\r\n" not in self.buffer:
            self.buffer += self.link.recv(4096)
        self.buffer = self.buffer.split(b"\r\n\r\n", 1)[1]

    def send(self, text):
        body = text.encode()
        size = bytes([0x80 | len(body)]) if len(body) < 126 else bytes([0xFE]) + len(body).to_bytes(2, "big")
        self.link.sendall(b"\x81" + size + b"\0\0\0\0" + body)

    def take(self, count):
        while len(self.buffer) < count:
            part = self.link.recv(65536)
            if not part:
                raise ConnectionError("closed")
            self.buffer += part
        part, self.buffer = self.buffer[:count], self.buffer[count:]
        return part

    def hear(self, kind, messages=200):
        """The next message of this kind."""
        for _ in range(messages):
            code, size = self.take(2)
            if size > 125:
                size = int.from_bytes(self.take(2 if size == 126 else 8), "big")
            body = self.take(size)
            news = json.loads(body) if code == 0x81 else {}
            if kind in news:
                return news[kind]
            if code == 0x88:
                raise ConnectionError("closed")
        raise RuntimeError(f"no {kind} among {messages} messages")


def share(page, server):
    """A second page watches; only the holder of the wheel drives; nonsense is refused and hurts nobody."""
    guest = Wire(server)
    name = guest.hear("hello")["you"]
    while guest.hear("status")["pages"] != 2:
        pass
    guest.send('{"do":"pause"}')
    expect("watching" in guest.hear("refused"), "a guest cannot drive")
    for nonsense in ("", "{", '{"do":"rm -rf /"}', '{"do":"recall","decision":-1}', '{"do":"press","action":99}'):
        guest.send(nonsense)
        expect(guest.hear("refused"), f"{nonsense!r} is refused")
    guest.send('{"do":"recall","decision":999999999}')
    expect(guest.hear("past") is None, "there is no such decision")
    page.click("#wheel")
    page.until("document.getElementById('wheel').textContent.startsWith('Take')", "the wheel is let go")
    guest.send('{"do":"take_wheel"}')
    while guest.hear("status")["wheel"] != name:
        pass
    page.until("document.getElementById('wheel').textContent === 'Watching'", "the page sees that it only watches")
    guest.send('{"do":"place","body":0,"x":1e300,"y":0}')
    while not guest.hear("status")["notice"]:
        pass
    guest.send("x" * 5000)
    try:
        guest.hear("never", 10_000)
        expect(False, "a request of 5000 bytes is too long")
    except (ConnectionError, TimeoutError):
        pass
    page.until("document.getElementById('wheel').textContent.startsWith('Take')", "a wheel without holder is free")
    page.click("#wheel")
    page.until("document.getElementById('wheel').textContent.startsWith('You')", "and can be taken")
