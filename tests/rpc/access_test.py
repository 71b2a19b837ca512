#!/usr/bin/env python3
"""Asks a kerfd with tokens for every method and compares with server/access.md.

Each is asked over gRPC and as a JSON call, with each scope, of two tenants and of none.

    access_test.py --kerfd KERFD --kerf KERF --work FOLDER
"""

import argparse
import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import unittest
import urllib.error
import urllib.request

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCOPES = ("view", "cut", "admin")
TENANTS = ("lab", "shop")
OF_THE_SERVER = ("ListSheets", "GetServerInfo", "GetAccess", "CreateLink", "InspectMesh", "InspectDrawing")
OPTIONS = None
STREAMS = ("Watch", "Subscribe", "WatchImages", "UploadSheet", "ReplayRecording", "GetSheetRecording")


def page():
    """The calls of server/access.md by the least scope, "all" for those that need a token which reaches all sheets."""
    table = (ROOT / "server/access.md").read_text().split("## What a scope allows")[1].split("## ")[0]
    rows = re.findall(r"^\| (view|cut|admin|admin that reaches all sheets) \| (.*) \|$", table, re.MULTILINE)
    return {call: "all" if "all" in scope else scope for scope, calls in rows for call in calls.split(", ")}


def setUpModule():
    shutil.rmtree(OPTIONS.work, ignore_errors=True)
    os.makedirs(OPTIONS.work)
    subprocess.run([ROOT / "client/python/generate", path("package")], check=True)
    sys.path.insert(0, path("package"))


def path(name):
    return os.path.join(OPTIONS.work, name)


class EveryMethod(unittest.TestCase):
    def setUp(self):
        pathlib.Path(path("tokens")).write_text("".join(f"tenant {tenant} cuts-per-s=0\n" for tenant in TENANTS))
        tokens = {scope: ("--scope", scope) for scope in SCOPES} | {"mine": ("--scope", "admin", "--sheets", "mine")}
        tokens |= {f"{tenant}-{scope}": ("--scope", scope, "--tenant", tenant) for tenant in TENANTS for scope in SCOPES}
        for name, options in tokens.items():
            subprocess.run([OPTIONS.kerf, "token", "new", name, *options, "--file", path("tokens"), "--out", path(name)], check=True,
                           capture_output=True)
        self.tokens = {name: pathlib.Path(path(name)).read_text().strip() for name in tokens}
        self.server = subprocess.Popen(
            [OPTIONS.kerfd, "--listen", "127.0.0.1:0", "--http", "127.0.0.1:0", "--no-render", "--max-load", "0", "--data", path("data"),
             "--tokens", path("tokens")], stdout=subprocess.PIPE, text=True)
        self.ready = json.loads(self.server.stdout.readline())
        import grpc
        self.grpc = grpc
        self.channel = self.enterContext(grpc.insecure_channel(self.ready["grpc"]))

    def tearDown(self):
        self.server.send_signal(signal.SIGTERM)
        self.server.wait(timeout=30)
        self.server.stdout.close()

    def services(self):
        from kerf.v1 import (access_service_pb2, cuts_pb2, files_pb2, interaction_pb2, render_pb2, server_pb2, sheets_pb2,
                             store_service_pb2, stream_pb2)
        files = (access_service_pb2, cuts_pb2, files_pb2, interaction_pb2, render_pb2, server_pb2, sheets_pb2, store_service_pb2,
                 stream_pb2)
        return [service for file in files for service in file.DESCRIPTOR.services_by_name.values()]

    def request(self, method, sheet):
        """A request for a sheet that is not there: whoever may ask gets another refusal, and nothing is changed."""
        from google.protobuf import json_format
        from google.protobuf.message_factory import MessageFactory
        message = MessageFactory().GetPrototype(method.input_type)()
        fields = message.DESCRIPTOR.fields_by_name
        for field in ("name", "parent"):
            if field in fields:
                setattr(message, field, f"sheets/{sheet}")
        if method.name in ("Watch", "WatchImages"):
            message.start.name = f"sheets/{sheet}"
        if method.name == "UploadSheet":
            message.start.sheet.sheet_id = sheet
        if method.name == "ReplayRecording":
            message.start.sheet_id = sheet
        if method.name == "CreateSheet":
            message.sheet_id = sheet
        if method.name == "StepSheets":
            message.names.append(f"sheets/{sheet}")
            message.ticks = 1
        if method.name == "InspectMesh":
            message.obj.text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
        if method.name == "InspectDrawing":
            message.svg.text = '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 9 9"><circle cx="4" cy="4" r="3"/></svg>'
        return message, json_format.MessageToJson(message, preserving_proto_field_name=True)

    def over_grpc(self, method, sheet, token):
        """The reason of the refusal; empty where it was answered."""
        from google.rpc import error_details_pb2, status_pb2
        message, _ = self.request(method, sheet)
        name = f"/{method.containing_service.full_name}/{method.name}"
        arguments = {"metadata": (("authorization", f"Bearer {token}"),) if token else (), "timeout": 30}
        serialise = type(message).SerializeToString
        try:
            if method.name in ("Watch", "WatchImages"):
                next(self.channel.stream_stream(name, serialise)(iter([message]), **arguments), None)
            elif method.name in ("Subscribe", "GetSheetRecording"):
                next(self.channel.unary_stream(name, serialise)(message, **arguments), None)
            elif method.name in ("UploadSheet", "ReplayRecording"):
                self.channel.stream_unary(name, serialise)(iter([message]), **arguments)
            else:
                self.channel.unary_unary(name, serialise)(message, **arguments)
        except self.grpc.RpcError as error:
            trailing = dict(error.trailing_metadata() or ())
            status = status_pb2.Status.FromString(trailing.get("grpc-status-details-bin", b""))
            for detail in status.details:
                info = error_details_pb2.ErrorInfo()
                if detail.Unpack(info):
                    return info.reason
            return error.code().name
        return ""

    def as_json(self, method, sheet, token):
        _, body = self.request(method, sheet)
        headers = {"Content-Type": "application/json", **({"Authorization": f"Bearer {token}"} if token else {})}
        address = f"{self.ready['http']}/{method.containing_service.full_name}/{method.name}"
        try:
            urllib.request.urlopen(urllib.request.Request(address, body.encode(), headers), timeout=30).close()
        except urllib.error.HTTPError as error:
            details = json.loads(error.read()).get("details", [])
            return next((each["reason"] for each in details if "reason" in each), "")
        return ""

    def test_the_page_is_right(self):
        expected = page()
        methods = [method for service in self.services() for method in service.methods]
        self.assertEqual(sorted(method.name for method in methods), sorted(expected), "server/access.md has each call once")
        for tenant in TENANTS:
            self.make_sheet(f"{tenant}-1", self.tokens[f"{tenant}-admin"])
        before = [self.state(f"{tenant}-1") for tenant in TENANTS]
        for method in methods:
            ways = [self.over_grpc] if method.name in STREAMS else [self.over_grpc, self.as_json]
            for ask in ways:
                with self.subTest(method.name, way=ask.__name__):
                    self.check(method, ask, expected[method.name])
                    self.check_tenants(method, ask, expected[method.name])
        self.assertEqual([self.state(f"{tenant}-1") for tenant in TENANTS], before, "nothing reached the other tenant's sheet")

    def call(self, name, body, token):
        headers = {"Content-Type": "application/json", "Authorization": f"Bearer {token}"}
        request = urllib.request.Request(f"{self.ready['http']}/kerf.v1.{name}", json.dumps(body).encode(), headers)
        with urllib.request.urlopen(request, timeout=30) as answer:
            return json.loads(answer.read())

    def make_sheet(self, sheet, token):
        grid = {"columns": 5, "rows": 5, "width_m": 1, "height_m": 1}
        self.call("SheetService/CreateSheet", {"sheet_id": sheet, "paused": True, "scene": {"grid": grid}}, token)

    def state(self, sheet):
        return self.call("SheetService/GetSheetState", {"name": f"sheets/{sheet}"}, self.tokens["admin"])["state_hash"]

    def check_tenants(self, method, ask, least):
        needed = SCOPES.index("admin" if least == "all" else least)
        makes_sheets = method.name in ("CreateSheet", "UploadSheet", "ReplayRecording")
        for tenant, other in (TENANTS, TENANTS[::-1]):
            for scope in SCOPES:
                reason = ask(method, f"{other}-1", self.tokens[f"{tenant}-{scope}"])
                if SCOPES.index(scope) < needed:
                    self.assertEqual(reason, "SCOPE_TOO_LOW", (tenant, scope))
                elif least == "all" or makes_sheets:
                    self.assertEqual(reason, "SHEET_NOT_ALLOWED", (tenant, scope))
                elif method.name in OF_THE_SERVER:
                    self.assertEqual(reason, "", (tenant, scope))
                else:
                    self.assertEqual(reason, "SHEET_NOT_FOUND", (tenant, scope))
                own = ask(method, f"{tenant}-none", self.tokens[f"{tenant}-{scope}"])
                if SCOPES.index(scope) < needed:
                    self.assertEqual(own, "SCOPE_TOO_LOW", (tenant, scope))
                else:
                    self.assertEqual(own == "SHEET_NOT_ALLOWED", least == "all", (tenant, scope))

    def check(self, method, ask, least):
        self.assertEqual(ask(method, "none", None), "TOKEN_MISSING")
        self.assertEqual(ask(method, "none", "kerf_admin_" + 43 * "A"), "TOKEN_UNKNOWN")
        needed = SCOPES.index("admin" if least == "all" else least)
        for scope in SCOPES:
            reason = ask(method, "none", self.tokens[scope])
            if SCOPES.index(scope) < needed:
                self.assertEqual(reason, "SCOPE_TOO_LOW", scope)
            else:
                self.assertNotIn(reason, ("SCOPE_TOO_LOW", "TOKEN_MISSING", "TOKEN_UNKNOWN", "SHEET_NOT_ALLOWED"), scope)
        # A token for one sheet does not reach another.
        foreign = ask(method, "none", self.tokens["mine"])
        makes_sheets = method.name in ("CreateSheet", "UploadSheet", "ReplayRecording")
        if least == "all" or makes_sheets:
            self.assertEqual(foreign, "SHEET_NOT_ALLOWED")
        elif method.name in OF_THE_SERVER:
            self.assertEqual(foreign, "")
        else:
            self.assertEqual(foreign, "SHEET_NOT_FOUND")
        if makes_sheets:
            self.assertNotEqual(ask(method, "mine", self.tokens["mine"]), "SHEET_NOT_ALLOWED")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    for name in ("kerfd", "kerf", "work"):
        parser.add_argument(f"--{name}", required=True)
    OPTIONS, rest = parser.parse_known_args()
    unittest.main(module="__main__", argv=[sys.argv[0], *rest])
