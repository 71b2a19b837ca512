"""Cuts a sheet in two and prints the reply.  Usage: cut_example.py [HOST:PORT [SHEET]]"""
import sys
import grpc
from kerf.v1 import cuts_pb2, cuts_pb2_grpc, geometry_pb2, scene_pb2

address, sheet = (sys.argv[1:] + ["127.0.0.1:50051", "demo"][len(sys.argv) - 1:])[:2]
cuts = cuts_pb2_grpc.CutServiceStub(grpc.insecure_channel(address))
points = [geometry_pb2.Vec2(x=x, y=y) for x, y in [(-0.1, 0.3), (0.3, 0.6), (0.7, 0.1), (1.1, 0.4)]]
curve = geometry_pb2.Curve(bezier=geometry_pb2.CubicBezier(points=points))
reply = cuts.CreateCut(cuts_pb2.CreateCutRequest(parent=f"sheets/{sheet}", cut=scene_pb2.Cut(curve=curve)))
print(reply)
