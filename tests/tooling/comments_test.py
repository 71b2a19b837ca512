#!/usr/bin/python3
"""Reads the comments of every source in C++, TypeScript, Python, shell and Protocol Buffers, and finds those that are no plain
sentences: what begins with a bare "Of", "What", "Whether", "Where" or "How", and words that a native speaker would not use
there. Of Python, it leaves docstrings out. Comments of .proto files are the text of the API reference, so they are held to
more words, and to the length of their sentences.

    tests/tooling/comments_test.py             # as a test
    tests/tooling/comments_test.py FOLDER...   # lists what it finds there, with the number of words of long sentences
"""

import io
import pathlib
import re
import sys
import tokenize
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
FOLDERS = ("server", "render", "client", "tests", "web", "deploy", "proto", ".ci")
LEFT_OUT = {"node_modules", "gen", "dist", "data", "build", "blocking"}  # folders of others, or of made files
OPENERS = re.compile(r"(Of|What|Whether|Where|How|Whom|Whose)\b")
WORDS = re.compile(r"\b(told|goes on|go on|went on|but for|anew|nobody|somebody|likewise)\b", re.IGNORECASE)
REFERENCE_WORDS = re.compile(r"\b(all the same|one of which|that of|(?<!text )for people)\b", re.IGNORECASE)
MOST_WORDS = 25

# Literals first, so that a // within them is none.
TOKEN = re.compile(r'R"\((?:.|\n)*?\)"|`(?:\\.|[^`\\])*`|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])+\'|//[^\n]*|/\*(?:.|\n)*?\*/')


def blocks(source, language="C++"):
    """Returns the comments of a source as (line, text): those below each other, in the same column, are one."""
    found = []
    for line, column, is_alone, text in COMMENTS[language](source):
        if found and found[-1][3] == line - 1 and found[-1][2] == column and is_alone:
            found[-1] = (found[-1][0], found[-1][1] + " " + text, column, line)
        else:
            found.append((line, text, column, line))
    return [(line, text) for line, text, _, _ in found]


def slash_comments(source):
    for match in TOKEN.finditer(source):
        if match.group().startswith(("//", "/*")):
            column = match.start() - (source.rfind("\n", 0, match.start()) + 1)
            is_alone = not source[match.start() - column:match.start()].strip()
            text = re.sub(r"\s*\n\s*\*?\s*", " ", match.group().strip("/* "))
            yield source.count("\n", 0, match.start()) + 1, column, is_alone, text.strip()


def proto_comments(source):
    """Leaves out formulas, which are the lines that are set in."""
    lines = source.split("\n")
    return (comment for comment in slash_comments(source) if not lines[comment[0] - 1].lstrip().startswith("//   "))


def python_comments(source):
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.type == tokenize.COMMENT:
            line, column = token.start
            yield line, column, not token.line[:column].strip(), token.string.strip("# ")


def shell_comments(source):
    """Takes only the comments that have a line of their own: elsewhere a # may be part of a word or of a text."""
    for number, line in enumerate(source.split("\n"), 1):
        if line.lstrip().startswith("#") and not line.startswith("#!"):
            yield number, len(line) - len(line.lstrip()), True, line.strip("# ")


COMMENTS = {"C++": slash_comments, "TypeScript": slash_comments, "Python": python_comments, "shell": shell_comments,
            "proto": proto_comments}
SUFFIXES = {".h": "C++", ".cc": "C++", ".ts": "TypeScript", ".mjs": "TypeScript", ".py": "Python", ".sh": "shell", ".proto": "proto"}
MADE = ("_pb2", "_pb2_grpc")  # ends of the names of modules that protoc makes


def language_of(path):
    """Returns the language of a source, or None: by its ending, or by its first line if it has none."""
    if path.suffix or path.is_symlink():
        return SUFFIXES.get(path.suffix)
    with path.open("rb") as file:
        first = file.readline(80)
    if not first.startswith(b"#!"):
        return None
    return "Python" if b"python" in first else "shell" if b"sh" in first else None


def faults(text, language="C++"):
    """Says what is wrong with a comment."""
    if text.startswith(("NOLINT", "clang-format")):
        return []
    found = []
    if OPENERS.match(text):
        found.append(f"begins with \"{OPENERS.match(text).group()}\"")
    found += [f"says \"{word}\"" for word in WORDS.findall(text)]
    if language == "proto":
        found += [f"says \"{word}\"" for word in REFERENCE_WORDS.findall(text)] + long_sentences(text)
    return found


def long_sentences(text):
    return [f"a sentence of {len(sentence.split())} words" for sentence in re.split(r"(?<=[.;:])\s", text) if len(sentence.split()) > MOST_WORDS]


def sources(folders):
    for folder in folders:
        for path in sorted((ROOT / folder).rglob("*")):
            if not path.is_file() or path.stem.endswith(MADE) or LEFT_OUT & set(path.relative_to(ROOT).parts):
                continue
            if language := language_of(path):
                yield path, language


class Comments(unittest.TestCase):
    def test_are_plain_sentences(self):
        found = [f"{path.relative_to(ROOT)}:{line}: {fault}" for path, language in sources(FOLDERS)
                 for line, text in blocks(path.read_text(), language) for fault in faults(text, language)]
        self.assertEqual(found, [])

    def test_faults_are_found(self):
        source = 'int a;  // Of the sheet.\n// Returns x,\n// but for y.\nchar* b = "// What";\n/* Where it is. */\n'
        self.assertEqual([(line, faults(text)) for line, text in blocks(source)],
                         [(1, ['begins with "Of"']), (2, ['says "but for"']), (5, ['begins with "Where"'])])

    def test_faults_of_other_languages_are_found(self):
        for language, source in {"TypeScript": "/**\n * What it\n * says.\n */\nconst a = `// Of`;\n",
                                 "Python": "a = '# Of'\n# What it\n# says.\n", "shell": "#!/bin/sh\na='\n# What it\n# says.\n"}.items():
            found = [(text, faults(text)) for _, text in blocks(source, language)]
            self.assertEqual(found, [("What it says.", ['begins with "What"'])], language)

    def test_comments_of_the_reference_are_held_to_more(self):
        sentence = " ".join(["word"] * 26) + "."
        source = f"// A text for people.\n//   all the same = 1\nint32 a = 1;  // that of b; for people\n// {sentence}\n"
        self.assertEqual([(line, faults(text, "proto")) for line, text in blocks(source, "proto")],
                         [(1, []), (3, ['says "that of"', 'says "for people"']), (4, ["a sentence of 26 words"])])

    def test_every_language_is_read(self):
        self.assertEqual({language for _, language in sources(FOLDERS)}, set(COMMENTS))


def main():
    if len(sys.argv) == 1 or sys.argv[1].startswith("-"):
        return unittest.main()
    count = 0
    for path, language in sources(sys.argv[1:]):
        for line, text in blocks(path.read_text(), language):
            for fault in faults(text, language) + (long_sentences(text) if language != "proto" else []):
                count += 1
                print(f"{path.relative_to(ROOT)}:{line}: {fault}")
    print(count, "in all")


if __name__ == "__main__":
    main()
