#!/usr/bin/python3
"""Reads the comments of every C++ source and finds those that are no plain sentences: what begins with a bare "Of", "What",
"Whether", "Where" or "How", and words that a native speaker would not use there.

    tests/tooling/comments_test.py             # as a test
    tests/tooling/comments_test.py FOLDER...   # lists what it finds there, with the number of words of long sentences
"""

import pathlib
import re
import sys
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
FOLDERS = ("server", "render", "client", "tests")
OPENERS = re.compile(r"(Of|What|Whether|Where|How|Whom|Whose)\b")
WORDS = re.compile(r"\b(told|goes on|go on|went on|but for|anew|nobody|somebody|likewise)\b", re.IGNORECASE)
MOST_WORDS = 25

# Literals first, so that a // within them is none.
TOKEN = re.compile(r'R"\((?:.|\n)*?\)"|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])+\'|//[^\n]*|/\*(?:.|\n)*?\*/')


def blocks(source):
    """Comments of a source as (line, text): lines of // below each other, in the same column, are one."""
    found = []
    for match in TOKEN.finditer(source):
        text = match.group()
        if not text.startswith(("//", "/*")):
            continue
        line = source.count("\n", 0, match.start()) + 1
        column = match.start() - (source.rfind("\n", 0, match.start()) + 1)
        is_alone = not source[match.start() - column:match.start()].strip()
        text = text.strip("/* ")
        if found and found[-1][3] == line - 1 and found[-1][2] == column and is_alone:
            first, before, _, _, alone = found[-1]
            found[-1] = (first, before + " " + text, column, line, alone)
        else:
            found.append((line, text, column, line, is_alone))
    return [(line, text) for line, text, _, _, _ in found]


def faults(text):
    """Says what is wrong with a comment."""
    if text.startswith(("NOLINT", "clang-format")):
        return []
    found = []
    if OPENERS.match(text):
        found.append(f"begins with \"{OPENERS.match(text).group()}\"")
    return found + [f"says \"{word}\"" for word in WORDS.findall(text)]


def long_sentences(text):
    return [len(sentence.split()) for sentence in re.split(r"(?<=[.;:])\s", text) if len(sentence.split()) > MOST_WORDS]


def sources(folders):
    for folder in folders:
        for path in sorted((ROOT / folder).rglob("*")):
            if path.suffix in (".h", ".cc") and "node_modules" not in path.parts:
                yield path


class Comments(unittest.TestCase):
    def test_are_plain_sentences(self):
        found = [f"{path.relative_to(ROOT)}:{line}: {fault}" for path in sources(FOLDERS)
                 for line, text in blocks(path.read_text()) for fault in faults(text)]
        self.assertEqual(found, [])

    def test_faults_are_found(self):
        source = 'int a;  // Of the sheet.\n// Returns x,\n// but for y.\nchar* b = "// What";\n/* Where it is. */\n'
        self.assertEqual([(line, faults(text)) for line, text in blocks(source)],
                         [(1, ['begins with "Of"']), (2, ['says "but for"']), (5, ['begins with "Where"'])])


def main():
    if len(sys.argv) == 1 or sys.argv[1].startswith("-"):
        return unittest.main()
    count = 0
    for path in sources(sys.argv[1:]):
        for line, text in blocks(path.read_text()):
            for fault in faults(text) + [f"a sentence of {words} words" for words in long_sentences(text)]:
                count += 1
                print(f"{path.relative_to(ROOT)}:{line}: {fault}")
    print(count, "in all")


if __name__ == "__main__":
    main()
