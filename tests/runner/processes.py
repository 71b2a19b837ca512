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


def run_command(command, take, environment=None, cwd=None):
    """Runs a command of bash; its exit status. `take` gets each line of its output, and None each second without one."""
    process = subprocess.Popen(["bash", "-euo", "pipefail", "-c", command], cwd=cwd, env=environment, text=True, errors="replace",
                               stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, start_new_session=True)
    lines = queue.SimpleQueue()

    def read():
        for line in process.stdout:
            lines.put(line)
        lines.put("")

    reader = threading.Thread(target=read, daemon=True)
    reader.start()
    try:
        while True:
            try:
                line = lines.get(timeout=1.0)
            except queue.Empty:
                take(None)
                # Processes that it left running hold the pipe open and are not waited for.
                if process.poll() is not None:
                    return process.returncode
                continue
            if not line:
                return process.wait()
            take(line)
    finally:
        try:
            # A process that has ended stays in its group until it is waited for.
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGTERM)
                try:
                    process.wait(PATIENCE)
                except subprocess.TimeoutExpired:
                    pass
            end_group(process.pid)
        except ProcessLookupError:
            pass
        process.wait()
        reader.join()
        process.stdout.close()


def interrupt_on_termination():
    """Makes SIGTERM and SIGHUP what Ctrl-C is, so that nothing is left behind after them either."""
    def interrupt(*_):
        raise KeyboardInterrupt

    signal.signal(signal.SIGTERM, interrupt)
    signal.signal(signal.SIGHUP, interrupt)


def end_as_interrupted():
    """Ends this program by SIGINT, so that a script that called it ends, too."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    os.kill(os.getpid(), signal.SIGINT)
