"""Cuts a sheet in two and prints the reply.  Usage: cut_example.py [HOST:PORT [SHEET]]"""
import sys

import kerf

address, sheet = (sys.argv[1:] + ["127.0.0.1:50051", "demo"][len(sys.argv) - 1:])[:2]
with kerf.connect(address) as server:
    print(server.sheet(sheet).cut(kerf.bezier((-0.1, 0.3), (0.3, 0.6), (0.7, 0.1), (1.1, 0.4))))
