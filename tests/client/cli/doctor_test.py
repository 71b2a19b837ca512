"""`kerf version` and `kerf doctor` against a real kerfd, and on machines that lack something."""

import json
import os
import pathlib
import shutil
import socket
import subprocess

import cli_case
from cli_case import Case, address, closed_port, kerf, main, path, setUpModule, tearDownModule


def certificate(name, *dates):
    """A certificate that is good for `dates`, options of `openssl x509`."""
    key, file = path(f"{name}.key"), path(f"{name}.pem")
    for command in (("req", "-new", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-noenc", "-subj", "/CN=x", "-keyout", key, "-out", file + ".csr"),
                    ("x509", "-req", "-in", file + ".csr", "-signkey", key, "-out", file, *dates)):
        subprocess.run(("openssl", *command), check=True, capture_output=True)
    return file


class Version(Case):
    def test_of_both_sides(self):
        version = self.json_of("version")
        self.assertEqual(version["client"]["version"], version["server"]["version"])
        self.assertEqual((version["client"]["protocol"], version["server"]["address"]), ("kerf.v1", address()))
        self.assertEqual("kerf " + version["client"]["version"] + "\n", kerf("--version", server=False).stdout)
        self.assertIn(f"server   {version['server']['version']} at {address()}", kerf("version").stdout)

    def test_without_a_server_it_has_its_own(self):
        done = kerf("--server", closed_port(), "version", server=False)
        self.assertEqual(done.returncode, 0)
        self.assertIn(f"server   no Kerf server answers at {closed_port()}", done.stdout)
        version = json.loads(kerf("--json", "--server", closed_port(), "version", server=False).stdout)
        self.assertEqual((version["server"], version["server_failure"]), (None, f"no Kerf server answers at {closed_port()}"))


class Doctor(Case):
    def examine(self, *options, code=0, environment=None, before=""):
        """The findings by name; each has its level and the rest as text."""
        usual = (("--server", address()), ("--http", "127.0.0.1:0"))
        command = [cli_case.OPTIONS.kerf, "--json", "doctor", *options, *(word for option in usual if option[0] not in options for word in option)]
        done = subprocess.run(["bash", "-c", before + '"$@"', "bash", *command], capture_output=True, text=True, timeout=120,
                              env={**os.environ, **(environment or {})})
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        report = json.loads(done.stdout)
        for level in ("problem", "warning"):
            self.assertEqual(report[level + "s"], sum(each["level"] == level for each in report["findings"]))
        for each in report["findings"]:
            self.assertEqual(each["level"] != "ok", bool(each["advice"]), each)
        return {each["name"]: (each["level"], each["text"] + " -> " + each["advice"]) for each in report["findings"]}

    def test_a_machine_that_has_what_is_needed(self):
        found = self.examine("--data", path("data"))
        self.assertEqual(set(found), {"server", "kerfd", "pictures", "port of gRPC", "port of HTTP", "processors", "memory", "open files", "data folder"})
        for name in ("server", "kerfd", "port of gRPC", "port of HTTP", "data folder"):
            self.assertEqual(found[name][0], "ok", found[name])
        self.assertFalse(os.path.exists(path("data")))
        plain = kerf("doctor", "--data", "none", "--http", "127.0.0.1:0")
        self.assertRegex(plain.stdout, rf"(?m)^ok +server +version .* at {address()}$")
        self.assertRegex(plain.stdout, r"\n\d+ problems, \d+ warnings\n$")

    def test_no_server_is_a_warning_and_with_strict_an_exit_code(self):
        found = self.examine("--server", closed_port(), "--data", "none")
        self.assertEqual(found["server"][0], "warning")
        self.assertIn("start one with kerfd", found["server"][1])
        self.examine("--server", closed_port(), "--data", "none", "--strict", code=3)

    def test_ports_that_are_taken(self):
        with socket.create_server(("127.0.0.1", 0)) as other:
            taken = f"127.0.0.1:{other.getsockname()[1]}"
            found = self.examine("--http", taken, "--data", "none")
        self.assertEqual(found["port of HTTP"][0], "warning")
        self.assertIn("Address already in use", found["port of HTTP"][1])
        self.assertEqual(self.examine("--http", "nonsense", "--data", "none", code=3)["port of HTTP"][0], "problem")

    def test_data_folders_that_cannot_be_written(self):
        pathlib.Path(path("file")).write_text("")
        found = self.examine("--data", path("file/below"), code=3)
        self.assertIn("is no folder", found["data folder"][1])
        found = self.examine("--data", "/proc/kerf", code=3) if os.geteuid() != 0 else {"data folder": ("problem", "")}
        self.assertEqual(found["data folder"][0], "problem")
        found = self.examine(code=3, before="unset HOME XDG_DATA_HOME; ")
        self.assertIn("neither XDG_DATA_HOME nor HOME", found["data folder"][1])

    def test_certificates_and_their_dates(self):
        for name, dates, level, code, says in (("good", ("-days", "100"), "ok", 0, "is valid until"), ("soon", ("-days", "3"), "warning", 0, "renew it"),
                                               ("late", ("-days", "-1"), "problem", 3, "expired on")):
            found = self.examine("--data", "none", "--certificate", certificate(name, *dates), code=code)
            self.assertEqual(found["certificate"][0], level, found)
            self.assertIn(says, found["certificate"][1])
        pathlib.Path(path("none.pem")).write_text("nothing")
        for file, says in ((path("none.pem"), "no certificate in PEM form"), (path("missing.pem"), "cannot be read")):
            self.assertIn(says, self.examine("--data", "none", "--certificate", file, code=3)["certificate"][1])

    def test_limits_of_open_files(self):
        for limit, level, code in (("64", "problem", 3), ("2000", "warning", 0)):
            found = self.examine("--data", "none", code=code, before=f"ulimit -n {limit}; ")
            self.assertEqual(found["open files"][0], level)
            self.assertIn(f"at most {limit} ", found["open files"][1])

    def test_tokens_that_others_can_read(self):
        token = pathlib.Path(path("token"))
        token.write_text("secret-of-this-test\n")
        for mode, level in ((0o600, "ok"), (0o644, "warning")):
            token.chmod(mode)
            self.assertEqual(self.examine("--data", "none", "--token-file", str(token))["token"][0], level)

    def test_a_kerfd_of_another_version_or_none(self):
        folder = pathlib.Path(path("bin"))
        folder.mkdir()
        shutil.copy(cli_case.OPTIONS.kerf, folder / "kerf")  # It looks beside itself.

        def findings():
            done = subprocess.run([folder / "kerf", "--json", "--server", address(), "doctor", "--data", "none"], capture_output=True, text=True,
                                  env={**os.environ, "PATH": "/usr/bin:/bin"})
            return {each["name"]: each for each in json.loads(done.stdout)["findings"]}

        self.assertEqual((findings()["kerfd"]["level"], "pictures" in findings()), ("warning", False))
        other = folder / "kerfd"
        other.write_text("#!/bin/sh\n[ $1 = --version ] && echo kerfd 0.0.1 || echo 'none: no EGL here'\n")
        other.chmod(0o755)
        self.assertIn("is kerfd 0.0.1", findings()["kerfd"]["text"])
        self.assertEqual(findings()["pictures"]["level"], "warning")
        other.write_text("#!/bin/sh\nexit 7\n")
        self.assertEqual(findings()["kerfd"]["level"], "problem")


if __name__ == "__main__":
    main(__doc__)
