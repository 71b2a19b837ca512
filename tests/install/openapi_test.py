"""openapi.json has every JSON call that kerfd makes and no other, and is an OpenAPI 3.1 document that a real kerfd obeys."""

import argparse
import json
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
OPTIONS = None
sys.path.insert(0, str(ROOT / "deploy/site"))
import openapi  # pylint: disable=wrong-import-position

TYPES = {"object": dict, "array": list, "string": str, "boolean": bool, "integer": int, "number": (int, float)}


class Document:
    def __init__(self, content):
        self.content = content
        self.schemas = content["components"]["schemas"]

    def resolve(self, schema):
        while "$ref" in schema:
            schema = self.schemas[schema["$ref"].removeprefix("#/components/schemas/")]
        return schema

    def faults(self, value, schema, where="$"):
        """Yields what of a value its schema does not allow, for the words of JSON Schema that the document uses."""
        schema = self.resolve(schema)
        if "anyOf" in schema and all(list(self.faults(value, one)) for one in schema["anyOf"]):
            yield f"{where}: {value!r} is none of the choices"
        if "enum" in schema and value not in schema["enum"]:
            yield f"{where}: {value!r} is not in {schema['enum'][:5]}"
        kinds = schema.get("type", [])
        kinds = [kinds] if isinstance(kinds, str) else kinds
        if kinds and not any(isinstance(value, TYPES[kind]) and (kind == "boolean" or not isinstance(value, bool)) for kind in kinds):
            yield f"{where}: {value!r} is no {kinds}"
        elif isinstance(value, str) and not re.search(schema.get("pattern", ""), value):
            yield f"{where}: {value!r} is not like {schema['pattern']}"
        elif isinstance(value, dict):
            known, other = schema.get("properties", {}), schema.get("additionalProperties", True)
            for name in set(schema.get("required", ())) - set(value):
                yield f"{where} has no {name}"
            for name, part in value.items():
                if name in known:
                    yield from self.faults(part, known[name], f"{where}.{name}")
                elif other is False:
                    yield f"{where} has {name}"
                elif other is not True:
                    yield from self.faults(part, other, f"{where}.{name}")
        elif isinstance(value, list) and "items" in schema:
            for number, part in enumerate(value):
                yield from self.faults(part, schema["items"], f"{where}[{number}]")


def parts(value):
    yield value
    for part in value.values() if isinstance(value, dict) else value if isinstance(value, list) else ():
        yield from parts(part)


class OpenApi(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.document = Document(openapi.document())
        cls.process = subprocess.Popen([OPTIONS.kerfd, "--listen", "127.0.0.1:0", "--http", "127.0.0.1:0", "--data", "none", "--web", cls.web()],
                                       stdout=subprocess.PIPE, text=True)
        cls.http = json.loads(cls.process.stdout.readline())["http"]

    @classmethod
    def web(cls):
        """A viewer's folder with the file, as deploy/build-viewer leaves it."""
        folder = pathlib.Path(OPTIONS.work)
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        (folder / "index.html").write_text("<!DOCTYPE html><title>x</title>")
        subprocess.run(["/usr/bin/python3", ROOT / "deploy/site/openapi.py", folder / "openapi.json"], check=True)
        return str(folder)

    @classmethod
    def tearDownClass(cls):
        cls.process.send_signal(signal.SIGTERM)
        assert cls.process.wait(timeout=60) == 0
        cls.process.stdout.close()

    def post(self, path, body):
        request = urllib.request.Request(self.http + path, json.dumps(body).encode(), {"Content-Type": "application/json"})
        try:
            with urllib.request.urlopen(request, timeout=60) as reply:
                return reply.status, json.load(reply)
        except urllib.error.HTTPError as refused:
            with refused:
                return refused.code, json.load(refused)

    def calls(self):
        return {path: item["post"] for path, item in self.document.content["paths"].items() if "post" in item}

    def test_it_has_every_call_of_the_server_and_no_other(self):
        table = set(re.findall(r'method_of\("(/kerf\.v1\.\w+/\w+)"', (ROOT / "server/service/api/api.cc").read_text()))
        self.assertGreater(len(table), 35)
        self.assertLessEqual(table, set(self.calls()))
        for path in sorted(set(self.calls()) - table):
            self.assertEqual(self.post(path, {})[0], 404, f"{path} is a call of the server that its table lacks")

    def test_it_is_whole(self):
        content = self.document.content
        self.assertEqual(content["openapi"], "3.1.0")
        self.assertTrue(content["info"]["title"] and content["info"]["version"])
        names = [operation["operationId"] for item in content["paths"].values() for operation in item.values()]
        self.assertEqual(len(names), len(set(names)))
        tags = {tag["name"] for tag in content["tags"]}
        for path, item in content["paths"].items():
            for operation in item.values():
                self.assertTrue(operation["summary"] and operation["responses"]["200"]["description"], path)
                self.assertLessEqual(set(operation["tags"]), tags)
        referred = set(openapi.references(content))
        self.assertEqual(referred, set(self.document.schemas), "Each schema is there, and is used.")
        for name in self.document.schemas:
            self.assertRegex(name, r"^[a-zA-Z0-9._-]+$")
        self.assertFalse([part for part in parts(content) if isinstance(part, dict) and "$ref" in part and set(part) - {"$ref", "description"}])

    def test_faults_of_a_value_are_found(self):
        schema = {"$ref": "#/components/schemas/kerf.v1.StepSheetRequest"}
        self.assertEqual(list(self.document.faults({"name": "sheets/x", "ticks": 3}, schema)), [])
        for wrong in ({"name": 3}, {"nme": "x"}, {"ticks": "many"}, []):
            self.assertTrue(list(self.document.faults(wrong, schema)), wrong)

    def test_answers_are_as_described(self):
        scene = {"grid": {"columns": 6, "rows": 6, "width_m": 1, "height_m": 1}, "gravity_mps2": {"z": -9.81}}
        sent = {"/kerf.v1.SheetService/CreateSheet": {"sheet_id": "a", "scene": scene, "paused": True},
                "/kerf.v1.SheetService/StepSheet": {"name": "sheets/a", "ticks": 2},
                "/kerf.v1.CutService/CreateCut": {"parent": "sheets/a", "cut": {"curve": {"circle": {"center": {"x": 0.5, "y": 0.5}, "radius_m": 0.2}}}},
                "/kerf.v1.CutService/ListCuts": {"parent": "sheets/a"}, "/kerf.v1.CutService/ListPieces": {"parent": "sheets/a"},
                "/kerf.v1.SheetService/ListSheets": {}, "/kerf.v1.SheetService/GetSheetState": {"name": "sheets/a"},
                "/kerf.v1.ServerService/GetServerInfo": {}, "/kerf.v1.AccessService/GetAccess": {},
                "/kerf.v1.SheetService/DeleteSheet": {"name": "sheets/a"}}
        for path, body in sent.items():
            operation = self.calls()[path]
            self.assertEqual(list(self.document.faults(body, operation["requestBody"]["content"]["application/json"]["schema"])), [], path)
            status, answer = self.post(path, body)
            self.assertEqual(status, 200, f"{path}: {answer}")
            self.assertEqual(list(self.document.faults(answer, operation["responses"]["200"]["content"]["application/json"]["schema"])), [], path)
        status, answer = self.post("/kerf.v1.SheetService/GetSheet", {"name": "sheets/none"})
        refusal = self.calls()["/kerf.v1.SheetService/GetSheet"]["responses"]["default"]["content"]["application/json"]["schema"]
        self.assertEqual((status, list(self.document.faults(answer, refusal))), (404, []))
        self.assertEqual(answer["details"][0]["reason"], "SHEET_NOT_FOUND")

    def test_kerfd_serves_it_and_the_other_paths(self):
        for path in self.document.content["paths"]:
            if not path.startswith("/kerf."):
                with urllib.request.urlopen(self.http + path, timeout=60) as reply:
                    self.assertEqual((reply.status, reply.headers.get_content_type()), (200, "text/plain"), path)
        with urllib.request.urlopen(self.http + "/openapi.json", timeout=60) as reply:
            self.assertEqual(json.load(reply), self.document.content)
        self.assertIn("openapi.py dist/openapi.json", (ROOT / "deploy/build-viewer").read_text())


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    for option in ("--kerfd", "--work"):
        parser.add_argument(option, required=True)
    OPTIONS, rest = parser.parse_known_args()
    unittest.main(argv=[sys.argv[0]] + rest)
