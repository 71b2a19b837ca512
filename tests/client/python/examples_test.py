"""The examples, each as a user would run it, with small numbers."""

import support
from support import ROOT, Case

EXAMPLES = ROOT / "client/python/examples"


class Examples(Case):
    def run_example(self, name, *arguments):
        done = support.run_python(EXAMPLES / name, "--server", support.ADDRESS, *arguments)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout

    def test_cut_example(self):
        told = self.run_example("cut_example.py", self.sheet.id)
        self.assertIn("status: APPLIED", told)
        self.assertIn("pieces: 2", told)

    def test_no_server(self):
        done = support.run_python(EXAMPLES / "cut_example.py", "--server", "127.0.0.1:1")
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("start one with deploy/run", done.stderr)
