#!/usr/bin/python3
"""Checks that no library that decides the state of a sheet calls a function whose bits depend on the processor.

The C library has variants of these functions with fused multiply-add, and picks one at run time. The libraries take
server/base/elementary.h instead. Their symbols are checked, as templates of Eigen and Spectra call such functions, too.
"""

import re
import subprocess
import sys
import tempfile
import unittest

VARYING = re.compile(r"(sin|cos|tan|sincos|asin|acos|atan|atan2|sinh|cosh|tanh|asinh|acosh|atanh|exp|exp2|exp10|expm1|"
                     r"log|log2|log10|log1p|pow|erfc?|[lt]gamma|c(sin|cos|tan|exp|log|pow)|carg)[fl]?")
LIBRARIES = []


def varying_calls(path):
    command = ["nm", "--undefined-only", "--format=posix", path]
    listed = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    return {name for name in re.findall(r"^(\w+) U", listed, re.MULTILINE) if VARYING.fullmatch(name)}


class Elementary(unittest.TestCase):
    def test_libraries_call_no_function_that_varies(self):
        self.assertTrue(LIBRARIES)
        for path in LIBRARIES:
            with self.subTest(library=path):
                self.assertEqual(varying_calls(path), set(), "take server/base/elementary.h instead")

    def test_a_call_is_seen(self):
        with tempfile.TemporaryDirectory() as folder:
            built = folder + "/call.o"
            source = b"double cos(double); double hypot(double, double); double f(double x) { return cos(hypot(x, x)); }"
            subprocess.run(["c++", "-x", "c++", "-fno-builtin", "-c", "-o", built, "-"], input=b'extern "C" {%s}' % source,
                           check=True)
            self.assertEqual(varying_calls(built), {"cos"})


if __name__ == "__main__":
    LIBRARIES = [argument for argument in sys.argv[1:] if argument.endswith(".a")]
    unittest.main(argv=[argument for argument in sys.argv if not argument.endswith(".a")])
