#!/usr/bin/python3
"""Reads the comments of every source in C++, TypeScript, Python, shell and Protocol Buffers, and the docstrings of Python. It
finds those that are no plain sentences:

- they begin with a bare "Of", "What", "Whether", "Where" or "How",
- they have words that a native speaker would not use there,
- or a sentence has more than 25 words. sentences() and num_words() say how formulas, tables and examples are left out.

Comments of .proto files are the text of the API reference, so more words are refused there. Their lines end at column 120,
which clang-format does for C++. Other sources have at most 400 lines.

    tests/tooling/comments_test.py             # as a test
    tests/tooling/comments_test.py FOLDER...   # lists what it finds there
"""

import ast
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
MOST_WORDS = 25  # of a sentence
MOST_COLUMNS = 120  # of .proto files, which no formatter reads
MOST_LINES = 400  # of all other sources

# Literals first, so that a // within them is none.
TOKEN = re.compile(r'R"\((?:.|\n)*?\)"|`(?:\\.|[^`\\])*`|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])+\'|//[^\n]*|/\*(?:.|\n)*?\*/')


def blocks(source, language="C++"):
    """Returns the comments of a source as (line, text): those below each other, in the same column, are one. Each line of a
    text keeps the spaces by which it is set in."""
    found = []
    for line, column, is_alone, text in COMMENTS[language](source):
        if found and found[-1][3] == line - 1 and found[-1][2] == column and is_alone:
            found[-1] = (found[-1][0], found[-1][1] + "\n" + text, column, line)
        else:
            found.append((line, text, column, line))
    return [(line, text) for line, text, _, _ in found]


def slash_comments(source):
    for match in TOKEN.finditer(source):
        if match.group().startswith(("//", "/*")):
            column = match.start() - (source.rfind("\n", 0, match.start()) + 1)
            is_alone = not source[match.start() - column:match.start()].strip()
            lines = re.sub(r"^/[/*]+|\*/$", "", match.group()).split("\n")
            text = "\n".join([without_space(lines[0])] + [without_space(re.sub(r"^\s*\*", "", line)) for line in lines[1:]])
            yield source.count("\n", 0, match.start()) + 1, column, is_alone, text.strip("\n")


def without_space(line):
    """Removes the one space that follows the sign of a comment."""
    return line.removeprefix(" ").rstrip()


def proto_comments(source):
    """Leaves out formulas, which are the lines that are set in."""
    lines = source.split("\n")
    return (comment for comment in slash_comments(source) if not lines[comment[0] - 1].lstrip().startswith("//   "))


def python_comments(source):
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.type == tokenize.COMMENT:
            line, column = token.start
            yield line, column, not token.line[:column].strip(), without_space(token.string.lstrip("#"))
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)) and ast.get_docstring(node):
            yield node.body[0].lineno, node.body[0].col_offset, False, ast.get_docstring(node)


def shell_comments(source):
    """Takes only the comments that have a line of their own: elsewhere a # may be part of a word or of a text."""
    for number, line in enumerate(source.split("\n"), 1):
        if line.lstrip().startswith("#") and not line.startswith("#!"):
            yield number, len(line) - len(line.lstrip()), True, without_space(line.lstrip().lstrip("#"))


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
    plain = " ".join(text.split())
    if plain.startswith(("NOLINT", "clang-format")):
        return []
    found = []
    if OPENERS.match(plain):
        found.append(f"begins with \"{OPENERS.match(plain).group()}\"")
    found += [f"says \"{word}\"" for word in WORDS.findall(plain)]
    if language == "proto":
        found += [f"says \"{word}\"" for word in REFERENCE_WORDS.findall(plain)]
    return found + [f"a sentence of {num_words(sentence)} words: {sentence}" for sentence in sentences(text)
                    if num_words(sentence) > MOST_WORDS]


def sentences(text):
    """Returns the sentences of a comment. Each of these begins one, too:

    - a line after an empty line, or with another indentation than the line before, such as that of a formula,
    - an item of a list; its further lines are set in as far as its first word,
    - a @param.

    Two things are no sentences and are left out:

    - tables and drawings, which are lines with two spaces or more between words, except after a full stop,
    - examples of docstrings, which are the lines from >>> to the next empty one.
    """
    parts, indent, in_example = [""], 0, False
    for line in re.sub(r"(@param \S+|[.;:])  +(?=\S)", r"\1 ", text).split("\n"):
        in_example = line.startswith(">>>") or in_example and bool(line)
        before = re.match(r" *(?:- |\d+\. )?", line).group()
        if in_example or re.search(r"\S  +\S", line):
            parts.append("")
        elif before.strip() or len(before) != indent or not line or line.startswith("@"):
            parts.append(line[len(before):])
        else:
            parts[-1] += " " + line.strip()
        indent = len(before)
    return [sentence for part in parts for sentence in re.split(r"(?<=[.;:])\s|(?<=\.\))\s", part.strip()) if sentence]


def num_words(sentence):
    """Counts words and numbers. A word is "a", or has two letters in a row. All else is a symbol of a formula, and is not counted."""
    return sum(bool(re.search(r"[^\W\d_]{2}|^\W*(?:[aA]|[\d.,]+)\W*$", token)) for token in sentence.split())


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
            self.assertEqual(found, [("What it\nsays.", ['begins with "What"'])], language)

    def test_docstrings_are_read(self):
        source = 'def f():\n    """What it\n    says."""\n    g("""Of""")\n'
        self.assertEqual([(line, faults(text, "Python")) for line, text in blocks(source, "Python")], [(2, ['begins with "What"'])])

    def test_long_sentences_are_found(self):
        long, half = " ".join(["word"] * 26), " ".join(["word"] * 13)
        for source, language in ((f"// {long}.\n", "C++"), (f"// {half}\n// {half}\n", "C++"), (f"/**\n * {half}\n * {half}\n */", "C++"),
                                 (f"// - {half}\n//   {half}\n", "C++"), (f"/** @param a  {long[10:]} */", "TypeScript"),
                                 (f"//   {half}\n//   {half}\n", "C++"), (f"int a;  // {long}.  m\n", "C++"),
                                 (f"# {long}\n", "Python"), (f'"""{half}\n{half}"""\n', "Python"), (f"# {long}\n", "shell")):
            found = [fault[:22] for _, text in blocks(source, language) for fault in faults(text, language)]
            self.assertEqual(found, ["a sentence of 26 words"], source)

    def test_parts_are_no_long_sentence(self):
        half = " ".join(["word"] * 13)
        for source, language in ((f"// {half}: {half}\n", "C++"), (f"// {half}\n//\n// {half}\n", "C++"), (f"// {half}\n//   {half}\n", "C++"),
                                 (f"// - {half}\n// - {half}\n", "C++"), (f"// {half}  {half}\n", "C++"), (f"// {half} + x {half[5:]}\n", "C++"),
                                 (f"/**\n * {half}\n * @param a {half}\n */", "TypeScript"), (f'""">>> {half}\n{half}"""\n', "Python")):
            self.assertEqual([faults(text, language) for _, text in blocks(source, language)][0], [], source)

    def test_comments_of_the_reference_are_held_to_more(self):
        source = "// A text for people.\n//   all the same = 1\nint32 a = 1;  // that of b; for people\n"
        self.assertEqual([(line, faults(text, "proto")) for line, text in blocks(source, "proto")],
                         [(1, []), (3, ['says "that of"', 'says "for people"'])])

    def test_comments_behind_fields_have_one_line(self):
        """protoc takes a second line for a comment of the next field. Longer comments stand above their field."""
        found = []
        for path, language in sources(["proto"]):
            comments = list(slash_comments(path.read_text())) if language == "proto" else []
            found += [f"{path.relative_to(ROOT)}:{second[0]}" for first, second in zip(comments, comments[1:])
                      if not first[2] and second[2] and (first[0] + 1, first[1]) == second[:2]]
        self.assertEqual(found, [])

    def test_lines_of_the_reference_are_short(self):
        found = [f"{path.relative_to(ROOT)}:{number}: {len(line)} columns" for path, language in sources(["proto"]) if language == "proto"
                 for number, line in enumerate(path.read_text().split("\n"), 1) if len(line) > MOST_COLUMNS]
        self.assertEqual(found, [])

    def test_sources_are_short(self):
        found = [f"{path.relative_to(ROOT)}: {lines} lines" for path, language in sources(FOLDERS)
                 if language != "proto" and (lines := path.read_text().count("\n")) > MOST_LINES]
        self.assertEqual(found, [], "split by topic")

    def test_every_language_is_read(self):
        self.assertEqual({language for _, language in sources(FOLDERS)}, set(COMMENTS))


def main():
    if len(sys.argv) == 1 or sys.argv[1].startswith("-"):
        return unittest.main()
    count = 0
    for path, language in sources(sys.argv[1:]):
        for line, text in blocks(path.read_text(), language):
            for fault in faults(text, language):
                count += 1
                print(f"{path.relative_to(ROOT)}:{line}: {fault}")
    print(count, "in all")


if __name__ == "__main__":
    main()
