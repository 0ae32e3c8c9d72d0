"""Foreign senders drive `stepwright grbl`: a job, a hold, an override, a jog, a reset, an alarm.

    senders.py COMMAND LINES [SENDER ...]

`STEPWRIGHT_PORT` is that of a board that plays streams, which has the motors then.

Each ends at its exact end. How many bytes are on their way without an answer is the sender's
doing: 127 by grbl's rule, which pygrbl-streamer and gantrix keep; grbl-streamer counts to 128 and
says a line twice at times.
"""

import contextlib
import json
import os
import queue
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
import urllib.parse
import urllib.request

from line import Grbl, spiral


def hold_and_resume(grbl, hold, resume):
    """In the middle of the job, by the sender's own means."""
    time.sleep(0.7)
    hold()
    place = grbl.until("Hold:0")
    time.sleep(0.3)
    assert grbl.ask() == ("Hold:0", place), "it moves in a hold"
    resume()
    grbl.until("Run")
    # Slower, and faster again; as a page sends it, in UTF-8.
    grbl.say(b"\x92\x92")
    grbl.say("\x91\x91".encode())


def pygrbl(grbl, folder, lines):
    """pygrbl-streamer: character counting, no `?` on the way."""
    from pygrbl_streamer import GrblStreamer, State

    job, end = spiral(lines)
    path = f"{folder}/job.nc"
    with open(path, "w", encoding="ascii") as file:
        file.write("\n".join(job) + "\n")
    sender = GrblStreamer(grbl.path)
    sender.connect()
    results = queue.Queue()
    threading.Thread(target=lambda: results.put(sender.send_file(path))).start()
    hold_and_resume(grbl, sender.pause, sender.resume)
    assert results.get(timeout=300), "the job failed"
    assert grbl.until("Idle") == end
    # A jog, and a job that is stopped on its way.
    assert sender.command("$J=G91 X-10 F3000")
    end[0] -= 1000
    assert grbl.until("Idle") == end
    threading.Thread(target=lambda: results.put(sender.send_file(path))).start()
    time.sleep(0.7)
    sender.stop()
    assert not results.get(timeout=60)
    stopped = grbl.until("Idle")
    # A probe that meets nothing.
    sender.reset()
    sender.command("G38.2 Z-2 F600")
    grbl.until("Alarm")
    assert "ALARM:5" in grbl.errors
    grbl.errors.clear()
    assert sender.unlock() and sender.command("G0 Z1")
    stopped[2] = 100
    assert grbl.until("Idle") == stopped
    assert sender.state != State.DISCONNECTED
    sender.disconnect()
    return stopped


def streamer(grbl, folder, lines):
    """grbl-streamer: character counting, `?` five times a second."""
    from grbl_streamer import GrblStreamer

    del folder
    job, end = spiral(lines)
    events = queue.Queue()
    sender = GrblStreamer(lambda event, *data: events.put((event, data)))
    sender.cnect(grbl.path)
    time.sleep(3)
    sender.poll_start()
    sender.incremental_streaming = False
    sender.write("\n".join(job))
    sender.job_run()
    hold_and_resume(grbl, sender.hold, sender.resume)
    done, until = set(), time.monotonic() + 300
    while "on_job_completed" not in done and time.monotonic() < until:
        done.add(events.get(timeout=60)[0])
    assert "on_job_completed" in done
    place = grbl.until("Idle")
    sender.disconnect()
    assert place == end, (place, end)
    return place


def gantrix(grbl, folder, lines):
    """gantrix: a line at a time; it homes, and engraves with a laser."""
    del folder, lines
    # It says M5 before it unlocks, so it is not made for a machine that is locked at power-up.
    grbl.order("$22=1")
    words = [sys.executable, "-m", "gantrix.cli", "text", "HI", "--height", "5", "--line-gap", "1"]
    subprocess.run([*words, "--port", grbl.path, "--speed", "6000"], check=True, timeout=240)
    return grbl.until("Idle")


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return str(probe.getsockname()[1])


@contextlib.contextmanager
def cncjs_job(grbl, folder, job):
    """CNCjs begins a job; how to give it an order, and what says that the job is finished."""
    modules, tcp = os.environ["NODE_PATH"].split(os.pathsep)[0], free_port()
    path = f"{folder}/job.nc"
    with open(path, "w", encoding="ascii") as file:
        file.write("\n".join(job) + "\n")
    env = dict(os.environ, HOME=folder)
    words = ["node", f"{modules}/cncjs/bin/cncjs", "-p", tcp, "-H", "127.0.0.1"]
    server = subprocess.Popen(
        [*words, "--controller", "Grbl"], env=env, stdout=subprocess.DEVNULL, cwd=folder
    )
    try:
        for _ in range(600):
            with socket.socket() as probe:
                if probe.connect_ex(("127.0.0.1", int(tcp))) == 0:
                    break
            time.sleep(0.1)
        here = os.path.dirname(os.path.abspath(__file__))
        driver = subprocess.Popen(
            ["node", f"{here}/cncjs.cjs", grbl.path, path, tcp],
            env=env, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
        )

        def order(*words):
            driver.stdin.write(json.dumps(words) + "\n")
            driver.stdin.flush()

        def finish():
            said = driver.stdout.readline().split()
            assert said[:1] == ["finished"], said
            driver.wait(timeout=20)

        said = driver.stdout.readline().strip()
        assert said == "loaded", said
        grbl.until("Run")
        yield order, finish
    finally:
        server.kill()
        server.wait()


def cncjs(grbl, folder, lines):
    """CNCjs, over its own interface: `?` four times a second, `$G` twice."""
    job, end = spiral(lines)
    with cncjs_job(grbl, folder, job) as (order, finish):
        hold_and_resume(grbl, lambda: order("feedhold"), lambda: order("cyclestart"))
        order("feedOverride", 10)
        finish()
    place = grbl.until("Idle")
    assert place == end, (place, end)
    return place


def bcnc(grbl, folder, lines):
    """bCNC on a screen that nobody sees, driven by its web pendant: `?` five times a second."""
    web = free_port()
    job, end = spiral(lines)
    path = f"{folder}/job.nc"
    with open(path, "w", encoding="ascii") as file:
        file.write("\n".join(job) + "\n")
    with open(f"{folder}/.bCNC", "w", encoding="ascii") as file:
        file.write(
            f"[Connection]\nopenserial = 1\nport = {grbl.path}\nbaud = 115200\n"
            f"controller = GRBL1\npendant = 1\npendantport = {web}\n"
        )
    # Debian's runs with Debian's Python. A group of its own: the screen ends with it.
    env = dict(os.environ, HOME=folder, PATH="/usr/bin:" + os.environ["PATH"])
    words = ["xvfb-run", "--auto-servernum", "bCNC", path]
    sender = subprocess.Popen(
        words, env=env, cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        start_new_session=True,
    )

    def get(page):
        with urllib.request.urlopen(f"http://127.0.0.1:{web}/{page}", timeout=10) as answer:
            return answer.read()

    def order(command):
        get(f"send?cmd={command}")

    try:
        for _ in range(600):
            with contextlib.suppress(OSError):
                if json.loads(get("state"))["state"] == "Idle":
                    break
            time.sleep(0.1)
        order("RUN")
        grbl.until("Run")
        hold_and_resume(grbl, lambda: order("FEEDHOLD"), lambda: order("RESUME"))
        until = time.monotonic() + 300
        while (place := grbl.until("Idle", within=300)) != end and time.monotonic() < until:
            time.sleep(0.2)
        assert place == end, (place, end)
        # A jog, then a reset on its way.
        get("send?gcode=" + urllib.parse.quote("$J=G91 X-50 F3000"))
        grbl.until("Jog")
        order("RESET")
        place = grbl.until("Idle")
        assert end[0] - 5000 < place[0] < end[0] and place[1:] == end[1:], place
    finally:
        os.killpg(sender.pid, signal.SIGKILL)
        sender.wait()
    return place


def link(grbl, folder, lines):
    """grbl-link: a line at a time, real-time bytes between them."""
    import serial
    from grbl_link import interface

    del folder
    job, end = spiral(lines)
    with serial.Serial(grbl.path, 115200, timeout=1) as port, contextlib.redirect_stdout(None):
        sender = interface.Grbl(port)
        for line in job:
            sender.send(line)
        hold_and_resume(grbl, lambda: sender.send(b"!"), lambda: sender.send(b"~"))
        while not sender.protocol.send_queue.empty() or grbl.sent:
            time.sleep(0.2)
        place = grbl.until("Idle")
        assert place == end, (place, end)
        # A jog that is cancelled on its way.
        sender.jog(3000, x=-50)
        grbl.until("Jog")
        sender.jog_cancel()
        place = grbl.until("Idle")
        assert end[0] - 5000 < place[0] < end[0] and place[1:] == end[1:], place
        sender.stop()
    return place


LIMITS = ["--limit", "X:500", "--limit", "Y:500", "--limit", "Z:500"]
# How to drive it, the machine's options and settings, and bytes on their way at most.
SENDERS = {
    "pygrbl-streamer": (pygrbl, [], "", 127),
    "grbl-streamer": (streamer, [], "", 160),
    "gantrix": (gantrix, LIMITS, "$32=1\n", 127),
    "grbl-link": (link, [], "", 127),
    "cncjs": (cncjs, [], "", 127),
    "bcnc": (bcnc, [], "", 127),
}


def main():
    command, lines, *names = sys.argv[1:]
    for name in names or SENDERS:
        drive, extra, settings, most = SENDERS[name]
        with tempfile.TemporaryDirectory() as folder:
            port = os.environ.get("STEPWRIGHT_PORT")
            board = ["--port", port] if port else []
            grbl = Grbl(command, folder, [*extra, *board], settings)
            begun = time.monotonic()
            place = drive(grbl, folder, int(lines))
            assert not grbl.errors, grbl.errors
            assert grbl.most <= most, f"{grbl.most} bytes under way"
            # The machine's own count; homing has put its zero elsewhere.
            own = grbl.end()
            assert extra or own == place, (own, place)
            took = time.monotonic() - begun
            print(f"{name}: at {place}, at most {grbl.most} bytes under way, {took:.1f} s")


if __name__ == "__main__":
    main()
