"""Chromium without a screen, for tests of pages: by its pipe, so without any port or package."""
import base64
import fcntl
import json
import os
import shutil
import subprocess
import tempfile
import time

CHROMIUM = shutil.which("chromium")
WITHOUT = "chromium is not installed (apt-get install chromium)"
PATIENCE = 60  # seconds that a page may take to be ready


class Browser:
    """A page in Chromium; `with Browser() as browser`. What the page's scripts fail with is in `problems`."""

    def __init__(self, wide=1200, tall=900):
        self.folder = tempfile.mkdtemp()
        theirs_in, self.write = os.pipe()
        self.read, theirs_out = os.pipe()
        words = [CHROMIUM, "--headless", "--no-sandbox", "--disable-gpu", "--remote-debugging-pipe", f"--user-data-dir={self.folder}",
                 f"--window-size={wide},{tall}", "about:blank"]

        def at_3_and_4():  # where it reads commands and answers
            ends = [fcntl.fcntl(end, fcntl.F_DUPFD, 10) for end in (theirs_in, theirs_out)]
            os.dup2(ends[0], 3)
            os.dup2(ends[1], 4)

        self.process = subprocess.Popen(words, preexec_fn=at_3_and_4, pass_fds=(3, 4), stdout=subprocess.DEVNULL,
                                        stderr=subprocess.DEVNULL)
        os.close(theirs_in)
        os.close(theirs_out)
        self.number, self.session, self.left, self.problems, self.requests = 0, None, b"", [], []
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        self.session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.call(f"{domain}.enable")

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.terminate()
        self.process.wait(20)
        os.close(self.write)
        os.close(self.read)
        shutil.rmtree(self.folder, ignore_errors=True)

    def message(self):
        """The next message."""
        while b"\0" not in self.left:
            part = os.read(self.read, 1 << 20)
            assert part, "chromium has ended"
            self.left += part
        found, _, self.left = self.left.partition(b"\0")
        found = json.loads(found)
        params = found.get("params", {})
        if found.get("method") == "Runtime.exceptionThrown" or params.get("entry", {}).get("level") == "error":
            self.problems.append(params)
        if found.get("method") == "Network.requestWillBeSent":
            self.requests.append(params["request"]["url"])
        return found

    def call(self, method, **params):
        """A command of the DevTools protocol, and its answer."""
        self.number += 1
        command = {"id": self.number, "method": method, "params": params} | ({"sessionId": self.session} if self.session else {})
        os.write(self.write, json.dumps(command).encode() + b"\0")
        while True:
            found = self.message()
            if found.get("id") == self.number:
                assert "error" not in found, found
                return found["result"]

    def evaluate(self, script):
        """The value of an expression in the page."""
        found = self.call("Runtime.evaluate", expression=script, awaitPromise=True, returnByValue=True)
        assert "exceptionDetails" not in found, found["exceptionDetails"]
        return found["result"].get("value")

    def open(self, path):
        """Opens a page and waits until its scripts say how they are."""
        self.call("Page.navigate", url=path.resolve().as_uri())
        self.until("document.documentElement?.dataset.state")

    def until(self, script):
        """Waits until an expression is true, and returns its value."""
        begun = time.monotonic()
        while not (found := self.evaluate(script)):
            assert time.monotonic() - begun < PATIENCE, script
            time.sleep(0.02)
        return found

    def choose(self, name, value):
        """Sets a control of the page, as a user does."""
        kind = "checked" if isinstance(value, bool) else "value"
        self.evaluate(f"(() => {{ const box = document.getElementById({name!r}); box.{kind} = {json.dumps(value)}; "
                      "box.dispatchEvent(new Event('input', {bubbles: true})); })()")

    def mouse(self, kind, x, y, **more):
        """Moves, presses or turns the wheel at a place of the window."""
        self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, **more)

    def picture(self):
        """What the window shows, as PNG."""
        return base64.b64decode(self.call("Page.captureScreenshot")["data"])
