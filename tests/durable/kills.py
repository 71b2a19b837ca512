#!/usr/bin/env python3
"""Kills a kerfd under load again and again, starts it on the same folder, and checks every answer that it has given.

    kills.py KERFD --kills 20 --seed 0

Clients cut, undo and repeat requests, each on a sheet of its own. After each kill: every answered change is there once, with
the answer that was given; a request without an answer is repeated, and is there once as well; no sheet differs from its
recorded hashes; the list of cuts is that of the answers. The exit status is 1 after a fault.
"""
import argparse
import json
import pathlib
import random
import signal
import subprocess
import sys
import tempfile
import threading
import time

from server import Server, line_cut, scene

CLIENTS = 3
EXPECTED = ("NOTHING_TO_UNDO", "STATE_NOT_FOUND")  # Refusals that random requests may get.
ANSWERS_A_SHEET = 40  # Then the client deletes its sheet and makes another.


class Faults:
    """Faults that were found, from all threads."""

    def __init__(self):
        self.lines = []

    def check(self, is_right, line):
        if not is_right:
            self.lines.append(line)


class Client:
    """Changes one sheet at a time, one request after another, and knows what must be there."""

    def __init__(self, number, seed, faults):
        self.faults = faults
        self.num_changes = 0
        self.number = number
        self.random = random.Random(1000 * seed + number)
        self.generation = 0
        self.sheet = None
        self.open = None  # The request without an answer: method, message.
        self.answered = []  # Requests of this sheet, each with its method and answer.
        self.kept = None  # The cuts of the saved state.
        self.num_requests = 0

    def next_request(self):
        if self.sheet is None:
            name = f"sheet-{self.number}-{self.generation}"
            return "SheetService/CreateSheet", {"sheet_id": name, "scene": scene(), "request_id": f"{name}-made"}
        self.num_requests += 1
        request_id = f"{self.number}-{self.generation}-{self.num_requests}"
        if self.random.random() < 0.1:
            return "SheetService/SaveState", {"parent": self.sheet, "state_id": "kept", "overwrite": True, "request_id": request_id}
        if self.random.random() < 0.1 and self.kept is not None:
            return "SheetService/RestoreState", {"name": f"{self.sheet}/states/kept", "request_id": request_id}
        if self.random.random() < 0.15:
            return "CutService/UndoCut", {"parent": self.sheet, "request_id": request_id}
        begin, end = [(self.random.random(), self.random.random()) for _ in range(2)]
        return "CutService/CreateCut", line_cut(self.sheet, begin, end, request_id=request_id)

    def run(self, server, is_over):
        """Sends requests until the server is gone."""
        while not is_over.is_set():
            if self.open is None:
                self.open = self.next_request()
            if not self.send(server):
                return
            if len(self.answered) > ANSWERS_A_SHEET:
                if server.call("SheetService/DeleteSheet", {"name": self.sheet}) is None:
                    return
                self.begin_anew()

    def begin_anew(self):
        self.sheet, self.answered, self.kept = None, [], None
        self.generation += 1

    def send(self, server):
        """Sends the open request. Returns False if no answer came."""
        method, message = self.open
        answer = server.call(method, message)
        if answer is None or answer.get("refused", {}).get("code") in (14, "UNAVAILABLE"):
            return False
        self.open = None
        if method.endswith("CreateSheet"):
            self.sheet = answer["name"] if "refused" not in answer else self.sheet
        reason = json.dumps(answer.get("refused", ""))
        if "refused" in answer and not any(word in reason for word in EXPECTED):
            self.faults.check(False, f"{method} {message}: {reason}")
        if "refused" not in answer:
            self.num_changes += 1
            self.answered.append((method, message, answer))
            if method.endswith("SaveState"):
                self.kept = self.cuts()
        return True

    def cuts(self):
        """Returns the names of the cuts that the answers leave."""
        cuts, kept = [], []
        for method, _, answer in self.answered:
            if method.endswith("CreateCut") and answer.get("status") == "APPLIED":
                cuts.append(answer["name"])
            elif method.endswith("UndoCut"):
                cuts = [name for name in cuts if name not in answer.get("cuts", [])]
            elif method.endswith("SaveState"):
                kept = list(cuts)
            elif method.endswith("RestoreState"):
                cuts = list(kept)
        return cuts

    def check(self, server, faults):
        """Checks the sheet after a restart, the open request included."""
        if self.open is not None:
            faults.check(self.send(server), f"{self.open} has no answer")
        for method, message, answer in self.answered:
            if method.endswith("SaveState"):
                continue  # Its answer is remembered until the server ends.
            again = server.call(method, message)
            faults.check(again == answer, f"repeated {method} {message['request_id']}: {answer} became {again}")
        if self.sheet is None:
            return
        listed = server.call("CutService/ListCuts", {"parent": self.sheet, "page_size": 1000})
        if "refused" in listed and len(self.answered) > ANSWERS_A_SHEET:
            return self.begin_anew()  # The deletion was answered to a client that was gone.
        current = self.cuts()
        names = [each["result"]["name"] for each in listed.get("cuts", [])]
        faults.check(names == current, f"{self.sheet}: cuts {names}, but {current} were answered")
        return None


def check_notes(errors, faults):
    """Checks that no sheet was found damaged, different or impossible to start."""
    for line in errors.splitlines():
        faults.check("the kept sheet" not in line, line)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("kerfd", type=pathlib.Path)
    parser.add_argument("--kills", type=int, default=20)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    moments = random.Random(options.seed)
    faults = Faults()
    clients = [Client(i, options.seed, faults) for i in range(CLIENTS)]
    with tempfile.TemporaryDirectory() as folder:
        command = (options.kerfd, "--data", folder + "/store", "--max-replay-s", "0.02")
        server = Server(*command)
        for kill in range(options.kills):
            is_over = threading.Event()
            threads = [threading.Thread(target=client.run, args=(server, is_over)) for client in clients]
            for thread in threads:
                thread.start()
            time.sleep(moments.uniform(0.02, 0.5))
            errors = server.end(signal.SIGKILL)
            is_over.set()
            for thread in threads:
                thread.join()
            server = Server(*command)
            for client in clients:
                client.check(server, faults)
            check_notes(errors, faults)
            if faults.lines:
                break
            print(f"\r{kill + 1} kills, {sum(client.num_changes for client in clients)} changes", end="", file=sys.stderr)
        print(file=sys.stderr)
        errors = server.end(signal.SIGTERM)
        check_notes(errors, faults)
        faults.check(server.process.returncode == 0, f"kerfd ended with {server.process.returncode}: {errors}")
        checked = subprocess.run([options.kerfd, "--check-store", folder + "/store"], capture_output=True, text=True, check=False)
        faults.check(checked.returncode == 0 and "; 0 faults" in checked.stdout, checked.stdout + checked.stderr)
    for line in faults.lines[:20]:
        print(line)
    print(checked.stdout, end="")
    print(f"{options.kills} kills, {sum(client.num_changes for client in clients)} changes answered, seed {options.seed}: "
          f"{len(faults.lines)} faults")
    return 1 if faults.lines else 0


sys.exit(main())
