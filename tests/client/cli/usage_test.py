"""`kerf` misused: help, wrong words, names that are near, no server."""

import json
import os
import pathlib
import unittest.mock

from cli_case import Case, closed_port, kerf, main, path, scene_file, setUpModule, tearDownModule


class Usage(Case):
    def test_help_and_version(self):
        for command in ([], ["sheet"], ["sheet", "create"], ["cut"], ["cuts"], ["undo"], ["redo"], ["pieces"], ["render"], ["watch"], ["export"], ["run"], ["replay"], ["inspect"], ["analyze"], ["load"], ["open"], ["access"]):
            done = kerf(*command, "--help", server=False)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertIn("Usage", done.stdout)
        self.assertIn("kerf ", kerf("--version", server=False).stdout)

    def test_wrong_usage(self):
        for command in ([], ["fly"], ["sheet"], ["sheet", "create"], ["cut", "a", "--spline", "x"],
                        ["sheet", "create", "a", "--grid", "big"], ["sheet", "create", "a", "--pin", "left"],
                        ["sheet", "step", "a", "many"], ["sheet", "step", "a", "0"], ["sheet", "step", "a", "100001"], ["watch", "a", "--frames", "-1"]):
            self.assertEqual(kerf(*command, server=False).returncode, 2, command)

    def test_refusals_are_json_with_json(self):
        for command, code, wanted in (
                (["sheet", "get", "nobody"], 1, {"code": "NOT_FOUND", "reason": "SHEET_NOT_FOUND", "field": "name"}),
                (["run", path("missing.json")], 1, {"code": "NOT_FOUND", "reason": "FILE_NOT_FOUND"}),
                (["sheet", "create", "a", "--grid", "big"], 2, {"code": "INVALID_ARGUMENT", "reason": "WRONG_USAGE", "field": ""}),
                (["fly"], 2, {"code": "INVALID_ARGUMENT", "reason": "WRONG_USAGE"})):
            plain, done = kerf(*command), kerf("--json", *command)
            self.assertEqual((plain.returncode, done.returncode, done.stdout), (code, code, ""), command)
            self.assertTrue(plain.stderr.startswith("kerf: "), plain.stderr)
            error = json.loads(done.stderr)["error"]
            self.assertEqual(list(error), ["code", "reason", "message", "field"])
            self.assertEqual({name: error[name] for name in wanted}, wanted)
            self.assertTrue(error["message"])
        nowhere = kerf("--json", "--server", closed_port(), "sheet", "list", server=False)
        self.assertEqual(json.loads(nowhere.stderr)["error"]["code"], "UNAVAILABLE")

    def test_what_cannot_be_printed_is_told(self):
        for command in (["info"], ["--json", "sheet", "list"], ["completion", "bash"]):
            with open("/dev/full", "w") as full:
                done = kerf(*command, stdout=full)
            self.assertEqual(done.returncode, 1, command)
            self.assertIn("cannot write standard output: No space left on device", done.stderr)

    def test_other_names_of_commands(self):
        self.assertEqual(kerf("sheet", "create", "short-lived", "--grid", "4x4").returncode, 0)
        self.assertIn("sheets/short-lived", kerf("sheet", "ls").stdout)
        self.assertEqual(kerf("sheet", "rm", "short-lived").stdout, "sheets/short-lived deleted\n")
        self.refused("snip", "demo", code=2, says='`kerf` has no command "snip"; did you mean cut?')

    def test_a_server_without_a_port_has_the_usual_one(self):
        done = kerf("--server", "127.255.255.254", "sheet", "list", server=False)
        self.assertIn("no Kerf server answers at 127.255.255.254:50051", done.stderr)

    def test_a_sheet_is_a_line_and_more_on_request(self):
        made = kerf("sheet", "create", "concise", "--grid", "4x4")
        self.assertRegex(made.stdout, r"^sheets/concise .* real time\n$")
        self.assertIn("explicit", kerf("sheet", "get", "concise").stdout)
        self.assertIn("explicit", kerf("sheet", "pause", "concise", "--verbose").stdout)
        softened = kerf("sheet", "create", "soft", "--material", "wool", "--fidelity", "real-time").stdout
        self.assertRegex(softened, r"\n  membrane \d+ times softer to keep up with real time; expected error \d[\d.]* mm\n$")
        for name in ("concise", "soft"):
            self.json_of("sheet", "delete", name)

    def test_the_environment_names_files_of_tokens_and_tls(self):
        missing = path("no-such-file")
        for variable, option in (("KERF_TOKEN_FILE", "--token-file"), ("KERF_TLS_CA", "--tls-ca")):
            with unittest.mock.patch.dict(os.environ, {variable: missing}):
                done = self.refused("info", says=f"No such file or directory [field: {option}]")
                error = json.loads(kerf("--json", "info").stderr)["error"]
            self.assertIn(missing, done.stderr)
            self.assertEqual((error["code"], error["reason"], error["field"]), ("INVALID_ARGUMENT", "CREDENTIALS_UNREADABLE", option))
        for variable, field in (("KERF_TLS_CERT", "--tls-key"), ("KERF_TLS_KEY", "--tls-cert")):
            with unittest.mock.patch.dict(os.environ, {variable: missing}):
                self.refused("sheet", "list", says=f"[field: {field}] (INVALID_ARGUMENT, TLS_PAIR_INCOMPLETE)")

    def test_commands_without_a_server_need_no_token(self):
        with unittest.mock.patch.dict(os.environ, {"KERF_TOKEN_FILE": path("no-such-file")}):
            self.assertEqual(kerf("run", scene_file("tokenless.json"), server=False).returncode, 0)

    def test_a_token_is_sent_to_a_server_that_asks_for_none(self):
        pathlib.Path(path("token")).write_text("kerf_laptop_secret\n")
        self.assertEqual(kerf("--token-file", path("token"), "sheet", "list").returncode, 0)
        far = kerf("--server", "kerf.example.org", "--token-file", path("token"), "sheet", "list", server=False)
        self.assertEqual(far.returncode, 1)
        self.assertIn("not sent to kerf.example.org:50051 in the clear, where others could read it: use TLS", far.stderr)
        self.assertNotIn("secret", far.stderr)

    def test_a_server_without_tls_is_refused_in_one_line_of_json(self):
        done = kerf("--json", "--tls", "info")
        self.assertEqual(json.loads(done.stderr)["error"]["reason"], "TLS_FAILED")

    def test_no_server(self):
        done = kerf("--server", closed_port(), "sheet", "list", server=False)
        self.assertEqual(done.returncode, 1)
        self.assertIn(f"no Kerf server answers at {closed_port()}", done.stderr)


if __name__ == "__main__":
    main(__doc__)
