#!/usr/bin/env python3
"""What a person sees: every command on a terminal of 100 columns.

    screen_test.py LIPOID SCRATCH

Each command runs on a pseudo-terminal, whose bytes are played on a screen as a terminal would play
them. Nothing of a progress bar may stay, and no line may be longer than the screen. Paths that the
user typed are short here, so that they are not to blame.
"""

import os
import pathlib
import pty
import re
import shutil
import subprocess
import sys
import unittest

COLUMNS = 100


def on_terminal(arguments, folder):
    """The lines of the screen and the exit code of a command whose output and errors are a terminal."""
    master, slave = pty.openpty()
    environment = dict(os.environ, TERM="xterm", NO_COLOR="1")
    process = subprocess.Popen(arguments, cwd=folder, stdin=subprocess.DEVNULL, stdout=slave,
                               stderr=slave, env=environment)
    os.close(slave)
    written = b""
    while True:
        try:
            piece = os.read(master, 65536)
        except OSError:  # the other end is closed
            piece = b""
        if not piece:
            break
        written += piece
    os.close(master)
    return screen(written.decode("utf-8")), process.wait(), written


def screen(text):
    """Plays carriage returns, line feeds and "erase to the end of the line"."""
    lines = []
    line = []
    column = 0
    at = 0
    while at < len(text):
        erase = re.compile(r"\x1b\[K").match(text, at)
        if erase:
            del line[column:]
            at = erase.end()
            continue
        letter = text[at]
        at += 1
        if letter == "\r":
            column = 0
        elif letter == "\n":
            lines.append("".join(line))
            line, column = [], 0
        else:
            if letter == "\x1b":
                raise ValueError(f"a sequence that this screen does not know: {text[at - 1:at + 8]!r}")
            line[column:column + 1] = [letter]
            column += 1
    if line:
        lines.append("".join(line))
    return lines


class Screen(unittest.TestCase):
    lipoid = ""
    folder = pathlib.Path()

    @classmethod
    def setUpClass(cls):
        shutil.rmtree(cls.folder, ignore_errors=True)
        cls.folder.mkdir(parents=True)
        subprocess.run([cls.lipoid, "synthesize", "gifi-600mAh-1", "--with", "r_1=0.03,c_1=1500",
                        "--sampling-s", "2", "--rates-C", "1,3,6", "--voltage-noise-V", "0.0005",
                        "--quiet", "-o", "logs"], cwd=cls.folder, check=True)
        subprocess.run([cls.lipoid, "identify", "logs/campaign.toml", "--quiet", "-o", "cell.json"],
                       cwd=cls.folder, check=True, stdout=subprocess.DEVNULL)

    def look(self, *arguments, codes=(0,)):
        lines, code, written = on_terminal([self.lipoid, *arguments], self.folder)
        typed = "lipoid " + " ".join(arguments)
        self.assertIn(code, codes, typed + "\n" + "\n".join(lines))
        self.assertTrue(lines, typed)
        for line in lines:
            with self.subTest(typed=typed):
                self.assertLessEqual(len(line), COLUMNS, line)
                self.assertNotRegex(line, r"\[[#.]{30}\]", "a progress bar stayed")
        return lines, written

    def test_the_screen_plays_what_a_terminal_plays(self):
        self.assertEqual(screen("ab\rc\r\n[##..]\r\x1b[Kdone\n"), ["cb", "done"])
        self.assertEqual(screen("[##..]\rdone\n"), ["done.]"])

    def test_results(self):
        campaign = "logs/campaign.toml"
        for arguments in (
                ("identify", campaign, "-o", "a.json"),
                ("identify", campaign, "-o", "a.json", "--verbose", "--truth", "logs/truth.json"),
                ("identify", campaign, "-o", "a.json", "--method", "staged", "--verbose"),
                ("identify", campaign, "-o", "a.json", "--profile", "beta,r_s"),
                ("compare", campaign, "--starts", "2"),
                ("study", "branches", campaign),
                ("study", "ocv", campaign),
                ("study", "terms", campaign),
                ("plan", "cell.json"),
                ("validate", "cell.json", "logs/pulses.csv", "logs/cc_3C.csv"),
                ("simulate", "cell.json", "--current", "logs/cc_3C.csv", "-o", "p.csv"),
                ("inspect", "logs"),
                ("inspect", "logs", "--write-campaign", "draft.toml"),
                ("convert", "logs/cc_3C.csv", "-o", "c.csv"),
                ("fly", "altitude-steps", "--duration", "5"),
                ("fly", "hover", "--duration", "2", "--cell", "cell.json", "--ensemble", "3"),
                ("poles", "altitude"),
                ("design", "altitude"),
        ):
            self.look(*arguments)

    def test_a_bar_was_drawn_before_it_was_wiped(self):
        _, written = self.look("identify", "logs/campaign.toml", "-o", "a.json")
        self.assertIn(b"\x1b[K[", written)

    def test_lists_and_help(self):
        lines, _ = self.look("--help")
        commands = [match.group(1) for line in lines if (match := re.match(r"  ([a-z][a-z-]+)  ", line))]
        self.assertGreater(len(commands), 10)
        for command in commands:
            self.look(command, "--help")
        lines, _ = self.look("list", "--help")
        for what in re.findall(r"[a-z-]+", " ".join(lines).split("one of:")[1].split("Common")[0]):
            self.look("list", what)

    def test_errors(self):
        self.look("identify", "nothing.toml", "-o", "a.json", codes=(3,))
        self.look("fly", "loop", codes=(2,))
        self.look("identify", "logs/campaign.toml", "-o", "logs/campaign.toml", codes=(2,))


if __name__ == "__main__":
    Screen.lipoid = str(pathlib.Path(sys.argv[1]).resolve())
    Screen.folder = pathlib.Path(sys.argv[2])
    unittest.main(argv=sys.argv[:1])
