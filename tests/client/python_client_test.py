"""The Python client against a real kerfd: every test of tests/client/python, or those that -k names."""

import argparse
import pathlib
import sys
import unittest

FOLDER = pathlib.Path(__file__).resolve().parent / "python"
sys.path.insert(0, str(FOLDER))

import support  # noqa: E402: beside the tests that import it


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--kerf", required=True)
    parser.add_argument("--kerfd", required=True)
    parser.add_argument("--work", required=True)
    parser.add_argument("--only", default="*_test.py", help="files of tests, as a pattern")
    options, rest = parser.parse_known_args()
    support.begin(options)
    arguments = [sys.argv[0], "discover", "-s", str(FOLDER), "-p", options.only, *rest]
    try:
        passed = unittest.main(module=None, argv=arguments, exit=False).result.wasSuccessful()
    finally:
        support.stop_server(support.PROCESS)
    sys.exit(not passed)


if __name__ == "__main__":
    main()
