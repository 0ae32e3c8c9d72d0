#!/usr/bin/env python3
"""The page's server, the command and a Python program drive one board at once.

    together.py STEPWRIGHT PORT

The server holds the port; the others reach the board through its socket. Ends with status 0 if each
of them sees and changes the same motion.
"""

import json
import os
import subprocess
import sys
import time
import urllib.request

sys.path.insert(0, os.path.join(os.path.dirname(__file__), "../../../../examples"))

import guest


def until(what, holds, limit=60):
    """Waits until it holds."""
    end = time.monotonic() + limit
    while not holds():
        if time.monotonic() > end:
            sys.exit(f"never: {what}")
        time.sleep(0.05)


def main(stepwright, port):
    environment = {**os.environ, "STEPWRIGHT_MACHINE": "none"}
    server = subprocess.Popen(
        [stepwright, "serve", "--port", port, "--bind", "127.0.0.1:0"],
        env=environment,
        stdout=subprocess.PIPE,
        text=True,
    )
    try:
        drive(stepwright, port, environment, server.stdout.readline().split()[1])
    finally:
        server.terminate()
        server.wait(60)


def drive(stepwright, port, environment, url):
    key = None

    def api(name, body=None):
        headers = {"Content-Type": "application/json", "Stepwright-Control": key or ""}
        data = None if body is None else json.dumps(body).encode()
        request = urllib.request.Request(f"{url}api/{name}", data, headers)
        with urllib.request.urlopen(request, timeout=60) as answer:
            return json.load(answer)

    def axis():
        return api("state")["axes"][0]

    def command(*words):
        ran = subprocess.run(
            [stepwright, *words, "--port", port],
            env=environment, capture_output=True, text=True, timeout=60,
        )
        assert ran.returncode == 0, ran
        return ran.stdout

    key = api("control", {"name": "together"})["key"]
    api("zero", {"axis": 1})
    # By HTTP a travel of 100 s.
    api("move", {"axis": 1, "by": 40_000, "top_speed": 400})
    line = guest.open_line(port)
    assert isinstance(line, guest.Guest), "the port is held"
    until("it moves", lambda: int(guest.say(line, "V1")) > 50)
    # By the Python program it becomes faster, which the server's state shows.
    assert guest.say(line, "t2000") == "Y"
    until("it is faster", lambda: axis()["speed"] > 1500)
    # A guest gives no orders.
    assert guest.say(line, "PO") == "E"
    assert guest.say(line, "G+5") == "E"
    # By the command it has another target, where all three see it.
    command("retarget", "6000")
    until("it rests", lambda: not axis()["moving"])
    assert axis()["position"] == 6000, axis()
    assert guest.say(line, "V1") == "6000"
    assert command("position").split()[1] == "6000"
    # A run of the server's is stopped by the Python program.
    api("move", {"axis": 1, "by": -40_000, "top_speed": 400})
    until("it is on its way", lambda: int(guest.say(line, "V1")) < 5_900)
    assert guest.say(line, "Z") == "Y"
    until("it rests", lambda: not axis()["moving"])
    until("the reason is known", lambda: (axis()["stop"] or {}).get("name") == "stop")
    at = axis()["position"]
    assert guest.say(line, "V1") == str(at) and 1_000 < at < 6_000, at
    print(f"a server, a command and a Python program have shared {port}; it rests at {at}")


if __name__ == "__main__":
    main(*sys.argv[1:])
