#!/usr/bin/env python3
"""lipoid serve from the other side: a client, a careless one, and several hostile ones.

    serve_test.py LIPOID SCRATCH [unittest's arguments]

Everything here speaks HTTP through sockets of its own; what the page does in a browser is tested by
tests/tools/pages/serve_test.py.
"""

import atexit
import http.client
import json
import os
import pathlib
import re
import resource
import shutil
import signal
import socket
import stat
import subprocess
import sys
import time
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
LAB = ROOT / "fixtures" / "lab" / "dmegc_inr18650_26_r1"
LIPOID = None
SCRATCH = None
PATIENCE_S = 60.0
CHANGES = {"X-Lipoid": "1"}
# A job that takes minutes.
LONG = {"command": "fly", "maneuver": "hover", "cell": "gifi-600mAh-1",
        "options": [["duration", "400"], ["set", "simulation.substeps=2000"]]}


class Serve:
    """A server with a folder of temporary files of its own."""

    def __init__(self, name, *arguments, prepare=None):
        self.temporary = SCRATCH / name
        self.temporary.mkdir(parents=True, exist_ok=True)
        self.process = subprocess.Popen(
            [LIPOID, "serve", *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
            env=dict(os.environ, TMPDIR=str(self.temporary)), preexec_fn=prepare)
        atexit.register(self.process.kill)  # where a test failed before it could end it
        self.address = self.process.stdout.readline().strip()
        found = re.fullmatch(r"http://([^/]+):(\d+)/([0-9a-f]{32})/", self.address)
        if not found:
            raise AssertionError(self.address + self.process.communicate()[1])
        self.host, self.port, self.key = found[1], int(found[2]), found[3]

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.end()

    def end(self, how=signal.SIGINT):
        """Its exit code and what it said."""
        if self.process.poll() is None:
            self.process.send_signal(how)
        _, said = self.process.communicate(timeout=PATIENCE_S)
        return self.process.returncode, said

    def folders(self):
        return sorted(self.temporary.glob("lipoid-serve-*"))

    def request(self, method, path, body=None, headers=None, host=None):
        """Status, headers and bytes of the answer; `path` is below the key, or begins with a stroke."""
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=PATIENCE_S)
        connection.putrequest(method, path if path.startswith("/") else f"/{self.key}/{path}", skip_host=True)
        for each in [host] if isinstance(host, str) else host if host is not None else [f"127.0.0.1:{self.port}"]:
            connection.putheader("Host", each)
        for name, value in (headers or {}).items():
            connection.putheader(name, value)
        if body is not None:
            connection.putheader("Content-Length", str(len(body)))
        connection.endheaders(body)
        answer = connection.getresponse()
        read = answer.read()
        connection.close()
        return answer.status, answer.headers, read

    def get(self, path):
        status, _, body = self.request("GET", path)
        assert status == 200, (status, body)
        return body

    def json(self, path):
        return json.loads(self.get(path))

    def post(self, path, value):
        status, _, body = self.request("POST", path, json.dumps(value).encode(), CHANGES)
        return status, json.loads(body) if status < 300 else body.decode()

    def upload(self, name, content):
        status, _, body = self.request("POST", f"api/files?name={name}", content, CHANGES)
        return status, json.loads(body) if status < 300 else body.decode()

    def wait(self, condition):
        """The state once the condition holds of it."""
        until = time.monotonic() + PATIENCE_S
        while True:
            state = self.json("api/state")
            if condition(state):
                return state
            if time.monotonic() > until:
                raise AssertionError(json.dumps(state, indent=1)[:4000])
            time.sleep(0.03)

    def inspected(self):
        return self.wait(lambda state: not state["inspecting"] and
                         all(file["status"] != "waiting" for file in state["files"]))

    def drop(self, *files):
        for file in files:
            status, answer = self.upload(file.name, file.read_bytes())
            assert status == 201, answer
        return self.inspected()

    def done(self, job):
        def of(state):
            return next(each for each in state["jobs"] if each["id"] == job)
        return of(self.wait(lambda state: of(state)["status"] not in ("queued", "running")))

    def raw(self, sent, seconds=10.0):
        """What comes back for these bytes until the server closes or is silent."""
        with socket.create_connection(("127.0.0.1", self.port), timeout=seconds) as client:
            try:
                client.sendall(sent)
                client.shutdown(socket.SHUT_WR)
            except OSError:
                pass
            got = b""
            try:
                while piece := client.recv(65536):
                    got += piece
            except OSError:
                pass
            return got


class Guarded(unittest.TestCase):
    """Who may ask."""

    @classmethod
    def setUpClass(cls):
        cls.serve = Serve("guarded", "--allow-host", "bench.lab", "--max-file-MB", "2", "--max-total-MB", "3")

    @classmethod
    def tearDownClass(cls):
        cls.serve.end()

    def status(self, method, path, **options):
        return self.serve.request(method, path, **options)[0]

    def test_wants_the_key(self):
        key = self.serve.key
        for path in ("/", "/api/state", "//", "/favicon.ico", f"/{'0' * 32}/", f"/{key[:-1]}/", f"/{key}0/",
                     f"/{key.upper()}x/", f"/{'0' * 32}/api/state", f"/?key={key}", f"/x/{key}/"):
            status, _, body = self.serve.request("GET", path)
            self.assertEqual(status, 403, path)
            self.assertIn(b"the key of this session is missing or wrong", body)
        self.assertEqual(self.status("GET", f"/{key}/api/state"), 200)

    def test_key_of_reports_opens_reports_alone(self):
        report_key = self.serve.json("api/program")["report_key"]
        for path in ("", "api/state", "api/program", "jobs/1/cell.json", "serve.js"):
            self.assertEqual(self.status("GET", f"/{report_key}/{path}"), 404, path)
        self.assertEqual(self.status("POST", f"/{report_key}/api/change", body=b"{}", headers=CHANGES), 405)

    def test_goes_by_its_own_names(self):
        port = self.serve.port
        for host in (f"127.0.0.1:{port}", f"localhost:{port}", "localhost:9000", f"[::1]:{port}", "LOCALHOST",
                     f"192.168.1.7:{port}", f"bench.lab:{port}"):
            self.assertEqual(self.status("GET", "api/state", host=host), 200, host)
        for host in ("evil.example", f"evil.example:{port}", f"127.0.0.1.evil.example:{port}", "localhost.evil.example",
                     f"bench.lab.evil.example:{port}", "127.1", "0x7f.1", "2130706433"):
            self.assertEqual(self.status("GET", "api/state", host=host), 403, host)
        for host in ([], ["localhost", "evil.example"], "", "localhost:", "localhost:x", "[::1", "a@localhost:1:2"):
            self.assertIn(self.status("GET", "api/state", host=host), (400, 403), host)

    def test_refuses_pages_of_other_sites(self):
        own = f"http://127.0.0.1:{self.serve.port}"
        change = {"method": "POST", "path": "api/change", "body": b"{}"}
        self.assertEqual(self.status(**change, headers={**CHANGES, "Origin": own}), 200)
        for origin in ("http://evil.example", "null", f"https://127.0.0.1:{self.serve.port}", "http://127.0.0.1",
                       f"http://localhost:{self.serve.port}"):
            self.assertEqual(self.status(**change, headers={**CHANGES, "Origin": origin}), 403, origin)
            self.assertEqual(self.status("GET", "api/state", headers={"Origin": origin}), 403, origin)
        for site in ("cross-site", "same-site"):
            headers = {"Sec-Fetch-Site": site}
            self.assertEqual(self.status(**change, headers={**CHANGES, **headers}), 403)
            self.assertEqual(self.status("GET", "serve.js", headers={**headers, "Sec-Fetch-Dest": "script"}), 403)
            self.assertEqual(self.status("GET", "", headers={**headers, "Sec-Fetch-Dest": "iframe"}), 403)
            self.assertEqual(self.status("GET", "", headers={**headers, "Sec-Fetch-Dest": "document"}), 200)
        # What a form of another page could send.
        self.assertEqual(self.status(**change, headers={"Content-Type": "text/plain"}), 403)

    def test_tells_no_other_site_anything(self):
        for method, path in (("GET", ""), ("GET", "api/state"), ("OPTIONS", "api/change"), ("GET", "serve.js"),
                             ("GET", "/"), ("POST", "api/nothing")):
            _, headers, _ = self.serve.request(method, path, headers=CHANGES)
            self.assertFalse([name for name in headers if name.lower().startswith("access-control")], path)
            self.assertEqual(headers["X-Content-Type-Options"], "nosniff")
            self.assertEqual(headers["Referrer-Policy"], "no-referrer")
            self.assertEqual(headers["Cache-Control"], "no-store")
            self.assertEqual(headers["Cross-Origin-Resource-Policy"], "same-origin")
        policy = self.serve.request("GET", "")[1]["Content-Security-Policy"]
        for part in ("default-src 'none'", "script-src 'self'", "frame-ancestors 'none'", "form-action 'none'"):
            self.assertIn(part, policy)
        self.assertNotIn("unsafe", policy)

    def test_knows_its_methods_and_addresses(self):
        for method, path in (("PUT", "api/state"), ("HEAD", "api/state"), ("DELETE", "api/files"), ("GET", "api/jobs"),
                             ("GET", "api/change"), ("POST", ""), ("PATCH", "api/jobs/1"), ("OPTIONS", "api/state")):
            self.assertEqual(self.status(method, path, headers=CHANGES), 405, (method, path))
        for path in ("nothing", "api/", "api/nothing", "api/files/0x1", "jobs/1/lock", "jobs/-1/cell.json",
                     "jobs/1/../../lock", "%2e%2e/lock", "../lock", "jobs/1/%2e%2e/cell.json", "jobs//cell.json",
                     "jobs/99999999999999999999/cell.json", "serve.js/"):
            self.assertEqual(self.status("GET", path), 404, path)
        self.assertEqual(self.status("DELETE", "api/files/7", headers=CHANGES), 404)
        self.assertEqual(self.status("DELETE", "api/jobs/7", headers=CHANGES), 404)
        self.assertEqual(self.status("POST", "api/jobs/7/cancel", headers=CHANGES), 404)

    def test_answers_head_without_a_body(self):
        for path in (f"/{self.serve.key}/api/state", "/", f"/{self.serve.key}/nothing"):
            first = f"HEAD {path} HTTP/1.1\r\nHost: localhost\r\n\r\n"
            second = f"GET /{self.serve.key}/api/program HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n"
            head, _, rest = self.serve.raw((first + second).encode()).partition(b"\r\n\r\n")
            self.assertRegex(head, rb"^HTTP/1\.1 40[35] ")
            self.assertTrue(rest.startswith(b"HTTP/1.1 200 OK\r\n"), rest[:200])
            json.loads(rest.partition(b"\r\n\r\n")[2])

    def test_refuses_what_is_no_http(self):
        line = f"GET /{self.serve.key}/api/state HTTP/1.1\r\nHost: localhost\r\n".encode()
        for sent in (b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03" + bytes(200), b"GET\r\n\r\n", b"nonsense\r\n\r\n",
                     line + b"Content-Length: 3\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n\r\n",
                     line + b"Content-Length: 3\r\nContent-Length: 4\r\n\r\nabcd",
                     line + b"Content-Length: -1\r\n\r\n", line + b" folded: x\r\n\r\n", line + b"a b: c\r\n\r\n",
                     b"GET http://evil.example/ HTTP/1.1\r\nHost: localhost\r\n\r\n",
                     f"GET /{self.serve.key}/api/state?a=%zz HTTP/1.1\r\nHost: localhost\r\n\r\n".encode()):
            got = self.serve.raw(sent)
            self.assertTrue(got == b"" or got.startswith(b"HTTP/1.1 400"), (sent[:80], got[:200]))
        self.assertEqual(self.status("GET", "api/state"), 200)

    def test_refuses_large_headers(self):
        line = f"GET /{self.serve.key}/api/state HTTP/1.1\r\nHost: localhost\r\n".encode()
        for sent in (line + b"X: " + b"a" * 3_000_000, line + b"X: y\r\n" * 300_000,
                     b"GET /" + b"a" * 3_000_000 + b" HTTP/1.1\r\n\r\n", b"a" * 3_000_000):
            got = self.serve.raw(sent)
            self.assertTrue(got == b"" or re.match(rb"HTTP/1.1 4(31|00)", got), got[:200])
        self.assertEqual(self.status("GET", "api/state"), 200)

    def test_refuses_large_requests(self):
        status, _, body = self.serve.request("POST", "api/change", b'{"a":"' + b"x" * 2_000_000 + b'"}', CHANGES)
        self.assertEqual((status, body), (413, b"the request is too long\n"))
        for bad in (b"{", b"[]", b"7", b'{"a":1,"a":2}', b"\xff", b"[" * 500_000):
            self.assertEqual(self.status("POST", "api/change", body=bad, headers=CHANGES), 400, bad[:20])

    def test_refuses_large_files(self):
        status, said = self.serve.upload("large.csv", b"1" * 2_000_001)
        self.assertEqual(status, 413)
        self.assertIn("a file may have 2 MB; start lipoid serve with a larger --max-file-MB", said)
        head = (f"POST /{self.serve.key}/api/files?name=x.csv HTTP/1.1\r\nHost: localhost\r\nX-Lipoid: 1\r\n"
                "Transfer-Encoding: chunked\r\n\r\n").encode()
        chunk = b"%x\r\n%s\r\n" % (500_000, b"1" * 500_000)
        self.assertTrue(self.serve.raw(head + 6 * chunk + b"0\r\n\r\n").startswith(b"HTTP/1.1 413"))
        # Announced as small, and never stops: what is beyond is another request, and none of HTTP.
        self.serve.raw((f"POST /{self.serve.key}/api/files?name=y.csv HTTP/1.1\r\nHost: localhost\r\nX-Lipoid: 1\r\n"
                        "Content-Length: 10\r\n\r\n").encode() + b"1" * 3_000_000)
        for file in self.serve.inspected()["files"]:
            self.assertEqual(file["bytes"], 10)
            self.serve.request("DELETE", f"api/files/{file['id']}", headers=CHANGES)
        self.assertEqual(self.serve.upload("a.csv", b"1" * 1_900_000)[0], 201)
        status, said = self.serve.upload("b.csv", b"1" * 1_900_000)
        self.assertEqual(status, 413)
        self.assertIn("all files together may have 3 MB", said)
        self.serve.request("DELETE", f"api/files/{self.serve.inspected()['files'][0]['id']}", headers=CHANGES)
        incoming = self.serve.folders()[0] / "incoming"
        self.assertEqual(list(incoming.iterdir()), [])

    def test_an_upload_that_breaks_off_leaves_nothing(self):
        head = (f"POST /{self.serve.key}/api/files?name=broken.csv HTTP/1.1\r\nHost: localhost\r\nX-Lipoid: 1\r\n"
                "Content-Length: 1000000\r\n\r\n").encode()
        self.serve.raw(head + b"1" * 300_000)
        incoming = self.serve.folders()[0] / "incoming"
        until = time.monotonic() + PATIENCE_S
        while list(incoming.iterdir()) and time.monotonic() < until:
            time.sleep(0.02)
        self.assertEqual(list(incoming.iterdir()), [])
        self.assertNotIn("broken.csv", [file["name"] for file in self.serve.json("api/state")["files"]])


class Slow(unittest.TestCase):
    def test_clients_that_send_nothing_are_closed(self):
        with Serve("slow") as serve:
            waiting = [socket.create_connection(("127.0.0.1", serve.port)) for _ in range(40)]
            began = time.monotonic()
            for client in waiting:
                client.sendall(b"GET / HTTP/1.1\r\nHost: local")
            self.assertEqual(serve.request("GET", "api/state")[0], 200)
            while time.monotonic() < began + 15.0:  # a byte now and then does not help
                for client in waiting:
                    client.sendall(b"h")
                time.sleep(1.0)
            for client in waiting:
                client.settimeout(PATIENCE_S)
                try:
                    self.assertEqual(client.recv(1), b"")
                except ConnectionResetError:
                    pass
                client.close()
            self.assertLess(time.monotonic() - began, 30.0)

    def test_too_many_connections_do_not_end_it(self):
        with Serve("many") as serve:
            waiting = [socket.create_connection(("127.0.0.1", serve.port)) for _ in range(300)]
            for client in waiting:
                client.close()
            until = time.monotonic() + PATIENCE_S
            while True:
                try:
                    self.assertEqual(serve.request("GET", "api/state")[0], 200)
                    break
                except (OSError, http.client.HTTPException):
                    self.assertLess(time.monotonic(), until)
                    time.sleep(0.05)


class Session(unittest.TestCase):
    """What stays on the disk."""

    def test_folder_is_private_and_goes(self):
        for how in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            serve = Serve("session")
            (folder,) = serve.folders()
            self.assertEqual(stat.S_IMODE(folder.stat().st_mode), 0o700)
            serve.drop(LAB / "cc_1c.csv")
            code, said = serve.end(how)
            self.assertEqual(code, 0, said)
            self.assertEqual(serve.folders(), [])

    def test_sweeps_what_a_killed_server_left(self):
        with Serve("sweep") as alive:
            killed = Serve("sweep")
            killed.drop(LAB / "cc_1c.csv")
            killed.end(signal.SIGKILL)
            outside = SCRATCH / "outside"
            outside.mkdir(exist_ok=True)
            (outside / "kept").write_text("x")
            link = alive.temporary / "lipoid-serve-link"
            link.unlink(missing_ok=True)
            link.symlink_to(outside)
            young = alive.temporary / "lipoid-serve-young"
            young.mkdir(mode=0o700, exist_ok=True)
            open_to_all = alive.temporary / "lipoid-serve-open"
            open_to_all.mkdir(exist_ok=True)
            open_to_all.chmod(0o755)
            (open_to_all / "lock").write_text("")
            self.assertEqual(len(alive.folders()), 5)
            with Serve("sweep") as after:
                self.assertEqual(len(after.folders()), 5)  # its own for that of the killed one
                self.assertTrue((outside / "kept").exists() and young.exists() and open_to_all.exists())
                self.assertEqual(alive.request("GET", "api/state")[0], 200)
                self.assertEqual(alive.drop(LAB / "cc_1c.csv")["files"][0]["status"], "read")
            self.assertIn("removed the files of 1 earlier server", after.process.stderr.read()
                          if not after.process.stderr.closed else "removed the files of 1 earlier server")

    def test_ends_where_nobody_asks(self):
        serve = Serve("idle", "--idle-s", "0.3", "--summary", str(SCRATCH / "idle.json"))
        _, said = serve.process.communicate(timeout=PATIENCE_S)
        self.assertEqual(serve.process.returncode, 0, said)
        summary = json.loads((SCRATCH / "idle.json").read_text())
        self.assertEqual((summary["ended_by"], summary["jobs"]), ("idle", 0))
        self.assertEqual(serve.folders(), [])

    def test_says_that_others_may_listen(self):
        serve = Serve("listen", "--address", "0.0.0.0")
        self.assertTrue(serve.address.startswith("http://localhost:"), serve.address)
        self.assertIn("other machines reach 0.0.0.0 as well", serve.end()[1])
        serve = Serve("listen")
        self.assertNotIn("other machines", serve.end()[1])

    def test_says_where_it_cannot_listen(self):
        with Serve("port") as serve:
            for arguments, word in ((["--port", str(serve.port)], "Give another --port"),
                                    (["--address", "localhost"], "expected an address such as 127.0.0.1")):
                second = subprocess.run([LIPOID, "serve", *arguments], capture_output=True, text=True, check=False)
                self.assertEqual(second.returncode, 2)
                self.assertIn(word, second.stderr)

    def test_says_that_the_disk_is_full(self):
        # A limit on the size of files gives the same errors as a disk without room.
        with Serve("full", prepare=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (1 << 20, 1 << 20))) as serve:
            status, said = serve.upload("large.csv", b"1" * (2 << 20))
            self.assertEqual(status, 507, said)
            self.assertIn("has no room for this file", said)
            self.assertEqual(list((serve.folders()[0] / "incoming").iterdir()), [])
            self.assertEqual(serve.upload("small.csv", (LAB / "cc_1c.csv").read_bytes())[0], 201)


class Bench(unittest.TestCase):
    """Logs, kinds, cell data."""

    def setUp(self):
        self.serve = Serve("bench")
        self.addCleanup(self.serve.end)

    def test_names_lead_nowhere(self):
        (folder,) = self.serve.folders()
        content = (LAB / "cc_1c.csv").read_bytes()
        names = {"..%2f..%2fetc%2fpasswd": "passwd", "..": "log", "%2ehidden.csv": "hidden.csv", "a%5cb.csv": "b.csv",
                 "-rf": "rf", "campaign.toml": "campaign-2.toml", "CELL.json": "CELL-2.json",
                 "%3Cscript%3Ealert(1).csv": "script_alert(1).csv", "%00.csv": None, "": None, "a" * 1001: None,
                 "%C3%BCber.csv": "über.csv", "%ff.csv": "log.csv", "%e2%80%ae.csv": "log-2.csv", "a%0ab.csv": "a_b.csv",
                 "lock": "lock", "$(id).csv": "id).csv", "x" * 300 + ".csv": "x" * 96 + ".csv",
                 "%2e%2e%2f%2e%2e%2flock": "lock-2"}
        for name, kept in names.items():
            status, said = self.serve.upload(name, content)
            self.assertEqual(status, 201 if kept else 400, (name, said))
        state = self.serve.inspected()
        self.assertEqual([file["kept_as"] for file in state["files"]], [kept for kept in names.values() if kept])
        self.assertEqual(sorted(path.name for path in (folder / "files").iterdir()),
                         sorted(kept for kept in names.values() if kept))
        self.assertEqual({file["status"] for file in state["files"]}, {"read"})
        self.assertEqual(state["files"][7]["name"], "<script>alert(1).csv")
        self.assertTrue((folder / "lock").exists())

    def test_says_what_each_log_is(self):
        logs = [LAB / name for name in ("cc_0p5c.csv", "low_rate.csv", "pulse.csv", "random_walk_01.csv")]
        state = self.serve.drop(*logs)
        self.assertEqual([row["kind"] for row in state["rows"]],
                         ["constant-current", "low-rate", "pulses", "validation"])
        inspection = state["files"][0]["inspection"]
        self.assertEqual((inspection["format"], inspection["rows"]), ("plain-csv", 714))
        self.assertIsNone(state["problems"])
        self.assertEqual(state["drafted"]["cutoff_V"], 2.5)

    def test_the_cut_off_that_is_said_decides_which_discharges_are_whole(self):
        state = self.serve.drop(LAB / "cc_0p5c.csv", LAB / "low_rate.csv", LAB / "pulse.csv")
        self.assertFalse(state["rows"][0]["left_out"])
        self.serve.post("api/change", {"cell": {"cutoff_V": 2.3}})
        self.assertRegex(self.serve.inspected()["rows"][0]["left_out"], r"^ends at 2\.\d+ V, above the cut-off$")
        self.serve.post("api/change", {"cell": {"cutoff_V": None}})
        self.assertFalse(self.serve.inspected()["rows"][0]["left_out"])

    def test_says_what_is_wrong_as_the_command_does(self):
        bad = SCRATCH / "bad.csv"
        bad.write_text("time_s,current_A,voltage_V\n0,0,4.1\n1,1,4.0\n2,abc,3.9\n")
        state = self.serve.drop(bad, LAB / "pulse.csv")
        printed = subprocess.run([LIPOID, "inspect", "bad.csv"], cwd=SCRATCH, capture_output=True, text=True,
                                 check=False).stderr
        self.assertEqual(state["files"][0]["error"], printed.strip())
        self.assertRegex(printed, r"^bad\.csv:4:3: error: ")
        self.assertEqual(state["files"][1]["status"], "read")
        self.serve.request("DELETE", f"api/files/{state['files'][1]['id']}", headers=CHANGES)
        self.assertEqual(self.serve.inspected()["files"][0]["error"], printed.strip())

    def test_a_person_changes_kinds_and_cell(self):
        state = self.serve.drop(LAB / "cc_1c.csv", LAB / "pulse.csv")
        keys = [row["key"] for row in state["rows"]]
        kinds = {keys[0]: {"kind": "validation"}, keys[1]: {"kind": ""}}
        self.assertEqual(self.serve.post("api/change", {"tests": kinds})[0], 200)
        self.assertEqual(self.serve.post("api/change", {"cell": {"name": "\"]\n[[log]]", "cutoff_V": 2.75}})[0], 200)
        text = self.serve.get("campaign.toml").decode()
        self.assertIn('kind = "validation"\nfile = "cc_1c.csv"', text)
        self.assertNotIn("pulse.csv", text)
        self.assertIn("cutoff_V = 2.75", text)
        self.assertEqual(text.count("\n[[log]]"), 1)
        self.serve.post("api/change", {"tests": {keys[0]: {"kind": None, "initial_soc": 0.9, "ambient_degC": 5},
                                                 keys[1]: {"kind": "low-rate-charge"}}})
        rows = self.serve.json("api/state")["rows"]
        self.assertEqual([row["kind"] for row in rows], ["constant-current", "low-rate-charge"])
        self.assertEqual([row["initial_soc"] for row in rows], [0.9, None])
        text = self.serve.get("campaign.toml").decode()
        self.assertIn("initial_soc = 0.9\n", text)
        self.assertIn("ambient_degC = 5.0\n", text)
        for bad in ({"tests": {"99": {"kind": "pulses"}}}, {"tests": {keys[0]: {"kind": "x"}}}, {"tests": []},
                    {"tests": {keys[0]: {"initial_soc": 1.6}}}, {"tests": {keys[0]: {"ambient_degC": "5"}}},
                    {"tests": {keys[0]: "pulses"}}, {"tests": {keys[0]: {"weight": 1}}}, {"cell": {"cutoff_V": "3"}},
                    {"cell": {"cutoff_V": 99}}, {"cell": {"series": 1.5}}, {"cell": {"series": 0}}, {"cell": 3},
                    {"cell": {"color": 3}}, {"colour": {}}, {"reading": {"columns": ["a"] * 5}},
                    {"cell": {"name": "x" * 300}}, {"cell": {"name": "\0"}}):
            self.assertIn(self.serve.post("api/change", bad)[0], (400, 404), bad)

    def test_a_change_that_is_refused_changes_nothing(self):
        (row,) = self.serve.drop(LAB / "cc_1c.csv")["rows"]
        before = self.serve.json("api/state")
        good = {"cell": {"series": 3, "capacity_Ah": 9.5}, "reading": {"hold": "forward"},
                "tests": {row["key"]: {"kind": "pulses"}}}
        for bad in ({"tests": {"9": {"kind": "pulses"}}}, {"tests": []}, {"tests": {row["key"]: {"kind": "x"}}},
                    {"tests": {row["key"]: {"kind": "pulses"}, "9": {}}}, {"reading": {"columns": "x"}},
                    {"reading": {"hold": "forward", "units": 3}}, {"cell": {"series": 3, "parallel": "x"}}):
            self.assertIn(self.serve.post("api/change", {**good, **bad})[0], (400, 404), bad)
            self.assertEqual(self.serve.json("api/state"), before, bad)
        self.assertEqual(self.serve.post("api/change", good)[0], 200)
        state = self.serve.inspected()
        self.assertEqual((state["cell"]["series"], state["cell"]["capacity_Ah"]), (3, 9.5))
        self.assertEqual((state["reading"]["hold"], state["rows"][0]["kind"]), ("forward", "pulses"))

    def test_offers_every_option_that_names_no_file(self):
        # What names a file, what the page says elsewhere or gives by itself, and an ideal battery, which is no cell.
        elsewhere = {"help", "output", "report", "latex", "summary", "threads", "quiet", "columns", "units",
                     "current-sign", "hold", "battery", "most-rows"}
        other = {"identify": {"constant-current", "low-rate", "pulses", "flight", "validation", "name",
                              "capacity-Ah", "cutoff-V", "series", "parallel", "initial-soc",
                              "initial-voltage-V", "open-circuit-voltage", "reference", "residuals", "truth",
                              "verbose"},
                 "fly": {"cell", "xi", "waypoints"},
                 "validate": {"set"}}  # it has no settings
        offered = self.serve.json("api/program")["commands"]
        for command, without in other.items():
            text = subprocess.run([LIPOID, command, "--help"], capture_output=True, text=True, check=True).stdout
            options = set(re.findall(r"^  (?:-\w, )?--([\w-]+)", text, re.MULTILINE)) - elsewhere - without
            self.assertEqual({option["name"] for option in offered[command]["options"]}, options, command)

    def test_sets_what_it_shows_and_no_option_that_may_name_a_file(self):
        offered = self.serve.json("api/program")["commands"]
        for asked in ({"command": "fly", "maneuver": "hover", "cell": "gifi-600mAh-1"}, {"command": "identify"}):
            command = asked["command"]
            settings = [setting["name"] for setting in offered[command]["settings"]]
            # What the parser knows, by its own words, in the spellings that it takes or once took.
            said = subprocess.run([LIPOID, command, *(["hover"] if command == "fly" else []), "--set", "?=1"],
                                  capture_output=True, text=True, check=False).stderr
            known = re.search(r"Known: (.*)", said)[1].split(", ")
            self.assertLess(set(settings), set(known), command)
            others = [name for name in known if name not in settings]
            self.assertIn("vehicle" if command == "fly" else "reference", others)
            for name in [*others, *(name.replace("_", "-") for name in others), *(name.upper() for name in others),
                         *(name[:-1] for name in others), *(f"--{name}" for name in others),
                         *(f" {name}" for name in others), *(f"{name} " for name in others),
                         *(f"{settings[0]}.{name}" for name in others), settings[0].upper(), settings[0][:-1], ""]:
                for value in (f"{name}=/etc/passwd", name):
                    status, said = self.serve.post("api/jobs", {**asked, "options": [["set", value]]})
                    self.assertEqual(status, 400, (command, value, said))
                    self.assertIn("option --set: ", said)
        self.assertEqual(self.serve.json("api/state")["jobs"], [])
        status, said = self.serve.post("api/jobs", {
            "command": "fly", "maneuver": "hover", "cell": "gifi-600mAh-1",
            "options": [["duration", "1"], *(["set", f"{setting['name']}={setting['default']}"]
                                             for setting in offered["fly"]["settings"]
                                             if setting["name"].startswith(("hover.", "simulation.")))]})
        self.assertEqual(status, 201, said)
        job = self.serve.done(said["id"])
        self.assertEqual(job["status"], "done", job)

    def test_reads_logs_as_it_is_told(self):
        odd = SCRATCH / "odd.csv"
        rows = (LAB / "pulse.csv").read_text().splitlines()
        self.assertEqual(rows[0], "time_s,current_a,voltage_v")
        odd.write_text("\n".join(["Uhr,x,y", *rows[1:]]))
        state = self.serve.drop(odd)
        self.assertEqual(state["files"][0]["status"], "refused")
        columns = ["time_s=Uhr", "current_A=x", "voltage_V=y"]
        self.serve.post("api/change", {"reading": {"columns": columns, "units": "s,A,V"}})
        state = self.serve.inspected()
        self.assertEqual(state["files"][0]["status"], "read", state["files"][0])
        self.assertIn('columns = { ', self.serve.get("campaign.toml").decode())

    def test_reads_the_battery_that_it_is_told(self):
        flights = ROOT / "fixtures" / "flights"
        self.serve.drop(flights / "log171.bin", flights / "sample_log_small.ulg")
        self.serve.post("api/change", {"reading": {"battery": "2"}})
        state = self.serve.inspected()
        self.assertIn("expected rows of battery 2 as the option battery says", state["files"][0]["error"])
        (row,) = state["rows"]
        self.serve.post("api/change", {"tests": {row["key"]: {"kind": "flight"}}})
        self.assertIn("battery = 2", self.serve.get("campaign.toml").decode())

    def test_the_state_is_told_once(self):
        # The end of an inspection would be news between the two.
        _, headers, _ = self.serve.request("GET", "api/state")
        for _ in range(100):
            time.sleep(0.1)
            before, (_, headers, _) = headers, self.serve.request("GET", "api/state")
            if headers["ETag"] == before["ETag"]:
                break
        status, _, body = self.serve.request("GET", "api/state", headers={"If-None-Match": headers["ETag"]})
        self.assertEqual((status, body), (304, b""))
        self.serve.post("api/change", {"cell": {"name": "new"}})
        self.assertEqual(self.serve.request("GET", "api/state", headers={"If-None-Match": headers["ETag"]})[0], 200)


class Jobs(unittest.TestCase):
    """From logs to a cell and a flight."""

    def setUp(self):
        self.serve = Serve("jobs")
        self.addCleanup(self.serve.end)

    def start(self, **asked):
        status, answer = self.serve.post("api/jobs", asked)
        self.assertEqual(status, 201, answer)
        return answer["id"]

    def test_the_whole_path(self):
        self.serve.drop(LAB / "low_rate.csv", LAB / "pulse.csv")
        self.serve.post("api/change", {"cell": {"name": "the lab's"}})
        first = self.start(command="identify", options=[])
        second = self.start(command="identify", options=[["method", "staged"], ["fix", "r_s=0.03"], ["no-diffusion"],
                                                         ["set", "pulses.terms=5"]])
        job = self.serve.done(first)
        self.assertEqual((job["status"], job["exit_code"]), ("done", 0), job)
        self.assertRegex(job["verdict"], r"^the lab's predicts its own logs to .* mV \(.* %\): (good|fair|poor)")
        names = [each["name"] for each in job["outputs"]]
        for name in ("cell.json", "campaign.toml", "summary.json", "output.txt"):
            self.assertIn(name, names)
        cell = json.loads(self.serve.get(f"jobs/{first}/cell.json"))
        self.assertEqual(cell["schema"], "lipoid.cell/1")
        # The same by the command line, beside the same logs.
        folder = SCRATCH / "by-hand"
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir()
        for name in ("low_rate.csv", "pulse.csv"):
            shutil.copy(LAB / name, folder)
        (folder / "campaign.toml").write_bytes(self.serve.get(f"jobs/{first}/campaign.toml"))
        subprocess.run([LIPOID, "identify", "campaign.toml", "-o", "cell.json", "--quiet"], cwd=folder, check=True,
                       stdout=subprocess.DEVNULL)
        by_hand = json.loads((folder / "cell.json").read_text())
        for key in ("name", "diffusion", "series_resistance_Ohm", "branches", "open_circuit_voltage"):
            self.assertEqual(cell[key], by_hand[key], key)
        staged = self.serve.done(second)
        self.assertIn(staged["status"], ("done",), staged)
        self.assertEqual(json.loads(self.serve.get(f"jobs/{second}/cell.json"))["series_resistance_Ohm"], 0.03)
        flight = self.start(command="fly", maneuver="hover", cell="gifi-600mAh-1", options=[["duration", "1"]])
        self.assertEqual(self.serve.done(flight)["status"], "done")
        self.assertTrue(self.serve.get(f"jobs/{flight}/flight.csv").startswith(b"time_s,"))
        logs = [file["id"] for file in self.serve.json("api/state")["files"]]
        checked = self.start(command="validate", cell_of=first, logs=logs, options=[])
        self.assertEqual(self.serve.done(checked)["status"], "done")
        self.assertEqual(self.serve.request("DELETE", f"api/jobs/{first}", headers=CHANGES)[0], 200)
        self.assertEqual(self.serve.request("GET", f"jobs/{first}/cell.json")[0], 404)

    def test_validates_with_what_is_set_at_the_logs(self):
        self.serve.drop(LAB / "low_rate.csv", LAB / "pulse.csv")
        rows = {row["file"]: row["key"] for row in self.serve.inspected()["rows"]}
        low, pulse = sorted(rows)
        asked = {"command": "validate", "cell": "gifi-600mAh-1", "logs": [pulse], "options": []}

        def options_of(job):
            self.assertEqual(self.serve.done(job)["status"], "done")
            arguments = json.loads(self.serve.get(f"jobs/{job}/summary.json"))["run"]["arguments"]
            return [each for each in arguments if re.match("--(initial-soc|ambient-degC|series|parallel)=", each)]

        self.assertEqual(options_of(self.start(**asked)), ["--initial-soc=1"])
        self.serve.post("api/change", {"tests": {rows[pulse]: {"initial_soc": 0.5, "ambient_degC": 5}}, "cell": {"parallel": 2}})
        self.serve.inspected()
        self.assertEqual(options_of(self.start(**asked)),
                         ["--initial-soc=0.5", "--ambient-degC=5", "--parallel=2"])
        own = [["initial-soc", "0.9"], ["ambient-degC", "10"], ["parallel", "3"]]
        self.assertEqual(options_of(self.start(**{**asked, "options": own})),
                         ["--initial-soc=0.9", "--ambient-degC=10", "--parallel=3"])
        both = {**asked, "logs": [low, pulse]}
        status, said = self.serve.post("api/jobs", both)
        self.assertEqual(status, 409)
        self.assertIn("these logs do not all start at the same state of charge", said)
        self.assertIn("set --initial-soc", said)
        status, said = self.serve.post("api/jobs", {**both, "options": own[:1]})
        self.assertEqual(status, 409)
        self.assertIn("these logs do not all have the same temperature of the air", said)
        self.serve.post("api/change", {"tests": {rows[low]: {"initial_soc": 0.5, "ambient_degC": 5}}})
        self.assertEqual(options_of(self.start(**both)),
                         ["--initial-soc=0.5", "--ambient-degC=5", "--parallel=2"])

    def test_takes_what_it_offers_and_no_files(self):
        self.serve.drop(LAB / "low_rate.csv", LAB / "pulse.csv")
        identify = {"command": "identify", "options": []}
        for asked in ({"command": "serve"}, {"command": "inspect"}, {}, {"command": 1}, {**identify, "options": 1},
                      {**identify, "options": [["output", "/tmp/x"]]}, {**identify, "options": [["summary", "/tmp/x"]]},
                      {**identify, "options": [["truth", "/etc/passwd"]]}, {**identify, "options": [["method"]]},
                      {**identify, "options": [["open-circuit-voltage", "/etc/passwd"]]},
                      {**identify, "options": [["no-diffusion", "x"]]}, {**identify, "options": [[]]},
                      {**identify, "options": [["method", "a", "b"]]}, {**identify, "options": [["method", "\0"]]},
                      {**identify, "options": [["method", "x" * 2000]]}, {**identify, "options": [["seed", "1"]] * 300},
                      {**identify, "more": 1}, {"command": "fly", "maneuver": "hover", "cell": "/etc/passwd"},
                      {"command": "fly", "maneuver": "waypoints", "cell": "gifi-600mAh-1"},
                      {"command": "fly", "maneuver": "hover", "cell": "gifi-600mAh-1", "options": [["gains", "/etc/passwd"]]},
                      {"command": "fly", "maneuver": "hover", "cell": "gifi-600mAh-1", "options": [["vehicle", "../x"]]},
                      {"command": "fly", "maneuver": "hover", "cell": "gifi-600mAh-1", "options": [["waypoints", "x"]]},
                      {"command": "validate", "cell": "gifi-600mAh-1", "logs": []},
                      {"command": "validate", "cell": "gifi-600mAh-1", "logs": ["/etc/passwd"]}):
            status, said = self.serve.post("api/jobs", asked)
            self.assertEqual(status, 400, (asked, said))
        for asked in ({"command": "fly", "maneuver": "hover", "cell_of": 99},
                      {"command": "validate", "cell": "gifi-600mAh-1", "logs": [99]}):
            self.assertEqual(self.serve.post("api/jobs", asked)[0], 404, asked)
        # A value that looks like another option stays a value, and the command says what it thinks of it.
        job = self.serve.done(self.start(command="identify", options=[["fix", "--output=/tmp/x"]]))
        self.assertEqual((job["status"], job["exit_code"]), ("failed", 2))
        self.assertIn("--fix", job["message"])
        self.assertEqual([each for each in job["outputs"] if each["name"] == "cell.json"], [])

    def test_jobs_wait_for_each_other_and_can_be_cancelled(self):
        running = self.start(**LONG)
        waiting = self.start(**LONG)
        state = self.serve.wait(lambda state: state["jobs"][0].get("fraction", 0) > 0)
        self.assertEqual([job["status"] for job in state["jobs"]], ["running", "queued"])
        self.assertEqual(self.serve.request("DELETE", f"api/jobs/{running}", headers=CHANGES)[0], 409)
        for job in (waiting, running):
            self.assertEqual(self.serve.post(f"api/jobs/{job}/cancel", {})[0], 200)
        self.assertEqual(self.serve.done(running)["status"], "cancelled")
        self.assertEqual(self.serve.done(waiting)["status"], "cancelled")
        (folder,) = self.serve.folders()
        left = [path.name for path in (folder / "jobs" / str(running)).iterdir()]
        self.assertEqual([name for name in left if name not in ("output.txt", "messages.txt")], [])
        self.assertEqual(children_of(self.serve.process.pid), [])

    def test_a_crash_costs_a_job_and_not_the_server(self):
        job = self.start(**LONG)
        self.serve.wait(lambda state: state["jobs"][0].get("fraction", 0) > 0)
        (child,) = children_of(self.serve.process.pid)
        os.kill(child, signal.SIGKILL)
        done = self.serve.done(job)
        self.assertEqual(done["status"], "failed")
        self.assertIn("ended by signal 9", done["message"])
        again = self.start(command="fly", maneuver="hover", cell="gifi-600mAh-1", options=[["duration", "1"]])
        self.assertEqual(self.serve.done(again)["status"], "done")

    def test_what_runs_ends_with_the_server(self):
        for how in (signal.SIGTERM, signal.SIGKILL):
            serve = Serve("jobs-end")
            self.assertEqual(serve.post("api/jobs", LONG)[0], 201)
            serve.wait(lambda state: state["jobs"][0].get("fraction", 0) > 0)
            (child,) = children_of(serve.process.pid)
            serve.end(how)
            until = time.monotonic() + PATIENCE_S
            while pathlib.Path(f"/proc/{child}").exists() and time.monotonic() < until:
                time.sleep(0.02)
            self.assertFalse(pathlib.Path(f"/proc/{child}").exists())

    def test_a_file_in_use_stays(self):
        state = self.serve.drop(LAB / "low_rate.csv", LAB / "pulse.csv")
        blocking = self.start(**LONG)
        waiting = self.start(command="identify", options=[])
        status, _, said = self.serve.request("DELETE", f"api/files/{state['files'][0]['id']}", headers=CHANGES)
        self.assertEqual(status, 409)
        self.assertIn(f"job {waiting} reads this file".encode(), said)
        for job in (waiting, blocking):
            self.serve.post(f"api/jobs/{job}/cancel", {})
        self.serve.done(blocking)
        self.assertEqual(self.serve.request("DELETE", f"api/files/{state['files'][0]['id']}", headers=CHANGES)[0], 200)


def children_of(process):
    """Processes that it started and that still run."""
    found = []
    for status in pathlib.Path("/proc").glob("[0-9]*/status"):
        try:
            text = status.read_text()
        except OSError:
            continue
        if re.search(rf"^PPid:\s+{process}$", text, re.M) and not re.search(r"^State:\s+Z", text, re.M):
            found.append(int(status.parent.name))
    return found


if __name__ == "__main__":
    LIPOID = pathlib.Path(sys.argv[1]).resolve()
    tried = subprocess.run([LIPOID, "serve", "--idle-s", "0.01"], capture_output=True, text=True, check=False)
    if "built without reports" in tried.stderr:
        print(f"skipped: {tried.stderr}")
        sys.exit(77)
    SCRATCH = pathlib.Path(sys.argv[2]).resolve()
    shutil.rmtree(SCRATCH, ignore_errors=True)
    SCRATCH.mkdir(parents=True)
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
