"""Asks the API of `stepwright serve` everything that its description allows, and more.

    python check.py STEPWRIGHT

Without control nothing may move; with control every answer must be as described. Ends with 0
if that is so. Needs requirements.txt.
"""

import http.client
import json
import pathlib
import subprocess
import sys
import threading
import time

FOLDER = pathlib.Path(__file__).parent
STEPWRIGHT = sys.argv[1]
# The program in the environment of this interpreter.
SCHEMATHESIS = pathlib.Path(sys.executable).with_name("schemathesis")


def serve(bind):
    """Starts a server of a virtual board. Returns its process, and the address of its page."""
    words = [STEPWRIGHT, "serve", "--machine", "none", "--virtual", "--bind", bind]
    server = subprocess.Popen(words, stdout=subprocess.PIPE, text=True)
    page = server.stdout.readline().strip()
    assert page.startswith("page http://"), page
    return server, page.removeprefix("page http://").partition("/")[0]


def ask(address, method, path, body=None, **headers):
    """Returns the status and the body of an answer."""
    connection = http.client.HTTPConnection(address, timeout=30)
    headers = {name.replace("_", "-"): value for name, value in headers.items()}
    connection.request(method, path, body, {"Content-Type": "application/json", **headers})
    answer = connection.getresponse()
    text = answer.read()
    connection.close()
    return answer.status, json.loads(text)


def fuzz(address, *more):
    """Runs Schemathesis. Returns whether it found nothing."""
    words = [SCHEMATHESIS, "--config-file", FOLDER / "schemathesis.toml", "run"]
    words += [f"http://{address}/api/openapi.json", "--checks", "all"]
    # A valid order may still be refused.
    words += ["--exclude-checks", "positive_data_acceptance"]
    words += ["--phases", "examples,coverage,fuzzing", "--max-examples", "40", "--seed", "1"]
    words += ["--no-color", "--warnings", "off", *more]
    return subprocess.run(words, check=False).returncode == 0


class Watch(threading.Thread):
    """Looks at the axes again and again, and keeps every state that is not rest at 0."""

    def __init__(self, address):
        super().__init__(daemon=True)
        self.address, self.on, self.looks, self.seen = address, True, 0, []
        self.start()

    def run(self):
        while self.on:
            _, state = ask(self.address, "GET", "/api/state")
            self.looks += 1
            at_rest = [axis["position"] == 0 and not axis["moving"] for axis in state["axes"]]
            if len(at_rest) != 3 or not all(at_rest):
                self.seen.append(state)
            time.sleep(0.02)

    def nothing_moved(self):
        """Returns whether nothing has moved, after two more looks."""
        looks = self.looks
        while self.is_alive() and self.looks < looks + 2:
            time.sleep(0.02)
        return self.is_alive() and not self.seen


class Stops(threading.Thread):
    """Stops the axes again and again: some of the orders with `wait` would take hours."""

    def __init__(self, address):
        super().__init__(daemon=True)
        self.address, self.on, self.slowest = address, True, 0
        self.start()

    def run(self):
        while self.on:
            begin = time.monotonic()
            status, said = ask(self.address, "POST", "/api/stop", "{}")
            assert status == 200, said
            self.slowest = max(self.slowest, time.monotonic() - begin)
            time.sleep(0.2)


def waits(address, key):
    """Checks that an answer that waits tells how the order has ended."""
    headers = {"Stepwright_Control": key}
    for path, order, at in [
        ("/api/move", {"axis": 2, "to": 40}, [40]),
        ("/api/line", {"to": [60, 0], "accel": 2000}, [60, 0]),
        ("/api/line", {"by": [-60]}, [0]),
    ]:
        status, said = ask(address, "POST", f"{path}?wait=true", json.dumps(order), **headers)
        assert status == 200 and said["ended"]["outcome"] == "reached", said
        assert [one["position"] for one in said["ended"]["axes"]] == at, said


ORDERS = {
    "/api/move": {"axis": 1, "by": 4000},
    "/api/move?wait=true": {"axis": 1, "by": 4000},
    "/api/line": {"by": [2000, -500]},
    "/api/line?wait=true": {"to": [2000, None, 5]},
    "/api/run": {"axis": 1, "speed": -400},
    "/api/home": {"axis": 1, "within": 3000},
    "/api/set": {"name": "idle-ms", "value": 5},
    "/api/zero": {"axis": 1},
}


def attacks(address):
    """Sends requests that come neither from the page nor from a program with control."""
    host, _, port = address.partition(":")
    for path, order in ORDERS.items():
        body = json.dumps(order)
        for status, text, headers in [
            (409, body, {}),
            (409, body, {"Stepwright_Control": "0123456789abcdef0123456789abcdef"}),
            (403, body, {"Origin": "http://evil.example"}),
            (403, body, {"Origin": f"http://{host}:{int(port) + 1}"}),
            (403, body, {"Host": "evil.example"}),
            (413, body + " " * 5000, {}),
            (413, "[" * 100_000, {}),
            (415, body, {"Content_Type": "text/plain"}),
            (400, body[:-1], {}),
            (422, "[]", {}),
        ]:
            said = ask(address, "POST", path, text, **headers)
            assert said[0] == status, (path, text[:80], headers, said)
            assert said[1]["what"], said


def main():
    server, address = serve("127.0.0.1:0")
    open_server, open_address = serve("0.0.0.0:0")
    open_address = open_address.replace("0.0.0.0", "127.0.0.1")
    try:
        watch = Watch(address)
        assert fuzz(address), "schemathesis found something, without control"
        _, given = ask(address, "POST", "/api/control", '{"take_over": true}')
        attacks(address)
        assert watch.nothing_moved(), f"something moved without control: {watch.seen[:3]}"
        _, scope = ask(address, "GET", "/api/scope?seconds=10")
        assert not any(one["edges"] for one in scope["signals"] if one["pin"] == "step"), "a step"
        watch.on = False
        assert ask(address, "GET", "/api/path") == (200, None), "a file was run without control"
        print(f"without control nothing moved, in {watch.looks} looks")
        # From other computers nobody is answered without the token.
        for path, order in ORDERS.items():
            for headers in [{}, {"Authorization": "Bearer 0"}]:
                status, _ = ask(open_address, "POST", path, json.dumps(order), **headers)
                assert status == 401, (path, status)
        # With control all answers are as described, and nothing breaks.
        waits(address, given["key"])
        key, watch, stops = f"Stepwright-Control:{given['key']}", Watch(address), Stops(address)
        assert fuzz(address, "-H", key, "--exclude-path-regex", "/api/control"), "with control"
        assert stops.is_alive(), "a stop was not taken"
        stops.on = False
        print(f"beside orders that are waited for, a stop took {stops.slowest:.3f} s at most")
        status, state = ask(address, "GET", "/api/state")
        assert status == 200 and state["connected"], state
        assert watch.seen, "with control nothing has moved: what was tested?"
    finally:
        for one in (server, open_server):
            one.kill()
            one.wait()


main()
