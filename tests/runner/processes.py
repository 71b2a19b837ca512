"""Runs commands whose processes all end with them, however they end."""

import os
import queue
import signal
import subprocess
import threading
import time

PATIENCE = 5.0  # seconds from asking processes to end until they are killed


def end_group(group):
    """Asks every process of a group to end, and kills those that have not after a while."""
    for wanted in (signal.SIGTERM, signal.SIGKILL):
        asked = time.monotonic()
        try:
            os.killpg(group, wanted)
            while time.monotonic() - asked < PATIENCE:
                os.killpg(group, 0)  # raises if no process is left
                time.sleep(0.05)
        except ProcessLookupError:
            return


class Command:
    """A command of bash as it runs. Leaving its context ends every process of it."""

    def __init__(self, command, environment=None, cwd=None):
        self.status = None  # until it has ended
        self.lines = queue.SimpleQueue()
        self.process = subprocess.Popen(
            ["bash", "-euo", "pipefail", "-c", command], cwd=cwd, env=environment, text=True, errors="replace",
            stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, start_new_session=True)
        self.reader = threading.Thread(target=self._read, daemon=True)
        self.reader.start()

    def _read(self):
        for line in self.process.stdout:
            self.lines.put(line)
        self.lines.put("")

    def __iter__(self):
        """Yields each line of its output, and None after each tenth of a second without one."""
        ended = None
        while self.status is None:
            try:
                line = self.lines.get(timeout=0.1)
            except queue.Empty:
                # Processes that it left running hold the pipe open and are not waited for; lines from before its end are.
                self.status = ended
                ended = self.process.poll()
                yield None
                continue
            if line:
                yield line
            else:
                self.status = self.process.wait()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        try:
            # A process that has ended stays in its group until it is waited for.
            if self.process.poll() is None:
                os.killpg(self.process.pid, signal.SIGTERM)
                try:
                    self.process.wait(PATIENCE)
                except subprocess.TimeoutExpired:
                    pass
            end_group(self.process.pid)
        except ProcessLookupError:
            pass
        self.process.wait()
        self.reader.join(PATIENCE)
        if not self.reader.is_alive():  # A process of another session may hold the pipe open.
            self.process.stdout.close()


def interrupt_once():
    """Makes SIGTERM and SIGHUP what Ctrl-C is, so that nothing is left behind after them either. Any more of them are
    ignored, because the first one's ending of processes must not stop halfway."""
    signals = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)

    def interrupt(*_):
        for each in signals:
            signal.signal(each, signal.SIG_IGN)
        raise KeyboardInterrupt

    for each in signals:
        signal.signal(each, interrupt)


def end_as_interrupted():
    """Ends this program by SIGINT, so that a script that called it ends, too."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    os.kill(os.getpid(), signal.SIGINT)
