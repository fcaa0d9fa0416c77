# SPDX-License-Identifier: Apache-2.0
"""Headless Chromium over its debugging pipe: pages, real mouse and keyboard, pictures. Needs nothing but Chromium."""
import base64
import json
import os
import select
import shutil
import subprocess
import tempfile
import time

ANSWER_S = 300.0  # only a hang takes as long, however busy the machine
FLAGS = ["--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--disable-background-networking",
         "--disable-component-update", "--disable-sync", "--disable-extensions", "--no-first-run",
         "--no-default-browser-check", "--hide-scrollbars", "--force-device-scale-factor=1", "--remote-debugging-pipe"]


def find_chromium():
    """Path of a Chromium or Chrome, or None."""
    return next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)


class Chromium:
    """A browser of its own with a fresh profile; `with Chromium() as browser: page = browser.page(url)`."""

    def __init__(self):
        program = find_chromium()
        if program is None:
            raise FileNotFoundError("no Chromium or Chrome on this machine; Debian's package is chromium")
        self.profile = tempfile.TemporaryDirectory(prefix="voltlap-chromium-", ignore_cleanup_errors=True)
        to_browser, self.write_end = os.pipe()
        self.read_end, from_browser = os.pipe()
        # Chromium reads commands from descriptor 3 and answers on 4; only a shell can place them there.
        shell = f'exec "$@" 3<&{to_browser} 4>&{from_browser}'
        self.process = subprocess.Popen(
            ["bash", "-c", shell, "bash", program, *FLAGS, f"--user-data-dir={self.profile.name}",
             "about:blank"],
            pass_fds=(to_browser, from_browser), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        os.close(to_browser)
        os.close(from_browser)
        self.pending, self.number, self.events, self.tab = b"", 0, [], None

    def __enter__(self):
        return self

    def __exit__(self, *_):
        try:
            self.call("Browser.close")
        except (OSError, EOFError, TimeoutError):
            self.process.kill()
        self.process.wait(timeout=ANSWER_S)
        os.close(self.write_end)
        os.close(self.read_end)
        self.profile.cleanup()

    def message(self, deadline):
        """The next message of the browser."""
        while b"\0" not in self.pending:
            ready, _, _ = select.select([self.read_end], [], [], max(0.0, deadline - time.monotonic()))
            if not ready:
                raise TimeoutError("Chromium does not answer")
            chunk = os.read(self.read_end, 1 << 20)
            if not chunk:
                raise EOFError("Chromium has ended")
            self.pending += chunk
        text, _, self.pending = self.pending.partition(b"\0")
        return json.loads(text)

    def call(self, method, session=None, **parameters):
        """Sends a command of the DevTools protocol and returns its result; what happens meanwhile goes to `events`."""
        self.number += 1
        command = {"id": self.number, "method": method, "params": parameters}
        if session:
            command["sessionId"] = session
        view = memoryview(json.dumps(command).encode() + b"\0")
        while view:
            view = view[os.write(self.write_end, view):]
        deadline = time.monotonic() + ANSWER_S
        while True:
            answer = self.message(deadline)
            if answer.get("id") == self.number:
                if "error" in answer:
                    raise RuntimeError(f"{method}: {answer['error']['message']}")
                return answer["result"]
            self.events.append(answer)

    def page(self, url, width=1400, height=900, dark=False, mobile=False):
        """Opens the address in a new tab and closes the one before: a tab that is hidden draws nothing."""
        before, self.tab = self.tab, Page(self, url, width, height, dark, mobile)
        if before:
            before.close()
        return self.tab


class Page:
    """One tab. Positions are CSS pixels of the window."""

    def __init__(self, browser, url, width, height, dark, mobile):
        self.browser = browser
        self.target = browser.call("Target.createTarget", url="about:blank")["targetId"]
        self.session = browser.call("Target.attachToTarget", targetId=self.target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network", "Performance"):
            self.call(f"{domain}.enable")
        self.size(width, height, mobile)
        self.color_scheme("dark" if dark else "light")
        self.url = url
        self.call("Page.navigate", url=url)

    def call(self, method, **parameters):
        return self.browser.call(method, self.session, **parameters)

    def size(self, width, height, mobile=False):
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=mobile)

    def color_scheme(self, name):
        self.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": name}])

    def run(self, script):
        """Value of a JavaScript expression; promises are awaited."""
        result = self.call("Runtime.evaluate", expression=script, returnByValue=True, awaitPromise=True)
        if "exceptionDetails" in result:
            raise RuntimeError(result["exceptionDetails"].get("exception", {}).get("description", str(result)))
        return result["result"].get("value")

    def wait_for(self, script, timeout_s=ANSWER_S):
        """Waits until the expression is true and returns it."""
        deadline = time.monotonic() + timeout_s
        while time.monotonic() < deadline:
            if value := self.run(script):
                return value
            time.sleep(0.02)
        raise TimeoutError(f"never true: {script}")

    def processor_s(self):
        """Processor time that the page's process has used, drawing included."""
        metrics = self.call("Performance.getMetrics")["metrics"]
        return next(metric["value"] for metric in metrics if metric["name"] == "ProcessTime")

    def settle(self):
        """Until what was asked of the page has been drawn."""
        self.run("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done))).then(() => true)")

    def mouse(self, kind, x, y, **more):
        self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, **more)

    def drag(self, start, end, steps=8):
        """Presses at `start`, moves, lets go at `end`."""
        self.mouse("mouseMoved", *start)
        self.mouse("mousePressed", *start, button="left", buttons=1, clickCount=1)
        for i in range(1, steps + 1):
            x, y = (start[k] + (end[k] - start[k]) * i / steps for k in (0, 1))
            self.mouse("mouseMoved", x, y, button="left", buttons=1)
        self.mouse("mouseReleased", *end, button="left", clickCount=1)
        self.settle()

    def wheel(self, at, delta, modifiers=0):
        """Modifiers: 2 Ctrl, 8 Shift."""
        self.mouse("mouseWheel", *at, deltaX=0, deltaY=delta, modifiers=modifiers)
        self.settle()

    def key(self, key, text=""):
        more = {"text": text} if text else {}
        self.call("Input.dispatchKeyEvent", type="keyDown", key=key, **more)
        self.call("Input.dispatchKeyEvent", type="keyUp", key=key)
        self.settle()

    def picture(self, path, whole=False):
        """PNG of the window, or of the whole page."""
        clip = {}
        if whole:
            content = self.call("Page.getLayoutMetrics")["cssContentSize"]
            clip = {"clip": {"x": 0, "y": 0, "width": content["width"], "height": content["height"], "scale": 1}}
        data = self.call("Page.captureScreenshot", format="png", captureBeyondViewport=whole, **clip)["data"]
        with open(path, "wb") as file:
            file.write(base64.b64decode(data))

    def happened(self, *methods):
        """Events of these kinds on this page so far."""
        return [event for event in self.browser.events
                if event.get("sessionId") == self.session and event["method"] in methods]

    def complaints(self):
        """What the page wrote to the console, and errors that nobody caught."""
        self.settle()
        return [event["params"] for event in
                self.happened("Runtime.consoleAPICalled", "Runtime.exceptionThrown", "Log.entryAdded")]

    def close(self):
        self.browser.call("Target.closeTarget", targetId=self.target)
