#!/usr/bin/env python3
"""Has clang read sources of the product one by one: no unity build, another compiler. Prints what it refuses.

each_file.py [SEED]   reads an eighth of the sources, chosen by SEED, or all of them
"""

import concurrent.futures
import json
import os
import pathlib
import random
import re
import shlex
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = ROOT / "build/each-file"


def configure():
    """Lists the compiler's calls, and generates the code that sources include."""
    subprocess.run(["cmake", "--preset", "release", "-B", BUILD, "-DCMAKE_CXX_COMPILER=clang++", "-DKERF_UNITY=OFF",
                    "-DKERF_TESTS=OFF", "-DKERF_BENCH=OFF"], cwd=ROOT, check=True, stdout=subprocess.DEVNULL)
    targets = subprocess.run(["ninja", "-C", BUILD, "-t", "targets", "all"], check=True, capture_output=True, text=True).stdout
    generated = re.findall(r"^(proto/\S+\.pb\.h):", targets, re.MULTILINE)
    subprocess.run(["ninja", "-C", BUILD, *generated], check=True, stdout=subprocess.DEVNULL)
    return json.loads((BUILD / "compile_commands.json").read_text())


def is_ours(entry):
    source = pathlib.Path(entry["file"])
    return source.is_relative_to(ROOT) and not source.is_relative_to(BUILD)


def refusal(entry):
    """Compiler's words; empty where it takes the file."""
    command = shlex.split(entry["command"])
    at = command.index("-o")
    del command[at:at + 2]
    # Warnings are g++'s business; clang has others.
    done = subprocess.run([*command, "-fsyntax-only", "-w"], cwd=entry["directory"], capture_output=True, text=True)
    return "" if done.returncode == 0 else done.stderr or f"the compiler ended with {done.returncode}"


def share(entries, seed):
    """Chooses at random, so that runs with other seeds reach every source sooner or later."""
    return random.Random(seed).sample(entries, -(-len(entries) // 8))


def main():
    entries = [entry for entry in configure() if is_ours(entry)]
    if len(sys.argv) > 1:
        entries = share(entries, int(sys.argv[1]))
    refused = 0
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        for number, (entry, words) in enumerate(zip(entries, pool.map(refusal, entries)), start=1):
            name = os.path.relpath(entry["file"], ROOT)
            print(f"[{number}/{len(entries)}] {name}", flush=True)
            if words:
                refused += 1
                print(f"FAILED {name}\n{words}", flush=True)
    if not entries:
        sys.exit("each_file.py: there is no source in build/each-file/compile_commands.json")
    print(f"{len(entries) - refused} files taken, {refused} refused")
    sys.exit(refused > 0)


if __name__ == "__main__":
    main()
