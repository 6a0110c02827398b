#!/usr/bin/env python3
"""Finds words and sentences that are not plain technical English, and lines over 100 columns.

    python3 deploy/words.py            all files that git knows
    python3 deploy/words.py FILE ...   these files
    python3 deploy/words.py --count    one line per file: number of findings

Exit code 1 if something is found. A word is allowed on a line that ends with `words: allow`.
"""

import re
import subprocess
import sys

# Pattern: what to write instead.
WORDS = {
    r"noughts?": "zero, none",
    r"told|tells?": "reports, shows, sends, distinguishes",
    r"what of": "the part of ... that",
    r"beside": "next to, in addition to",
    r"anew": "again, from the start",
    r"nobody": "no worker, no code",
    r"lets? go|let_go|let be": "release, leave unchanged",
    r"comes? upon": "meet, reach",
    r"whither|whence|hither|thence": "where, from there",
    r"as many a": "each",
    r"by and by": "gradually",
    r"so to speak": "",
    r"reckon(?:s|ed|ing)?": "compute, estimate",
    r"but for": "except",
    r"for want of": "without",
    r"mishaps?": "error, failure",
    r"bears? (?:its|their) step": "is stable at its step",
}
WORD = re.compile(r"(?<![\w-])(" + "|".join(WORDS) + r")(?![\w-])", re.IGNORECASE)
# The same in names: `is_told`, `from_nought`.
NAME = re.compile(r"\w*_(?:told|tells?|noughts?|beside|anew|nobody|let_be)(?:_\w+|\b)")
# Sentences without a subject.
START = re.compile(r"^(What|Whether|Which|Who|Whom|Whose|Of|That)\s")
ENDINGS = (".rs", ".md", ".toml", ".sh", ".py", ".html")
WIDTH = 100
# A raw string that stands alone on its line; it cannot be broken.
RAW_STRING = re.compile(r'^\s*r#".*"#,?$')
# Data, generated text, texts of others.
SKIPPED = re.compile(
    r"^(cases/REFERENCE\.md|docs/reference/commands\.md|tests/VERIFICATION(_ROWS)?\.md|tests/verification\.json|master/assets/vendor/|CHANGELOG\.md|deploy/words\.py|LICENSE)"
)
COMMENT = re.compile(r"^\s*(//[/!]?|#)\s?(.*)$")


def advice(word):
    """What to write instead of a word that was found."""
    return next(a for p, a in WORDS.items() if re.fullmatch(p, word, re.IGNORECASE))


def exempt(line):
    """True for a line that cannot be broken: one with a link, or a raw string."""
    return "http" in line or RAW_STRING.match(line) is not None


def findings(path, text):
    """Line number and message of each finding."""
    in_code, before_blank = False, True
    for number, line in enumerate(text.split("\n"), 1):
        if line.rstrip().endswith("words: allow"):
            continue
        for match in WORD.finditer(line):
            yield number, f"'{match.group(1)}': {advice(match.group(1)) or 'leave out'}"
        for match in NAME.finditer(line) if path.endswith(".rs") else ():
            yield number, f"name '{match.group(0)}'"
        is_table = path.endswith(".md") and line.startswith("|")
        if path.endswith(".md") and line.startswith("```"):
            in_code = not in_code
        if len(line) > WIDTH and not is_table and not in_code and not exempt(line):
            yield number, f"{len(line)} columns, at most {WIDTH}"
        comment = COMMENT.match(line) if path.endswith((".rs", ".toml", ".sh", ".py")) else None
        if comment and path.endswith(".rs") and comment.group(1) == "#":
            comment = None
        body = comment.group(2) if comment else None
        if body is not None and before_blank and START.match(body):
            yield number, f"a sentence without a subject: '{body[:40]}'"
        before_blank = body is None or body == "" or body.endswith((".", ":"))


def main(arguments):
    count = "--count" in arguments
    paths = [a for a in arguments if not a.startswith("--")]
    if not paths:
        listed = subprocess.run(["git", "ls-files"], check=True, capture_output=True, text=True)
        paths = listed.stdout.split("\n")
    total = 0
    for path in paths:
        if not path.endswith(ENDINGS) or SKIPPED.match(path):
            continue
        with open(path, encoding="utf-8") as file:
            found = list(findings(path, file.read()))
        total += len(found)
        if count and found:
            print(f"{len(found):5} {path}")
        elif not count:
            print("".join(f"{path}:{number}: {what}\n" for number, what in found), end="")
    print(f"{total} findings")
    return 1 if total else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
