"""Cuts a sheet in two and prints the reply."""

from __future__ import annotations

import argparse

import kerf


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("sheet", nargs="?", default="demo", help="its id (default: demo)")
    parser.add_argument("--server", default="127.0.0.1:50051", help="HOST:PORT (default: %(default)s)")
    options = parser.parse_args()
    with kerf.connect(options.server) as server:
        print(server.sheet(options.sheet).cut(kerf.bezier((-0.1, 0.3), (0.3, 0.6), (0.7, 0.1), (1.1, 0.4))))


if __name__ == "__main__":
    main()
