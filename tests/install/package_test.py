"""The Debian package that cpack makes of this build: its files, what it depends on, its scripts, its service, and its programs as they
run from where it is unpacked. tests/install/clean_root installs it."""

import argparse
import configparser
import gzip
import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import unittest
import urllib.request

ROOT = pathlib.Path(__file__).resolve().parents[2]
DEBIAN = ROOT / "deploy/debian"
UNIT = ROOT / "deploy/systemd/kerfd.service"
OPTIONS = None


def run(*command, **options):
    return subprocess.run([str(word) for word in command], capture_output=True, text=True, timeout=300, **options)


class Package(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        shutil.rmtree(OPTIONS.work, ignore_errors=True)
        os.makedirs(OPTIONS.work)
        done = run("cpack", "--config", f"{OPTIONS.build}/CPackConfig.cmake", "-G", "DEB", "-B", OPTIONS.work)
        assert done.returncode == 0, done.stdout + done.stderr
        cls.file, = pathlib.Path(OPTIONS.work).glob("*.deb")
        cls.root, cls.control = pathlib.Path(OPTIONS.work, "root"), pathlib.Path(OPTIONS.work, "control")
        for option, folder in (("-x", cls.root), ("-e", cls.control)):
            done = run("dpkg-deb", option, cls.file, folder)
            assert done.returncode == 0, done.stderr

    def field(self, name):
        done = run("dpkg-deb", "-f", self.file, name)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout.strip()

    def test_files(self):
        for name in ("usr/bin/kerfd", "usr/bin/kerf", "lib/systemd/system/kerfd.service", "etc/kerf/kerfd.conf", "usr/share/man/man1/kerfd.1.gz",
                     "usr/share/bash-completion/completions/kerf", "usr/share/zsh/vendor-completions/_kerf", "usr/share/fish/vendor_completions.d/kerf.fish",
                     "usr/share/doc/kerf/copyright", "usr/share/doc/kerf/changelog.gz", "usr/share/doc/kerf/changelog.Debian.gz",
                     "usr/share/doc/kerf/third-party/libeigen3-dev", "usr/share/doc/kerf/examples/grafana/kerf-dashboard.json"):
            self.assertTrue((self.root / name).is_file(), name)
        self.assertIn(b".TH", gzip.decompress((self.root / "usr/share/man/man1/kerf.1.gz").read_bytes())[:2000])
        listed = run("dpkg-deb", "-c", self.file).stdout.splitlines()
        for line in listed:
            mode, owner, *_, path = line.split()
            self.assertEqual(owner, "root/root", line)
            self.assertNotIn("w", mode[4:], line)
            self.assertNotRegex(path, r"^\./(usr/(local|include)|home|work|build)(/|$)|\.a$", line)
            self.assertRegex(path, r"^\./(?!usr/lib)|^\./usr/lib/([\w-]+/)?(libkerf_local\.so)?$", line)
        for program in ("kerf", "kerfd"):
            self.assertIn("stripped", run("file", self.root / "usr/bin" / program).stdout if shutil.which("file") else "stripped")
            self.assertNotIn(os.fsencode(OPTIONS.build), (self.root / "usr/bin" / program).read_bytes())

    def test_control(self):
        version = re.search(r"project\(kerf VERSION (\S+)", (ROOT / "CMakeLists.txt").read_text()).group(1)
        self.assertEqual((self.field("Package"), self.field("Version")), ("kerf", f"{version}-1"))
        depends = self.field("Depends")
        for package in ("adduser", "init-system-helpers", "libc6 (>=", "libgrpc++1.", "libprotobuf", "libsqlite3-0", "libssl3", "libegl1"):
            self.assertIn(package, depends)
        self.assertNotIn("-dev", depends)
        self.assertIn("libgl1-mesa-dri", self.field("Recommends"))
        conffiles = (self.control / "conffiles").read_text().split()
        in_etc = ["/" + str(path.relative_to(self.root)) for path in (self.root / "etc").rglob("*") if path.is_file()]
        self.assertEqual(conffiles, in_etc)

    def test_scripts(self):
        for name in ("postinst", "prerm", "postrm"):
            script = self.control / name
            self.assertTrue(os.access(script, os.X_OK), name)
            self.assertEqual(run("sh", "-n", script).returncode, 0, name)
            text = script.read_text()
            self.assertIn("\nset -e\n", text)
            for call in re.findall(r"deb-systemd-\w+ [\w -]*?(\S+\.service)", text):
                self.assertEqual(call, UNIT.name)

    def service(self):
        parser = configparser.ConfigParser(strict=False, interpolation=None, allow_no_value=True)
        parser.optionxform = str
        parser.read(self.root / "lib/systemd/system" / UNIT.name)
        return parser["Service"]

    def test_the_service_is_right_and_closed(self):
        unit = pathlib.Path(OPTIONS.work, UNIT.name)  # As installed: a program where the unit says it is.
        unit.write_text(UNIT.read_text().replace("/usr/bin/kerfd", str(self.root / "usr/bin/kerfd")).replace("man:kerfd(1) ", ""))
        if shutil.which("systemd-analyze"):
            done = run("systemd-analyze", "verify", unit)
            self.assertEqual((done.returncode, done.stderr), (0, ""))
            done = run("systemd-analyze", "security", "--offline=yes", "--threshold=20", UNIT)
            self.assertEqual(done.returncode, 0, done.stdout[-400:])
        service, text = self.service(), UNIT.read_text()
        self.assertEqual(service["User"], "kerf")
        for without in (r"^ProcSubset=pid", r"^SystemCallFilter=.*@resources", r"^MemoryDenyWriteExecute=(yes|true)"):
            self.assertIsNone(re.search(without, text, re.MULTILINE), without)
        self.assertIn(f"/var/lib/{service['StateDirectory']}", service["ExecStart"])
        self.assertIn(service["EnvironmentFile"].removeprefix("-"), (self.control / "conffiles").read_text())

    def test_the_service_starts_with_its_configuration(self):
        """The command of the unit with the options of the configuration, but with ports and folders of this test."""
        options = re.search(r'^KERFD_OPTIONS="(.*)"$', (self.root / "etc/kerf/kerfd.conf").read_text(), re.MULTILINE).group(1)
        command = self.service()["ExecStart"].replace("$KERFD_OPTIONS", options).replace("/var/lib/kerf", f"{OPTIONS.work}/data")
        program, *words = re.sub(r"(127\.0\.0\.1):\d+", r"\1:0", command).split()
        server = subprocess.Popen([str(self.root) + program, *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd="/")
        try:
            ready = json.loads(server.stdout.readline())
            kerf = self.root / "usr/bin/kerf"
            self.assertEqual(run(kerf, "--server", ready["grpc"], "sheet", "create", "a", "--grid", "4x4").returncode, 0)
            found = json.loads(run(kerf, "--server", ready["grpc"], "--json", "doctor", "--data", f"{OPTIONS.work}/data", "--http", "127.0.0.1:0").stdout)
            self.assertIn(str(self.root / "usr/bin/kerfd"), next(each["text"] for each in found["findings"] if each["name"] == "kerfd"))
            if (self.root / "usr/share/kerf/web/index.html").exists():  # The viewer was built before the package.
                for path in ("/", "/openapi.json"):
                    with urllib.request.urlopen(ready["http"] + path, timeout=60) as reply:
                        self.assertEqual(reply.status, 200, path)
        finally:
            server.send_signal(signal.SIGTERM)
            _, errors = server.communicate(timeout=60)
        self.assertEqual(server.returncode, 0, errors)

    def test_lintian_finds_no_error(self):
        if not shutil.which("lintian"):
            self.skipTest("lintian is not installed")
        done = run("lintian", "--fail-on", "error", "--allow-root", self.file)
        self.assertEqual(done.returncode, 0, done.stdout)


class Root(unittest.TestCase):
    """The script that installs the package in a clean root is run by `deploy/test long package`."""

    def test_its_shell_is_right(self):
        script = ROOT / "tests/install/clean_root"
        self.assertTrue(os.access(script, os.X_OK))
        self.assertEqual(run("bash", "-n", script).returncode, 0)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    for option in ("--build", "--work"):
        parser.add_argument(option, required=True)
    OPTIONS, rest = parser.parse_known_args()
    unittest.main(argv=[sys.argv[0]] + rest)
