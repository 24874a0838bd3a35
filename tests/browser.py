"""Headless Chromium, driven over the WebDriver protocol."""

import base64
import json
import re
import subprocess
import sys
import tempfile
import urllib.error
import urllib.request

CHROMIUM_ARGUMENTS = [
    "--headless=new", "--no-sandbox", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync",
    "--window-size=1280,1000", "--force-device-scale-factor=1",
]
NO_GRAPHICS = ["--disable-gpu"]
SOFTWARE_GRAPHICS = ["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
SHIFT = "\ue008"


class Browser:
    """A session of chromedriver, ended by `with`."""

    def __init__(self, graphics=NO_GRAPHICS):
        self.graphics = graphics

    def __enter__(self):
        self.profile = tempfile.TemporaryDirectory(ignore_cleanup_errors=True)
        self.driver = subprocess.Popen(["chromedriver", "--port=0"], stdout=subprocess.PIPE, text=True)
        for line in self.driver.stdout:
            if found := re.search(r"started successfully on port (\d+)", line):
                break
        else:
            sys.exit("chromedriver did not start")
        self.base = f"http://127.0.0.1:{found[1]}/session"
        options = {"args": [*CHROMIUM_ARGUMENTS, *self.graphics, f"--user-data-dir={self.profile.name}"]}
        capabilities = {"browserName": "chrome", "goog:chromeOptions": options,
                        "goog:loggingPrefs": {"browser": "ALL"}}
        self.base += "/" + self.call("", {"capabilities": {"alwaysMatch": capabilities}})["sessionId"]
        return self

    def __exit__(self, *_):
        try:
            self.call("", method="DELETE")
        finally:
            self.driver.terminate()
            self.driver.wait()
            self.profile.cleanup()

    def call(self, path, body=None, method=None):
        data = None if body is None else json.dumps(body).encode()
        request = urllib.request.Request(self.base + path, data, method=method or ("POST" if data else "GET"))
        opener = urllib.request.build_opener(urllib.request.ProxyHandler({}))
        try:
            with opener.open(request, timeout=120) as reply:
                return json.load(reply)["value"]
        except urllib.error.HTTPError as error:
            sys.exit(f"{path}: {json.load(error)['value']['message']}")

    def open(self, page):
        self.call("/url", {"url": page.as_uri()})

    def run(self, script, *arguments):
        return self.call("/execute/sync", {"script": script, "args": list(arguments)})

    def log(self):
        """Errors of the page's scripts, and requests that failed."""
        return [entry["message"] for entry in self.call("/se/log", {"type": "browser"})]

    def pointer(self, *actions):
        self.call("/actions", {"actions": [{
            "type": "pointer", "id": "mouse", "parameters": {"pointerType": "mouse"},
            "actions": [a if isinstance(a, dict) else
                        {"type": "pointerMove", "duration": 0, "x": round(a[0]), "y": round(a[1])}
                        for a in actions]}]})

    def drag(self, start, end):
        self.pointer(start, {"type": "pointerDown", "button": 0}, end, {"type": "pointerUp", "button": 0})

    def click(self, place):
        self.pointer(place, {"type": "pointerDown", "button": 0}, {"type": "pointerUp", "button": 0})

    def double_click(self, place):
        """Clicks twice. It counts the clicks itself: on a loaded machine two clicks of the pointer may be
        too far apart for the browser to take them for a double click."""
        for count in (1, 2):
            for kind in ("mousePressed", "mouseReleased"):
                self.call("/goog/cdp/execute", {"cmd": "Input.dispatchMouseEvent", "params": {
                    "type": kind, "x": place[0], "y": place[1], "button": "left", "clickCount": count}})

    def keys(self, *actions):
        self.call("/actions", {"actions": [{"type": "key", "id": "keys", "actions": [
            {"type": kind, "value": key} for kind, key in actions]}]})

    def wheel(self, place, distance):
        """Turns the wheel; `distance` below 0 is away from the user."""
        self.call("/actions", {"actions": [{"type": "wheel", "id": "wheel", "actions": [
            {"type": "scroll", "x": round(place[0]), "y": round(place[1]), "deltaX": 0, "deltaY": distance}]}]})

    def screenshot(self, path):
        path.write_bytes(base64.b64decode(self.call("/screenshot")))
