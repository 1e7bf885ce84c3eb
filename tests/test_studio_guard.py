"""The guard: a stranger's page can neither read a photo nor move a machine, whichever way it tries."""

from __future__ import annotations

import http.client

import httpx
import pytest
from websockets.exceptions import InvalidStatus

import studios
from limner.studio.app import build
from limner.studio.guard import CSP
from limner.studio.hub import Hub
from limner.studio.jobs import Jobs
from limner.studio.serve import names_of
from limner.studio.studio import Studio
from limner.studio.visitors import HeldPhoto, Visitors

TOKENS = {"visitor": "guest-token", "operator": "operator-token"}
SECRET = b"the photo itself"


class StillComputer:
    """Computes nothing; counts what it is asked."""

    def __init__(self):
        self.asked = []

    async def open(self):
        pass

    async def close(self):
        pass

    async def ask(self, name, urgency=0, /, **arguments):
        self.asked.append(name)
        return {}


def no_machine(order, file):
    raise AssertionError("a machine was to move")


class House:
    """A studio that is served, and where."""

    def __init__(self, host, folder):
        self.names, self.folder = names_of(host), folder

    def build(self, port):
        self.port = port
        jobs = Jobs(self.folder / "job", no_machine, lambda: None)
        self.studio = Studio(Visitors(port), StillComputer(), StillComputer(), {}, Hub(), jobs)
        return build(self.studio, TOKENS, self.names)

    @property
    def cookie(self):
        return f"limner_visitor_{self.port}"


@pytest.fixture(scope="module")
def house(tmp_path_factory):
    house = House("127.0.0.1", tmp_path_factory.mktemp("studio"))
    with studios.thread_serving(house.build) as house.base:
        yield house


@pytest.fixture
def client(house):
    with httpx.Client(base_url=house.base, follow_redirects=True, timeout=studios.PATIENCE_S) as client:
        yield client


@pytest.fixture
def inside(client, house):
    """A browser that has entered, and holds a photo."""
    client.get("/?token=guest-token")
    visitor = house.studio.visitors.known("visitor", client.cookies[house.cookie])
    visitor.photos.add("mine", HeldPhoto("mine", b"", SECRET, {}))
    assert client.get("/api/photo/mine.jpg").content == SECRET
    return client


def test_the_token_gives_a_cookie_that_scripts_and_other_sites_do_not_get(client):
    answer = client.get("/?token=guest-token&x=1", follow_redirects=False)
    assert answer.status_code == 303
    assert answer.headers["location"] == "/?x=1"
    cookie = answer.headers["set-cookie"].lower()
    assert "httponly" in cookie
    assert "samesite=strict" in cookie
    assert "guest-token" not in cookie


@pytest.mark.parametrize("token", ["", "wrong", "operator-token", "guest-toke", "guest-token-"])
def test_no_other_token_enters(client, token):
    assert client.get(f"/?token={token}").status_code == 401
    assert not client.cookies


def test_a_browser_that_comes_again_stays_who_it_was(inside):
    before = dict(inside.cookies)
    inside.get("/?token=guest-token")
    assert dict(inside.cookies) == before


PATHS = ["/", "/app.js", "/api/options", "/api/photo/mine.jpg", "/api/nothing", "/openapi.json"]


@pytest.mark.parametrize("path", PATHS)
def test_without_a_cookie_nothing_is_read(inside, path):
    inside.cookies.clear()
    answer = inside.get(path)
    assert answer.status_code == 401
    assert SECRET not in answer.content


@pytest.mark.parametrize("cookie", ["", "x", "limner", "\xe4", "a" * 5000])
def test_an_invented_cookie_is_none(house, client, cookie):
    answer = client.get("/api/options", headers={"cookie": f"{house.cookie}={cookie}".encode("latin-1")})
    assert answer.status_code == 401


ORIGINS = ["http://evil.example", "http://127.0.0.1:9", "https://127.0.0.1.evil.example:8765", "null", ""]


@pytest.mark.parametrize("origin", ORIGINS)
@pytest.mark.parametrize("path", PATHS)
def test_another_origin_reads_nothing_though_the_cookie_came_along(inside, path, origin):
    answer = inside.get(path, headers={"origin": origin})
    assert answer.status_code == 403
    assert SECRET not in answer.content
    assert not any(name.startswith("access-control") for name in answer.headers)


@pytest.mark.parametrize("site", ["cross-site", "same-site"])
def test_a_picture_within_another_page_is_refused(inside, site):
    """An <img> sends no Origin; other ports of this host count as the same site and bring the cookie."""
    answer = inside.get("/api/photo/mine.jpg", headers={"sec-fetch-site": site})
    assert answer.status_code == 403


@pytest.mark.parametrize("host", ["evil.example:8765", "localhost.evil.example", "127.0.0.1.nip.io", "192.168.0.7", ""])
def test_another_name_for_this_address_is_refused(inside, host):
    answer = inside.get("/api/photo/mine.jpg", headers={"host": host})
    assert answer.status_code == 400
    assert SECRET not in answer.content


@pytest.mark.parametrize("host", ["127.0.0.1:8765", "localhost:8765", "LOCALHOST", "[::1]:8765"])
def test_its_own_names_are_known(inside, host):
    assert inside.get("/api/photo/mine.jpg", headers={"host": host}).status_code == 200


def test_listening_to_all_it_is_called_by_addresses_but_by_no_strange_name(tmp_path):
    with (
        studios.thread_serving(House("0.0.0.0", tmp_path).build) as base,
        httpx.Client(base_url=base, timeout=studios.PATIENCE_S) as client,
    ):
        assert client.get("/", headers={"host": "192.168.0.7:8765"}).status_code == 401
        assert client.get("/", headers={"host": "evil.example:8765"}).status_code == 400


@pytest.mark.parametrize("method", ["post", "put", "delete", "patch"])
def test_nothing_is_done_for_another_page(inside, house, method):
    before = len(house.studio.computer.asked)
    for path in ("/api/photo", "/api/photo/mine", "/api/job", "/api/photo/mine/face"):
        answer = getattr(inside, method)(path, headers={"origin": "http://evil.example"})
        assert answer.status_code == 403
    assert len(house.studio.computer.asked) == before
    assert inside.get("/api/photo/mine.jpg").content == SECRET


def handshake(house, client, *, origin=None, host=None, cookie=True):
    """The status that a WebSocket is answered with."""
    ask = http.client.HTTPConnection("127.0.0.1", house.port, timeout=studios.PATIENCE_S)
    headers = {"Upgrade": "websocket", "Connection": "Upgrade", "Sec-WebSocket-Version": "13"}
    headers |= {"Sec-WebSocket-Key": "dGhlIHNhbXBsZSBub25jZQ==", "Host": host or f"127.0.0.1:{house.port}"}
    headers |= {"Origin": origin} if origin else {}
    headers |= {"Cookie": "; ".join(f"{k}={v}" for k, v in client.cookies.items())} if cookie else {}
    ask.request("GET", "/ws", headers=headers)
    status = ask.getresponse().status
    ask.close()
    return status


def test_a_strangers_socket_is_refused_before_it_opens(inside, house):
    evil = "http://evil.example"
    assert handshake(house, inside, origin=house.base) == 101
    assert handshake(house, inside, origin=house.base, cookie=False) == 401
    assert handshake(house, inside, origin=evil) == 403
    assert handshake(house, inside) == 403
    assert handshake(house, inside, origin="null") == 403
    assert handshake(house, inside, origin=house.base, host="evil.example") == 400
    assert handshake(house, inside, origin=evil, host="evil.example") == 400


def test_its_own_page_opens_a_socket(inside):
    with studios.live(inside) as talk:
        talk.socket.send("no wish")
        assert "JSON" in talk.hear()[0]["error"]


def test_a_socket_without_a_cookie_does_not_open(client):
    with pytest.raises(InvalidStatus), studios.live(client):
        pass


def test_every_answer_tells_the_browser_to_keep_others_out(house, inside):
    stranger = httpx.get(house.base, timeout=studios.PATIENCE_S)
    for answer in (inside.get("/api/photo/mine.jpg"), stranger, inside.get("/", headers={"host": "x"})):
        assert answer.headers["content-security-policy"] == CSP
        assert answer.headers["x-content-type-options"] == "nosniff"
        assert answer.headers["referrer-policy"] == "no-referrer"
        assert answer.headers["cache-control"] == "no-store"
        assert answer.headers["cross-origin-resource-policy"] == "same-origin"


def test_a_guest_is_no_operator(inside):
    assert inside.get("/operator").status_code == 401
    assert inside.get("/operator?token=guest-token").status_code == 401
    assert inside.post("/api/operator/skip").status_code == 401


def test_the_operators_cookie_opens_his_page(client):
    answer = client.get("/operator?token=operator-token", follow_redirects=False)
    assert answer.status_code == 303
    assert client.get("/operator").status_code in (200, 404)
    assert client.get("/").status_code == 401


def test_two_visitors_do_not_see_each_others_photos(house, inside):
    with httpx.Client(base_url=house.base, follow_redirects=True, timeout=studios.PATIENCE_S) as other:
        other.get("/?token=guest-token")
        assert other.get("/api/photo/mine.jpg").status_code == 404
        assert other.delete("/api/photo/mine").status_code == 404
    assert inside.get("/api/photo/mine.jpg").content == SECRET


@pytest.mark.parametrize("path", ["/../app.py", "/%2e%2e/app.py", "/..%2fguard.py", "//etc/passwd", "/%00"])
def test_only_the_pages_own_files_are_served(inside, path):
    assert inside.get(path).status_code in (400, 401, 404)
