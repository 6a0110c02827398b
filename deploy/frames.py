#!/usr/bin/env python3
"""Measure how smoothly the pages of reports play, in headless Chromium.

    deploy/frames.py out/jeep-frame/report.html [PAGE ...] [--size 1400x900] [--seconds 10]

Prints the frames a second of each half second of play, and with which share of the pixels of a
line and of the faces the page draws at the end. Without a graphics card, software draws; other
work on the machine makes it slower. CRUMPLE_CHROMIUM names another browser.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

FLAGS = (
    "--headless=new --no-sandbox --use-gl=angle --use-angle=swiftshader "
    "--enable-unsafe-swiftshader --disable-dev-shm-usage --remote-debugging-pipe"
).split()
LONGEST_WAIT = 120.0  # seconds until a page must be drawn
LOOK = "document.documentElement?.dataset.state"
RATE = "document.documentElement.dataset.framesPerSecond"
QUALITY = "JSON.stringify(crumple.qualities[crumple.quality])"


class Page:
    """A page in a browser of its own, driven by the DevTools protocol over a pipe."""

    def __init__(self, width, height):
        self.profile = tempfile.TemporaryDirectory(ignore_cleanup_errors=True)
        browser = os.environ.get("CRUMPLE_CHROMIUM", "chromium")
        # The protocol is spoken on the file descriptors 3 and 4.
        line = ["sh", "-c", 'exec "$0" "$@" 3<&0 4>&1 >/dev/null', browser, *FLAGS]
        line.append(f"--user-data-dir={self.profile.name}")
        pipe = subprocess.PIPE
        self.process = subprocess.Popen(line, stdin=pipe, stdout=pipe, stderr=subprocess.DEVNULL)
        self.sent, self.unread, self.session = 0, b"", None
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        attached = self.call("Target.attachToTarget", targetId=target, flatten=True)
        self.session = attached["sessionId"]
        size = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False}
        self.call("Emulation.setDeviceMetricsOverride", **size)

    def call(self, method, **params):
        """Call a method of the protocol and return its result."""
        self.sent += 1
        message = {"id": self.sent, "method": method, "params": params}
        if self.session:
            message["sessionId"] = self.session
        self.process.stdin.write(json.dumps(message).encode() + b"\0")
        self.process.stdin.flush()
        while True:
            while b"\0" not in self.unread:
                more = os.read(self.process.stdout.fileno(), 1 << 20)
                if not more:
                    sys.exit("error: the browser has ended")
                self.unread += more
            answer, self.unread = self.unread.split(b"\0", 1)
            answer = json.loads(answer)
            if answer.get("id") == self.sent:
                return answer["result"]

    def value(self, expression):
        """Return the value of an expression, none if it throws."""
        return self.call("Runtime.evaluate", expression=expression)["result"].get("value")

    def close(self):
        self.session = None
        self.call("Browser.close")
        self.process.wait()


def played(page, path, seconds):
    """Play a report, and return the rates and the quality at the end."""
    page.call("Page.navigate", url=f"{path.resolve().as_uri()}#play=again")
    begin = time.monotonic()
    while page.value(LOOK) != "ready":
        if time.monotonic() - begin > LONGEST_WAIT:
            sys.exit(f"error: {path} has no picture after {LONGEST_WAIT:.0f} s")
        time.sleep(0.1)
    rates = []
    for _ in range(round(2 * seconds)):
        time.sleep(0.5)
        rates.append(page.value(RATE))
    return [float(rate) for rate in rates if rate], page.value(QUALITY)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("pages", nargs="+", type=Path, metavar="PAGE", help="report.html")
    parser.add_argument("--size", default="1400x900", help="size of the window [pixels]")
    parser.add_argument("--seconds", type=float, default=10.0, help="time of play of each page")
    args = parser.parse_args()
    width, height = (int(number) for number in args.size.split("x"))
    for path in args.pages:
        if not path.is_file():
            sys.exit(f"error: {path} is no file: give the report.html of a run")
        page = Page(width, height)
        rates, quality = played(page, path, args.seconds)
        page.close()
        later = sorted(rates[len(rates) // 2 :]) or [0.0]
        print(f"{path}: median of the second half {later[len(later) // 2]:.0f} frames a second")
        print(f"  all: {' '.join(f'{rate:.0f}' for rate in rates)}")
        print(f"  pixels of a line and faces at the end: {quality}")


if __name__ == "__main__":
    main()
