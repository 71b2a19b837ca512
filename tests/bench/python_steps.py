#!/usr/bin/env python3
"""Measures how many ticks a second a Python script controls, one by one, and what a call costs it.

  client/python/generate FOLDER
  PYTHONPATH=FOLDER KERF_LIBRARY=build/release/bin/libkerf_local.so tests/bench/python_steps.py \
    --kerfd build/release/bin/kerfd [--seconds 2] [--vertices 20]

Each row is one way to step a sheet of N x N vertices by a tick and to get its state. `times real time` is of ticks of 1/60 s, of
all sheets together. The first row is the floor: a call of this client that does nothing. Rows "in this process" use no kerfd.
"""
import argparse
import json
import subprocess
import time

import kerf
import kerf.env
from kerf.v1 import access_service_pb2


def rate(work, seconds):
    """Calls of `work` a second, after a few to warm up, and the CPU time of this process for each, us."""
    for _ in range(20):
        work()
    count, begin, cpu = 0, time.perf_counter(), time.process_time()
    while (spent := time.perf_counter() - begin) < seconds:
        work()
        count += 1
    return count / spent, 1e6 * (time.process_time() - cpu) / count


def report(name, calls, ticks, cpu_us):
    print(f"| {name} | {calls:,.0f} | {cpu_us:,.0f} | {calls * ticks:,.0f} | {calls * ticks / 60:.1f} |", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kerfd", required=True)
    parser.add_argument("--seconds", type=float, default=2.0)
    parser.add_argument("--vertices", type=int, default=20, help="along each side")
    options = parser.parse_args()
    process = subprocess.Popen([options.kerfd, "--listen", "127.0.0.1:0", "--http", "127.0.0.1:0", "--max-load", "0", "--data",
                                "none", "--max-sheets", "300"], stdout=subprocess.PIPE, text=True)
    address = json.loads(process.stdout.readline())["grpc"]
    print("| way | calls/s | CPU of Python a call, us | ticks/s | times real time |\n|---|---|---|---|---|")
    try:
        with kerf.connect(address) as server, kerf.local() as local:
            measure(server, "", options)
            measure(local, ", in this process", options)
    finally:
        process.terminate()
        process.wait(timeout=30)


def measure(server, where, options):
    grid = (options.vertices, options.vertices)
    tip = [kerf.probe("tip", "position", points=(0.5, 0.0))]
    sheets = [server.create_sheet(f"s{number}", grid=grid, paused=True) for number in range(64)]
    sheet = sheets[0]
    sheet.save_state("start")
    empty = access_service_pb2.GetAccessRequest()

    def two_calls():
        sheet.step(1)
        sheet.state()

    for name, ticks, work in (
            ("floor: an empty call", 0, lambda: server.access_service.GetAccess(empty)),
            ("step(1), then state()", 1, two_calls),
            ("step(1, state=True)", 1, lambda: sheet.step(1, state=True)),
            ("step(1, probes=...)", 1, lambda: sheet.step(1, probes=tip)),
            ("step(10, state=True)", 10, lambda: sheet.step(10, state=True)),
            ("step of 16 sheets, with states", 16, lambda: server.step(sheets[:16], 1, state=True)),
            ("step of 64 sheets, with states", 64, lambda: server.step(sheets, 1, state=True)),
            ("step of 64 sheets, with probes", 64, lambda: server.step(sheets, 1, probes=tip))):
        sheet.restore_state("start")
        calls, cpu_us = rate(work, options.seconds)
        report(name + where, calls, ticks, cpu_us)
    for each in sheets:
        each.delete()
    env = kerf.env.SheetEnv(server, grid=grid, ticks_per_step=1, max_steps=10**9)
    envs = kerf.env.SheetVectorEnv(16, server, grid=grid, ticks_per_step=1, max_steps=10**9)
    still = env.action_space.sample() * 0
    many = envs.action_space.sample() * 0
    for environment, name, ticks, action in ((env, "SheetEnv.step", 1, still), (envs, "SheetVectorEnv.step, 16 sheets", 16, many)):
        environment.reset(seed=1)
        calls, cpu_us = rate(lambda: environment.step(action), options.seconds)
        report(name + where, calls, ticks, cpu_us)
        environment.close()


if __name__ == "__main__":
    main()
