"""The files of deploy/grafana ask for metrics and labels that a real kerfd has, and the image of deploy/docker has what it names."""

import argparse
import json
import os
import pathlib
import re
import shutil
import signal
import ssl
import subprocess
import sys
import unittest
import urllib.request

import yaml

ROOT = pathlib.Path(__file__).resolve().parents[2]
GRAFANA = ROOT / "deploy/grafana"
DOCKER = ROOT / "deploy/docker"
OPTIONS = None
# Words of PromQL that are no metrics.
WORDS = {"sum", "by", "rate", "increase", "histogram_quantile", "or", "time", "resets", "up", "label_values"}
LABELS_OF_PROMETHEUS = {"job", "instance", "le"}


def server(*options):
    process = subprocess.Popen([OPTIONS.kerfd, "--listen", "127.0.0.1:0", "--http", "127.0.0.1:0", *options], stdout=subprocess.PIPE, text=True)
    return process, json.loads(process.stdout.readline())


def stop(process):
    process.send_signal(signal.SIGTERM)
    assert process.wait(timeout=60) == 0
    process.stdout.close()


def served():
    """The metrics of a server with all that has metrics, each with its labels."""
    key, certificate = f"{OPTIONS.work}/server.key", f"{OPTIONS.work}/server.pem"
    subprocess.run(["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-noenc", "-days", "30", "-subj", "/CN=localhost",
                    "-addext", "subjectAltName=IP:127.0.0.1", "-keyout", key, "-out", certificate], check=True, capture_output=True)
    os.mkdir(f"{OPTIONS.work}/recordings")
    process, ready = server("--data", f"{OPTIONS.work}/data", "--record", f"{OPTIONS.work}/recordings", "--tls-cert", certificate, "--tls-key", key)
    try:
        with urllib.request.urlopen(ready["http"] + "/metrics", context=ssl.create_default_context(cafile=certificate), timeout=60) as page:
            lines = [line for line in page.read().decode().splitlines() if not line.startswith("#")]
    finally:
        stop(process)
    found = {}
    for line in lines:
        name, labels = re.match(r"(\w+)(?:\{(.*)\})? ", line).groups()
        found.setdefault(name, {}).update({label: None for label in re.findall(r'(\w+)="', labels or "")})
    return found


def metrics_of(expression):
    """The metrics of an expression of PromQL, each with the labels by which it is chosen."""
    text = re.sub(r"\[[^]]*\]", "", expression)
    grouped = set(re.findall(r"\w+", " ".join(re.findall(r"by \(([^)]*)\)", text))))
    text = re.sub(r"by \([^)]*\)", "", text)
    for name, labels in re.findall(r"\b([a-z_][a-z_0-9]*)\b(?:\{([^}]*)\})?(?![\w(]*\()", re.sub(r'"[^"]*"', '""', text)):
        if name not in WORDS and not re.search(rf'[{{,]\s*{name}\s*=', text):
            yield name, set(re.findall(r"(\w+)\s*=", labels)) | grouped


class Monitoring(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.served = served()

    def check(self, expression, where):
        found = list(metrics_of(expression))
        self.assertTrue(found or expression.startswith("up"), where)
        for name, labels in found:
            self.assertIn(name, self.served, where)
            self.assertLessEqual(labels - LABELS_OF_PROMETHEUS, set(self.served[name]), f"{where}: labels of {name}")

    def test_metrics_are_read_from_expressions(self):
        self.assertEqual(list(metrics_of('sum by (state) (rate(kerf_a_total{job=~"$job", x="y"}[5m])) / kerf_b > 0 or time() - kerf_c')),
                         [("kerf_a_total", {"job", "x", "state"}), ("kerf_b", {"state"}), ("kerf_c", {"state"})])
        with self.assertRaises(AssertionError):
            self.check("rate(kerf_no_such_total[5m])", "")
        with self.assertRaises(AssertionError):
            self.check('kerf_sheets{colour="red"}', "")

    def test_the_dashboard(self):
        dashboard = json.loads((GRAFANA / "kerf-dashboard.json").read_text())
        panels = [panel for panel in dashboard["panels"] if panel["type"] != "row"]
        self.assertGreater(len(panels), 12)
        self.assertEqual(len({panel["id"] for panel in dashboard["panels"]}), len(dashboard["panels"]))
        places = set()
        for panel in panels:
            self.assertTrue(panel["description"] and panel["fieldConfig"]["defaults"]["unit"], panel["title"])
            at = panel["gridPos"]
            self.assertLessEqual(at["x"] + at["w"], 24, panel["title"])
            covers = {(x, y) for x in range(at["x"], at["x"] + at["w"]) for y in range(at["y"], at["y"] + at["h"])}
            self.assertFalse(places & covers, panel["title"])
            places |= covers
            for target in panel["targets"]:
                self.check(target["expr"], panel["title"])
        for variable in dashboard["templating"]["list"]:
            if variable["type"] == "query":
                self.check(variable["query"].removeprefix("label_values(").split(",")[0].split("{")[0], variable["name"])

    def test_the_alerts(self):
        file = GRAFANA / "kerf-alerts.yml"
        rules = [rule for group in yaml.safe_load(file.read_text())["groups"] for rule in group["rules"]]
        self.assertGreater(len(rules), 8)
        for rule in rules:
            self.assertEqual(set(rule) - {"for"}, {"alert", "expr", "labels", "annotations"}, rule)
            self.assertIn(rule["labels"]["severity"], ("warning", "critical"))
            self.assertEqual(set(rule["annotations"]), {"summary", "description"})
            self.check(rule["expr"], rule["alert"])
        configuration = yaml.safe_load((GRAFANA / "prometheus.yml").read_text())
        self.assertEqual(configuration["rule_files"], [file.name])
        self.assertIn(f'job="{configuration["scrape_configs"][0]["job_name"]}"', rules[0]["expr"])
        if shutil.which("promtool"):
            done = subprocess.run(["promtool", "check", "rules", file], capture_output=True, text=True)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)


class Image(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        text = (DOCKER / "Dockerfile").read_text().replace("\\\n", " ")
        cls.lines = [line.split(None, 1) for line in text.splitlines() if line and not line.startswith("#")]

    def all(self, instruction):
        return [rest for name, rest in self.lines if name == instruction]

    def last_json(self, instruction):
        text = self.all(instruction)[-1]
        return json.loads(text[text.index("["):])

    def test_what_is_copied_is_there(self):
        copies = [copy.split() for copy in self.all("COPY")]
        here = [copy for copy in copies if not copy[0].startswith("--from=")]
        self.assertEqual(len(here), 2)
        for *sources, _ in here:
            for source in sources:
                self.assertTrue((ROOT / source).exists(), source)
        stages = re.findall(r" AS (\w+)", "\n".join(self.all("FROM")))
        for copy in copies:
            if copy[0].startswith("--from="):
                self.assertIn(copy[0].removeprefix("--from="), stages)
        for command in self.all("RUN"):
            for script in re.findall(r"\b(deploy/[\w-]+)", command):
                self.assertTrue(os.access(ROOT / script, os.X_OK), script)
        for name in re.findall(r"--preset (\w+)", " ".join(self.all("RUN"))):
            self.assertIn(name, [preset["name"] for preset in json.loads((ROOT / "CMakePresets.json").read_text())["configurePresets"]])

    def test_packages_are_those_of_debian(self):
        for base in self.all("FROM"):
            self.assertRegex(base, r"^debian:bookworm(-slim)?( AS \w+)?$")
        packages = [word for command in self.all("RUN") for part in re.findall(r"apt-get install ([^&]*)", command)
                    for word in part.split() if not word.startswith(("-", "/"))]
        self.assertIn("libegl-mesa0", packages)
        for package in packages:
            known = subprocess.run(["apt-cache", "show", package], capture_output=True).returncode == 0
            installed = subprocess.run(["dpkg-query", "-W", package], capture_output=True).returncode == 0
            self.assertTrue(known or installed, package)

    def test_it_runs_as_a_user_with_a_health_check(self):
        user = (ROOT / "deploy/debian/postinst").read_text()
        self.assertEqual(self.all("USER"), ["kerf"])
        self.assertRegex(user, r"adduser --system .* kerf\n")
        entry, health = self.last_json("ENTRYPOINT"), self.last_json("HEALTHCHECK")
        self.assertEqual((entry[0], health[0]), ("kerfd", "kerf"))
        self.assertEqual(entry[-2:], ["--data", self.all("VOLUME")[0]])
        ports = self.all("EXPOSE")[0].split()
        self.assertEqual([address.rsplit(":", 1)[1] for address in entry if address.startswith("0.0.0.0:")], ports)
        options = [word for word in entry[1:-2] if not word.startswith("0.0.0.0:") and word not in ("--listen", "--http")]
        process, ready = server(*options, "--data", f"{OPTIONS.work}/volume")
        try:
            asked = subprocess.run([OPTIONS.kerf, "--server", ready["grpc"], *health[1:]], capture_output=True, text=True, timeout=60)
            self.assertEqual(asked.returncode, 0, asked.stderr)
        finally:
            stop(process)
        self.assertNotEqual(subprocess.run([OPTIONS.kerf, "--server", ready["grpc"], *health[1:]], capture_output=True, timeout=60).returncode, 0)

    def test_what_is_left_out_of_the_context(self):
        left_out = (DOCKER / "Dockerfile.dockerignore").read_text().split()
        self.assertIn("build", left_out)
        for needed in ("deploy", "server", "web", "CMakeLists.txt"):
            self.assertNotIn(needed, left_out)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    for option in ("--kerf", "--kerfd", "--work"):
        parser.add_argument(option, required=True)
    OPTIONS, rest = parser.parse_known_args()
    shutil.rmtree(OPTIONS.work, ignore_errors=True)
    os.makedirs(OPTIONS.work)
    unittest.main(argv=[sys.argv[0]] + rest)
