# SPDX-License-Identifier: BSD-3-Clause
"""README.md and docs: the commands, options, files, pages and tests that they name exist."""

import re
import shutil
import subprocess
import tempfile
import unittest
from pathlib import Path

from culm_program import PROGRAM
from executed_page import FENCE, ROOT, Step, steps_of
from test_documents import DOCS, EXECUTED, LEFT_OUT

FOLDER_PAGE = "README.md"  # of a folder: three lines for somebody who looks at the files
BOOK = [page for page in sorted(DOCS.glob("*.md")) if page.name != FOLDER_PAGE]
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *BOOK]
MOST_README_LINES = 120
# A line that begins with one of these is a command.
COMMAND = re.compile(r"(?:\$ )?(?:culm|mpirun|cmake|ctest|ninja|sbatch|\./jobs|jobs/|\./tests|"
                     r"postprocess/|python3|apt-get) ")


def help_of(words: list[str]) -> str | None:
    """None if culm has no such command."""
    asked = subprocess.run([PROGRAM, *words, "--help"], text=True, capture_output=True, check=False)
    return asked.stdout if asked.returncode == 0 else None


def prose_of(text: str) -> str:
    return FENCE.sub(lambda block: "\n" * block[0].count("\n"), text)


def culm_commands(text: str, steps: list[Step]) -> list[str]:
    """The commands between backticks and in blocks of commands, including synopses."""
    quoted = re.findall(r"`((?:mpirun -n \d+ )?culm [^`]+)`", prose_of(text))
    typed = [line for step in steps for line in step.commands.splitlines()]
    return [command.replace("\\|", "|").split("culm ", 1)[1].partition(" #")[0]
            for command in quoted + [line for line in typed
                                     if re.match(r"(mpirun .*)?culm ", line)]]


def page_slugs(page: Path) -> set[str]:
    """The names by which GitHub links to the headings of a page."""
    headings = re.findall(r"(?m)^#+ (.*)$", prose_of(page.read_text("utf-8")))
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


class EveryPage(unittest.TestCase):
    maxDiff = None

    def every(self):
        """Yields every page, its text and its blocks of commands."""
        for page in PAGES:
            text = page.read_text("utf-8")
            yield page, text, steps_of(text, only_commands=False)

    def test_every_block_of_commands_is_run_or_says_why_not(self):
        for page, text, steps in self.every():
            with self.subTest(page=page.name):
                excuses = LEFT_OUT.get(page.name, {})
                first_lines = {step.commands.splitlines()[0] for step in steps}
                self.assertLessEqual(set(excuses), first_lines, "there is no such block")
                if page.name not in EXECUTED:
                    self.assertLessEqual(first_lines, set(excuses), "nothing runs these")

    def test_commands_are_in_blocks_marked_sh(self):
        for page, text, steps in self.every():
            with self.subTest(page=page.name):
                unmarked = "".join(block for language, block in FENCE.findall(text) if not language)
                indented = re.findall(r"(?m)^(?: {4,}|\t)(.*)$", prose_of(text))
                for line in [*indented, *unmarked.splitlines()]:
                    self.assertIsNone(COMMAND.match(line), line)

    def test_commands_and_options_that_are_named_exist(self):
        known: dict[str, str | None] = {}
        for page, text, steps in self.every():
            with self.subTest(page=page.name):
                for command in culm_commands(text, steps):
                    words = command.split()
                    nested = words[:2] if words[0] in ("archive", "export") else words[:1]
                    if not re.fullmatch(r"[a-z][a-z-]*", nested[0]):
                        continue  # culm COMMAND, culm …, culm --version
                    for last in nested[-1].split("|"):
                        path = [*nested[:-1], last] if words[0] != "export" else ["export"]
                        key = " ".join(path)
                        if key not in known:
                            known[key] = help_of(path)
                        self.assertIsNotNone(known[key], f"there is no `culm {key}`: {command}")
                        for option in re.findall(r"(?<![\w-])--?[a-z][a-z0-9-]*", command):
                            self.assertRegex(
                                known[key], rf"(?m)^  (?:-\w,)?{option}\b|,{option}\b", command)

    def test_long_studies_that_are_named_can_be_planned(self):
        """Studies that take minutes are not run here but only checked by a dry run."""
        for page, text, steps in self.every():
            for command in culm_commands(text, steps):
                if study := re.match(r"run (config/[\w-]+\.toml)", command):
                    with self.subTest(page=page.name, study=study[1]), \
                            tempfile.TemporaryDirectory() as folder:
                        planned = subprocess.run(
                            [PROGRAM, "run", ROOT / study[1], "-o", folder, "--dry-run"],
                            text=True, capture_output=True, check=False)
                        self.assertEqual(planned.returncode, 0, planned.stderr)

    def test_links_lead_somewhere(self):
        for page, text, _ in self.every():
            with self.subTest(page=page.name):
                for target in re.findall(r"\]\(([^)\s]+)\)", prose_of(text)):
                    if target.startswith("http"):
                        continue
                    file, _, heading = target.partition("#")
                    place = (page.parent / file).resolve() if file else page
                    self.assertTrue(place.exists(), target)
                    if heading:
                        self.assertIn(heading, page_slugs(place), target)

    def test_files_that_are_named_exist(self):
        name = re.compile(
            r"`((?:src|tests|docs|config|jobs|postprocess|bench|cmake)/[\w./*+-]*\w)`")
        for page, text, _ in self.every():
            with self.subTest(page=page.name):
                for file in name.findall(text):
                    self.assertTrue(any(ROOT.glob(file)), file)

    def test_every_page_is_in_the_table_of_contents(self):
        contents = (DOCS / "index.md").read_text("utf-8")
        for page in BOOK:
            if page.name != "index.md":
                self.assertIn(f"]({page.name})", contents)

    def test_every_page_begins_with_its_purpose(self):
        for page in BOOK:
            with self.subTest(page=page.name):
                title, *lines = page.read_text("utf-8").splitlines()
                self.assertRegex(title, r"^# \S")
                self.assertRegex(next(filter(None, lines)), r"^With this page you can .*\.")

    def test_readme_is_short(self):
        lines = (ROOT / "README.md").read_text("utf-8").splitlines()
        self.assertLessEqual(len(lines), MOST_README_LINES)

    def test_every_folder_says_what_it_contains(self):
        for folder in sorted(ROOT.iterdir()):
            if folder.is_dir() and folder.name not in ("build", "results") and (
                    not folder.name.startswith(".")):
                page = (folder / FOLDER_PAGE).read_text("utf-8")
                self.assertEqual(len(page.splitlines()), 3, folder.name)

    def test_every_picture_is_shown(self):
        everything = "".join(text for _, text, _ in self.every())
        for picture in sorted((DOCS / "images").iterdir()):
            self.assertIn(f"images/{picture.name})", everything)

    def test_pages_that_the_program_names_exist(self):
        for source in [*ROOT.glob("src/*/*.[ch]pp"), *ROOT.glob("postprocess/**/*.py"),
                       *ROOT.glob("config/*.toml"), *ROOT.glob("jobs/**/*.sh")]:
            for named in re.findall(r"\bdocs/[\w./-]*\w", source.read_text("utf-8")):
                self.assertTrue((ROOT / named).exists(), f"{source.relative_to(ROOT)}: {named}")


class NamedTests(unittest.TestCase):
    """What `ctest -R` and `ctest -L` of the documents select."""

    @classmethod
    def setUpClass(cls):
        build = Path(PROGRAM).parents[2]
        if not shutil.which("ctest") or not (build / "CTestTestfile.cmake").exists():
            raise unittest.SkipTest("there is no ctest here")
        cls.build = build
        cls.names = re.findall(r"(?m)^ *Test +#\d+: (\S+)", cls.listed())
        if any(name.endswith("_NOT_BUILT") for name in cls.names):
            raise unittest.SkipTest("not all tests are built")

    @classmethod
    def listed(cls, *options: str) -> str:
        return subprocess.run(["ctest", "--test-dir", cls.build, "-N", *options], text=True,
                              capture_output=True, check=True).stdout

    def test_exist(self):
        labels = set(re.findall(r"(?m)^  (\S+)$", self.listed("--print-labels")))
        for page in PAGES:
            named = re.findall(r'ctest -(R|L) ("[^"]+"|[^\s`]+)', page.read_text("utf-8"))
            for kind, pattern in named:
                candidates = self.names if kind == "R" else labels
                for part in pattern.strip('"').split("|"):
                    if part != "NAME":
                        with self.subTest(page=page.name, part=part):
                            self.assertTrue(any(re.search(part, name) for name in candidates))


if __name__ == "__main__":
    unittest.main()
