"""Runs a kerfd on a folder of kept sheets, for the tests of what survives its end."""

import json
import os
import signal
import subprocess
import tempfile
import urllib.error
import urllib.request

PATIENCE_S = 60
LISTEN = ("--listen", "127.0.0.1:0", "--http", "127.0.0.1:0", "--no-render", "--max-load", "0")


def scene(side=8, **changes):
    """Makes the scene of a square sheet of 1 m that hangs by its upper edge."""
    return {"grid": {"columns": side, "rows": side, "width_m": 1, "height_m": 1}, "pins": [{"edge": "TOP"}], **changes}


def line_cut(sheet, begin, end, **fields):
    """Makes the request of a cut along a line."""
    points = [{"x": x, "y": y} for x, y in (begin, end)]
    return {"parent": sheet, "cut": {"curve": {"polyline": {"points": points}}}, **fields}


def reason(answer):
    """Returns the reason of a refusal; an empty text where the request was answered."""
    details = answer.get("refused", {}).get("details", [])
    return next((each["reason"] for each in details if "reason" in each), "")


class Server:
    """A kerfd that its owner stops or kills."""

    def __init__(self, kerfd, *options, environment=None, token=None):
        self.headers = {"Authorization": f"Bearer {token}"} if token else {}
        self.errors = tempfile.TemporaryFile(mode="w+")
        self.process = subprocess.Popen([kerfd, *LISTEN, *options], stdout=subprocess.PIPE, stderr=self.errors, text=True,
                                        env={**os.environ, **(environment or {})})
        line = self.process.stdout.readline()
        if not line:
            raise RuntimeError(f"kerfd ended at once: {self.end(signal.SIGKILL)}")
        self.ready = json.loads(line)

    def end(self, how=signal.SIGTERM):
        """Sends a signal, waits for the end and returns the text of standard error."""
        self.process.send_signal(how)
        return self.ended()

    def ended(self):
        """Waits for the end and returns the text of standard error."""
        self.process.wait(timeout=PATIENCE_S)
        self.process.stdout.close()
        self.errors.seek(0)
        text = self.errors.read()
        self.errors.close()
        return text

    def call(self, method, message):
        """Returns the answer, {"refused": status} if it is refused, or None if the server was gone before it came."""
        request = urllib.request.Request(f"{self.ready['http']}/kerf.v1.{method}", json.dumps(message).encode(),
                                         {"Content-Type": "application/json", **self.headers})
        try:
            with urllib.request.urlopen(request, timeout=PATIENCE_S) as response:
                return json.loads(response.read())
        except urllib.error.HTTPError as error:
            return {"refused": json.loads(error.read() or b"{}")}
        except (OSError, ValueError):
            return None
