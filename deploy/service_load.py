#!/usr/bin/env python3
"""Load of the service, with the limits that it must keep.

    deploy/service_load.py PROGRAM [--pairs N] [--watchers N] [--cycles N] [--csv FILE]

- watchers: a run with and without watchers (streams of events), in turns that change their order.
  They connect while the job waits behind another one. Their client has the lowest priority.
- submissions: small jobs, each at its time, whether or not the ones before are answered.
- list: pages of 10,000 jobs, which are copied in the database while the service is down.
- week: the events of a week, a progress each second and an event each minute, as fast as the
  service takes them, from a program that stands for a run. Each watcher must get the last one.

Each row of the table has a figure, its limit, and whether it is kept. "open": some pairs of runs
are within the limit and some are not, so that the figure shows nothing.
"""

import argparse
import asyncio
import contextlib
import csv
import fcntl
import http.client
import json
import os
import socket
import sqlite3
import statistics
import subprocess
import tempfile
import threading
import time
from pathlib import Path

FINAL = {"checked", "completed", "refused", "failed", "lost", "stopped"}
WEEK = 7 * 24 * 3600


class Service:
    """A service in a folder of its own, and a plain client."""

    def __init__(self, program, folder, *options):
        self.dir = Path(folder) / "service"
        self.command = [program, "serve", "--dir", str(self.dir), "--listen", "127.0.0.1:0"]
        self.command += ["--disk-limit=0", *options]
        self.start()

    def start(self):
        self.process = subprocess.Popen(self.command, stdout=subprocess.PIPE, text=True)
        while "#token=" not in self.process.stdout.readline():
            if self.process.poll() is not None:
                raise SystemExit("error: the service does not start")
        access = json.loads((self.dir / "access.json").read_text())
        self.host, self.port = access["address"].rsplit("/", 1)[1].split(":")
        self.head = {"Authorization": f"Bearer {access['token']}"}

    def end(self):
        self.process.terminate()
        self.process.wait()
        self.process.stdout.close()

    def ask(self, method, path, body=None):
        connection = http.client.HTTPConnection(self.host, int(self.port), timeout=120)
        head = self.head | {"Content-Type": "application/json"}
        connection.request(method, path, json.dumps(body) if body is not None else None, head)
        reply = connection.getresponse()
        text = reply.read()
        connection.close()
        if reply.status >= 300:
            raise SystemExit(f"error: {method} {path}: {reply.status} {text[:200]}")
        return json.loads(text)

    def submit(self, body):
        return self.ask("POST", "/api/jobs", body)["id"]

    def wait(self, job, states=FINAL):
        while (found := self.ask("GET", f"/api/jobs/{job}"))["state"] not in states:
            time.sleep(0.05)
        return found

    def memory(self, key="VmHWM"):
        """Peak or present memory of the service [MB]."""
        text = Path(f"/proc/{self.process.pid}/status").read_text()
        line = next(line for line in text.splitlines() if line.startswith(key))
        return int(line.split()[1]) * 1024 / 1e6

    def request(self, path):
        head = f"GET {path} HTTP/1.1\r\nHost: {self.host}:{self.port}\r\n"
        return (head + f"Authorization: {self.head['Authorization']}\r\n\r\n").encode()


def cpu(process):
    """CPU time of a process so far, user and system [s]; None if there is no such process."""
    try:
        words = Path(f"/proc/{process}/stat").read_text().rsplit(")", 1)[1].split()
    except OSError:
        return None
    return (int(words[11]) + int(words[12])) / os.sysconf("SC_CLK_TCK")


def job(scene, *sets):
    text = Path(f"cases/{scene}/job.toml").read_text()
    return {"files": {"job.toml": text}, "set": list(sets), "workers": 1}


class Watchers:
    """Clients that read the events of a job, on a thread that has the lowest priority once all
    are connected."""

    def __init__(self, service, job, count):
        self.service, self.path, self.count = service, f"/api/jobs/{job}/events", count
        self.connected, self.bytes, self.ended, self.progress = 0, 0, 0, 0
        self.thread = threading.Thread(target=self.run)
        self.thread.start()

    def run(self):
        asyncio.run(self.all())

    async def all(self):
        await asyncio.gather(*(self.watch() for _ in range(self.count)))

    async def watch(self):
        reader, writer = await asyncio.open_connection(self.service.host, self.service.port)
        writer.write(self.service.request(self.path))
        await writer.drain()
        if b" 200 " not in await reader.readline():
            raise SystemExit("error: a watcher was refused")
        self.connected += 1
        while data := await reader.read(1 << 16):
            self.bytes += len(data)
            self.progress += data.count(b"event: progress")
            if b"event: end" in data:
                self.ended += 1
                break
        writer.close()

    def wait_connected(self):
        while self.connected < self.count:
            if not self.thread.is_alive():
                raise SystemExit("error: the watchers ended")
            time.sleep(0.02)
        os.setpriority(os.PRIO_PROCESS, self.thread.native_id, 19)


def watched_run(service, cycles, count):
    """CPU and wall time of a run, CPU time of the service meanwhile, events of each watcher."""
    sets = [f"time.max_cycles={cycles}", "output.field_interval=-1", "checkpoint.every=off"]
    first = service.submit(job("bars", "end_time=1e9", "output.field_interval=-1"))
    service.wait(first, {"running"})
    second = service.submit(job("jeep-frame", *sets))
    service.wait(second, {"queued"})
    watchers = Watchers(service, second, count) if count else None
    if watchers:
        watchers.wait_connected()
    service.ask("POST", f"/api/jobs/{first}/stop", {})
    service.wait(second, {"running"})
    before = cpu(service.process.pid)
    results = service.dir / f"jobs/{second}/results"
    while not (results / "run.lock").exists() or not (results / "run.lock").read_text():
        time.sleep(0.01)
    run, used = (results / "run.lock").read_text(), 0
    # Its supervisor sees the end after up to 50 ms; until then the system keeps the whole time.
    while (seen := cpu(run)) is not None:
        used = seen
        time.sleep(0.01)
    by_service = cpu(service.process.pid) - before
    ended = service.wait(second)
    if ended["state"] != "completed":
        raise SystemExit(f"error: {ended}")
    if watchers:
        watchers.thread.join()
        if watchers.ended != count:
            raise SystemExit(f"error: {watchers.ended} of {count} watchers saw the end")
    summary = json.loads((results / "summary.json").read_text())
    events = watchers.progress / count if watchers else 0
    return used, summary["wall_s"], by_service, events, summary["state_digest"]


def watchers(program, args, report):
    with tempfile.TemporaryDirectory() as folder:
        # All watchers share one token, which has a rate.
        service = Service(program, folder, "--slots", "1", "--rate", "2000")
        ratios = {"CPU": [], "wall": []}
        digests = set()
        for pair in range(args.pairs):
            counts = [0, args.watchers] if pair % 2 == 0 else [args.watchers, 0]
            runs = {count: watched_run(service, args.cycles, count) for count in counts}
            digests |= {found[4] for found in runs.values()}
            for at, name in enumerate(ratios):
                plain, watched = runs[0][at], runs[args.watchers][at]
                ratios[name].append(watched / plain)
                report(f"pair {pair + 1}, {name} time of the run without watchers", plain, "s")
                report(f"pair {pair + 1}, {name} time of the run with watchers", watched, "s")
            used, events = runs[args.watchers][2:4]
            report(f"pair {pair + 1}, CPU time of the service with watchers", used, "s")
            report(f"pair {pair + 1}, progress events of each watcher", events, "")
        for name, all_of_them in ratios.items():
            more = [(ratio - 1) * 100 for ratio in all_of_them]
            verdict = "yes" if max(more) <= 2 else "NO" if min(more) > 2 else "open"
            middle = statistics.median(more)
            report(f"more {name} time with watchers, median", middle, "%", 2, verdict)
            report(f"more {name} time with watchers, least pair", min(more), "%")
            report(f"more {name} time with watchers, largest pair", max(more), "%")
        report("different digests of these runs", len(digests), "", 1)
        report("peak memory of the service with watchers", service.memory(), "MB", 300)
        service.end()


async def submit_at(service, start, delay, body):
    """Latency of a submission that is due at a time, and the number of the job."""
    await asyncio.sleep(start + delay - time.monotonic())
    due = start + delay
    reader, writer = await asyncio.open_connection(service.host, service.port)
    head = service.request("/api/jobs").decode().replace("GET", "POST", 1)[:-2]
    head += f"Connection: close\r\nContent-Type: application/json\r\nContent-Length: {len(body)}"
    writer.write(f"{head}\r\n\r\n".encode() + body)
    answer = await reader.read()
    writer.close()
    if not answer.startswith(b"HTTP/1.1 201"):
        return time.monotonic() - due, None
    return time.monotonic() - due, json.loads(answer.split(b"\r\n\r\n", 1)[1])["id"]


def submissions(program, args, report):
    with tempfile.TemporaryDirectory() as folder:
        service = Service(program, folder)
        body = json.dumps(job("bars", "output.field_interval=-1")).encode()
        number = args.rate * args.seconds

        async def all_of_them():
            start = time.monotonic() + 0.5
            due = (submit_at(service, start, n / args.rate, body) for n in range(number))
            return await asyncio.gather(*due)

        answers = asyncio.run(all_of_them())
        sent = time.monotonic()
        times = sorted(1000 * took for took, _ in answers)
        ids = {number for _, number in answers if number is not None}
        report(f"submissions, {args.rate} each second", number, "")
        report("submissions that were refused", sum(n is None for _, n in answers), "", 0)
        report("time to the answer, median", statistics.median(times), "ms")
        report("time to the answer, 99th percentile", times[int(0.99 * len(times))], "ms")
        report("time to the answer, longest", times[-1], "ms")
        while service.ask("GET", "/api/jobs?state=completed&limit=1")["total"] < len(ids):
            open_jobs = [
                service.ask("GET", f"/api/jobs?state={state}&limit=1")["total"]
                for state in ("checking", "queued", "starting", "running")
            ]
            if not any(open_jobs):
                break
            time.sleep(1)
        done = service.ask("GET", "/api/jobs?state=completed&limit=1")["total"]
        report("acknowledged jobs that were not completed", len(ids) - done, "", 0)
        report("time from the last answer to the end of all jobs", time.monotonic() - sent, "s")
        report("peak memory of the service with submissions", service.memory(), "MB", 300)
        service.end()


def long_list(program, args, report):
    with tempfile.TemporaryDirectory() as folder:
        service = Service(program, folder)
        service.wait(service.submit(job("bars", "output.field_interval=-1")))
        service.end()
        with contextlib.closing(sqlite3.connect(service.dir / "service.db")) as db:
            columns = [row[1] for row in db.execute("PRAGMA table_info(job)") if row[1] != "id"]
            names = ", ".join(columns)
            copies = "WITH RECURSIVE n(i) AS (SELECT 2 UNION ALL SELECT i + 1 FROM n WHERE i < ?)"
            db.execute(
                f"INSERT INTO job ({names}) {copies} SELECT {names} FROM job, n",  # noqa: S608
                (args.jobs,),
            )
            db.execute(
                "INSERT INTO event (job, at, kind, data) SELECT job.id, at, kind, data "
                "FROM job, event WHERE event.job = 1 AND job.id != 1"
            )
            db.commit()
        began = time.monotonic()
        service.start()
        report(f"start of the service with {args.jobs} jobs", time.monotonic() - began, "s")
        for what, query in [
            ("first page of 50", "limit=50"),
            ("first page of 500", "limit=500"),
            ("last page of 50", "limit=50&before=51"),
            ("filter by state", "state=completed&limit=50"),
            ("filter by name", "name=toml&limit=50"),
            ("filter by a name that no job has", "name=absent&limit=50"),
        ]:
            times = []
            for _ in range(30):
                began = time.monotonic()
                service.ask("GET", f"/api/jobs?{query}")
                times.append(1000 * (time.monotonic() - began))
            report(f"list of {args.jobs} jobs, {what}, median", statistics.median(times), "ms", 100)
            report(f"list of {args.jobs} jobs, {what}, longest of 30", max(times), "ms", 100)
        service.end()


class Pretended:
    """A program that stands for a run: it holds the attempt and answers on the socket."""

    def __init__(self, folder, line, seconds):
        self.line, self.seconds = line, seconds
        (folder / "results").mkdir(exist_ok=True)
        self.attempt = (folder / "attempt-1").open("w")
        fcntl.flock(self.attempt, fcntl.LOCK_EX)
        self.attempt.write(f"pid {os.getpid()}\n")
        self.attempt.flush()
        self.listener = socket.socket(socket.AF_UNIX)
        self.listener.bind(str(folder / "results/run.sock"))
        self.listener.listen()
        self.sent = 0
        self.begin = threading.Event()
        self.thread = threading.Thread(target=self.run)
        self.thread.start()

    def run(self):
        stream, _ = self.listener.accept()
        self.begin.wait()
        event = json.dumps({"answer": "event", "text": "a redecomposition of low order"})
        while self.sent < self.seconds:
            piece = [self.line] * 60
            stream.sendall(("\n".join(piece) + f"\n{event}\n").encode())
            self.sent += 60
        stream.close()

    def end(self):
        self.thread.join()
        self.listener.close()
        self.attempt.write("code 0\n")
        self.attempt.close()


def week(program, args, report):
    with tempfile.TemporaryDirectory() as folder:
        service = Service(program, folder, "--slots", "1")
        first = service.submit(job("bars", "end_time=1e9", "output.field_interval=-1"))
        service.wait(first, {"running"})
        while True:
            with contextlib.suppress(SystemExit):
                line = json.dumps(service.ask("GET", f"/api/jobs/{first}/progress"))
                break
            time.sleep(0.1)
        service.ask("POST", f"/api/jobs/{first}/stop", {})
        service.wait(first)
        service.end()
        path = service.dir / f"jobs/{first}"
        for old in [path / "attempt-1", path / "results/run.sock"]:
            old.unlink(missing_ok=True)
        with contextlib.closing(sqlite3.connect(service.dir / "service.db")) as db:
            db.execute("UPDATE job SET state = 'running', ended = NULL, stopping = 0, attempt = 1")
            db.commit()
        seconds = args.weeks * WEEK
        pretended = Pretended(path, line, seconds)
        service.start()
        clients = Watchers(service, first, args.week_watchers)
        clients.wait_connected()
        pretended.begin.set()
        began, marks = time.monotonic(), []
        while pretended.thread.is_alive():
            if pretended.sent >= len(marks) * seconds / 10:
                marks.append(service.memory("VmRSS"))
            time.sleep(0.01)
        took = time.monotonic() - began
        pretended.end()
        service.wait(first)
        clients.thread.join()
        report("week: weeks", args.weeks, "")
        report("week: progress lines and events", seconds * 61 // 60, "")
        report("week: time in which they passed", took, "s")
        report("week: watchers", args.week_watchers, "")
        report("week: watchers that missed the end", args.week_watchers - clients.ended, "", 0)
        report("week: progress events of each watcher", clients.progress / args.week_watchers, "")
        for tenth, memory in enumerate(marks):
            report(f"week: memory of the service after {tenth * 10} %", memory, "MB")
        # The first tenth fills caches and buffers.
        report("week: growth of memory from 10 % to the end", marks[-1] - marks[1], "MB", 5)
        report("week: peak memory of the service", service.memory(), "MB", 300)
        with contextlib.closing(sqlite3.connect(service.dir / "service.db")) as db:
            kept = db.execute("SELECT count(*) FROM event").fetchone()[0]
        report("week: events in the database at the end", kept, "", 10200)
        service.end()


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program")
    parser.add_argument("--only", choices=["watchers", "submissions", "list", "week"])
    parser.add_argument("--pairs", type=int, default=5)
    parser.add_argument("--watchers", type=int, default=500)
    parser.add_argument("--cycles", type=int, default=4000)
    parser.add_argument("--rate", type=int, default=50)
    parser.add_argument("--seconds", type=int, default=10)
    parser.add_argument("--jobs", type=int, default=10000)
    parser.add_argument("--weeks", type=int, default=1)
    parser.add_argument("--week-watchers", type=int, default=20)
    parser.add_argument("--csv", default="cases/bench/service_load.csv")
    args = parser.parse_args()
    program = str(Path(args.program).resolve())
    studies = {
        "watchers": watchers,
        "submissions": submissions,
        "list": long_list,
        "week": week,
    }
    rows = []

    def report(figure, value, unit, limit=None, kept=None):
        if kept is None:
            kept = "" if limit is None else ("yes" if value <= limit else "NO")
        shown = f"{value:.3f}" if isinstance(value, float) else str(value)
        rows.append([figure, shown, unit, "" if limit is None else limit, kept])
        print(f"{figure}: {shown} {unit} {kept and f'(limit {limit}: {kept})'}", flush=True)

    for name, study in studies.items():
        if args.only in (None, name):
            study(program, args, report)
    with Path(args.csv).open("w", newline="") as out:
        table = csv.writer(out, lineterminator="\n")
        table.writerow(["figure", "value", "unit", "limit", "kept"])
        table.writerows(rows)


if __name__ == "__main__":
    main()
