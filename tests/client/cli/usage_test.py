"""`kerf` misused: help, wrong words, names that are near, no server."""

from cli_case import Case, kerf, main, setUpModule, tearDownModule


class Usage(Case):
    def test_help_and_version(self):
        for command in ([], ["sheet"], ["sheet", "create"], ["cut"], ["cuts"], ["undo"], ["redo"], ["pieces"], ["render"], ["watch"], ["export"], ["run"], ["replay"], ["analyze"], ["load"]):
            done = kerf(*command, "--help", server=False)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertIn("Usage", done.stdout)
        self.assertIn("kerf ", kerf("--version", server=False).stdout)

    def test_wrong_usage(self):
        for command in ([], ["fly"], ["sheet"], ["sheet", "create"], ["cut", "a", "--spline", "x"],
                        ["sheet", "create", "a", "--grid", "big"], ["sheet", "create", "a", "--pin", "left"],
                        ["sheet", "step", "a", "many"], ["watch", "a", "--frames", "-1"]):
            self.assertEqual(kerf(*command, server=False).returncode, 2, command)

    def test_no_server(self):
        done = kerf("--server", "127.0.0.1:1", "sheet", "list", server=False)
        self.assertEqual(done.returncode, 1)
        self.assertIn("no Kerf server answers at 127.0.0.1:1", done.stderr)


if __name__ == "__main__":
    main(__doc__)
