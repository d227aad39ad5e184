"""What the tests of pages share: a lipoid to run, a folder to write in, a browser to look with.

    class Validate(PageTest):
        def test_charts(self):
            self.lipoid("validate", CELL, LOG, "--report", "page.html")
            page = self.open("page.html")

Run by ctest as `python3 NAME_test.py LIPOID SCRATCH`; without a browser the tests are skipped and say
why.
"""

import pathlib
import shutil
import subprocess
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import browser  # noqa: E402

PROJECT = pathlib.Path(__file__).resolve().parents[3]
LAB = PROJECT / "fixtures" / "lab"


@unittest.skipIf(browser.missing(), browser.missing())
class PageTest(unittest.TestCase):
    program = None
    folder = None

    @classmethod
    def setUpClass(cls):
        cls.folder = PageTest.folder / cls.__name__
        shutil.rmtree(cls.folder, ignore_errors=True)
        cls.folder.mkdir(parents=True)

    def lipoid(self, *arguments, code=0):
        """Runs a command in the folder of the test and returns what it printed."""
        done = subprocess.run([self.program, *map(str, arguments)], cwd=self.folder, text=True,
                              capture_output=True, timeout=300)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        return done.stdout + done.stderr

    def open(self, page, **options):
        """The page in a browser, which is closed when the test is done. It must load without a
        complaint."""
        window = browser.Browser(**options)
        self.addCleanup(window.driver.quit)
        window.open(page if "://" in str(page) else self.folder / page)
        self.assertEqual(window.complaints(), [])
        return window


def main():
    PageTest.program = str(pathlib.Path(sys.argv[1]).resolve())
    PageTest.folder = pathlib.Path(sys.argv[2]).resolve()
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
