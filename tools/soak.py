#!/usr/bin/env python3
"""Hours of simulated driving at full speed, while somebody watches and everything is recorded.

    soak.py [--metal PROGRAM] [--hours 8]

First `metal studio` trains the paper's phases with a page that reads every frame and a recorder that writes every step;
then `metal run` trains them again, and lives them again with a recorder. Memory is sampled all the while, and the steps on
the recordings are counted. It fails if memory grows or if a step is missing. Needs Linux; no part of ./test.
"""

import argparse
import json
import os
import pathlib
import re
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
import tomllib

STEPS_PER_HOUR = 7200
# A step of the world lasts half a second; so many of the hours belong to each phase.
SHARES = {"foa": 0.2, "fusion": 0.3, "attention": 0.5}
# What of the experiment is kept, beside all that is no phase and no row of the comparison.
PHASES = {"demonstration", *SHARES}
ROWS = {"oracle", "blind", "foa", "fusion", "acl"}
SAMPLE_SECONDS = 0.25
# What memory may grow by from the third quarter of a stage to the last one, as a share, beside a fixed allowance.
GROWTH, ALLOWANCE_MIB = 0.05, 4


class Memory(threading.Thread):
    """Samples the resident memory of a process, in MiB."""

    def __init__(self, process):
        super().__init__(daemon=True)
        self.process, self.samples = process, []

    def run(self):
        page = os.sysconf("SC_PAGE_SIZE")
        while self.process.poll() is None:
            try:
                resident = int(pathlib.Path(f"/proc/{self.process.pid}/statm").read_text().split()[1])
            except (OSError, IndexError):
                return
            self.samples.append((time.monotonic(), resident * page / 2**20))
            time.sleep(SAMPLE_SECONDS)

    def between(self, start, end):
        """Memory within a part of a period, from its beginning to its end."""
        return [mib for at, mib in self.samples if start <= at <= end]


def judge(what, samples):
    """Whether memory stayed flat in the second half of a stage, as medians of its quarters; in a line."""
    middle = lambda part: sorted(part)[len(part) // 2]
    early, late = (middle(samples[i * len(samples) // 4 : (i + 1) * len(samples) // 4]) for i in (2, 3))
    flat = late <= early * (1 + GROWTH) + ALLOWANCE_MIB
    print(f"{what}: {early:.1f} MiB in the third quarter, {late:.1f} in the last, most {max(samples):.1f}: "
          f"{'flat' if flat else 'GROWS'}")
    return flat


def steps(phase, hours):
    return round(hours * STEPS_PER_HOUR * SHARES[phase])


def budgets(hours):
    """Overrides for so many hours."""
    return [word for phase in SHARES for word in ("--set", f"phase.{phase}.budget={{steps={steps(phase, hours)}}}")]


def shortened(experiment, folder):
    """The experiment with the phases and rows that are wanted here, as a file."""
    kept, wanted = [], True
    for line in pathlib.Path(experiment).read_text().splitlines():
        if table := re.match(r"\[(phase|policy|subsets)\.?(\w*)", line):
            wanted = table[2] in (PHASES if table[1] == "phase" else ROWS)
        elif line.startswith("["):
            wanted = True
        kept += [line] if wanted else []
    file = pathlib.Path(folder, "soak.toml")
    file.write_text("\n".join(kept))
    return str(file)


def is_whole(program, recording, wanted):
    """Whether so many steps are on a recording (what it is of, its file); in a line."""
    what, file = recording
    table = subprocess.run([*program, "replay", file], capture_output=True, text=True, check=True)
    found = sum(int(row.split()[1]) for row in table.stdout.splitlines() if re.match(r"\s*\d+\s+\d+\s", row))
    megabytes = pathlib.Path(file).stat().st_size / 1e6
    print(f"recording of {what}: {found} of {wanted} steps, {megabytes:.0f} MB")
    return found == wanted


def page_of(url):
    """A page of the studio: a WebSocket by hand."""
    address, path = re.fullmatch(r"http://([^/]+)(/.*)", url).groups()
    host, port = address.rsplit(":", 1)
    page = socket.create_connection((host, int(port)))
    page.sendall(f"GET {path}live HTTP/1.1\r\nHost: {address}\r\nOrigin: http://{address}\r\nConnection: Upgrade\r\n"
                 "Upgrade: websocket\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n"
                 .encode())
    stream = page.makefile("rb")
    status = stream.readline()
    if b" 101 " not in status:
        raise RuntimeError(f"the studio refused the page: {status!r}")
    while stream.readline().strip():
        pass
    return page, stream


def ask(page, request):
    text = json.dumps(request).encode()
    page.sendall(bytes([0x81, 0x80 | len(text), 0, 0, 0, 0]) + text)


def messages(page, stream):
    """The studio's messages, until it closes; its pings are answered."""
    while len(head := stream.read(2)) == 2:
        length = head[1] & 0x7F
        if length > 125:
            length = int.from_bytes(stream.read(2 if length == 126 else 8), "big")
        body = stream.read(length)
        if head[0] & 0x0F == 9:
            page.sendall(bytes([0x8A, 0x80, 0, 0, 0, 0]))
        elif head[0] & 0x0F == 1:
            yield json.loads(body)


def watched(program, plan, hours, folder):
    """Trains in the studio with a page that reads everything."""
    tape = f"{folder}/studio.mcap"
    process = subprocess.Popen([*program, "studio", "--experiment", plan, "--out", f"{folder}/studio", "--record", tape,
                                *budgets(hours)], stdout=subprocess.PIPE, text=True)
    memory = Memory(process)
    memory.start()
    url = re.search(r"http://\S+", process.stdout.readline()).group(0)
    page, stream = page_of(url)
    ask(page, {"do": "train", "demonstrations": False})
    start, frames, marks = time.monotonic(), 0, []
    for message in messages(page, stream):
        frames += "frame" in message
        training = message.get("status", {}).get("training") if "status" in message else None
        if training:
            marks.append((time.monotonic(), training))
            if training["state"] in ("finished", "failed", "stopped"):
                break
    end = time.monotonic()
    process.send_signal(signal.SIGINT)
    process.wait(60)
    state = marks[-1][1]["state"] if marks else "never began"
    total = sum(steps(phase, hours) for phase in SHARES)
    print(f"studio: {total} steps, training {state} after {end - start:.0f} s, {frames} frames read")
    sound = [state == "finished", judge("studio", memory.between(start, end))]
    shown = tomllib.loads(pathlib.Path(plan).read_text())["phase"]["demonstration"]["budget"]["steps"]
    sound.append(is_whole(program, ("the studio", tape), total + shown))
    return all(sound)


def until(process, happened):
    """Waits for something that a process does; when that was."""
    while process.poll() is None and not happened():
        time.sleep(SAMPLE_SECONDS)
    return time.monotonic()


def recorded(program, plan, hours, folder):
    """Trains without anybody watching, then lives it again with a recorder."""
    words = budgets(hours)
    for phase in SHARES:
        words += ["--record", f"phase.{phase}={folder}/{phase}.mcap"]
    start = time.monotonic()
    process = subprocess.Popen([*program, "run", plan, "--seeds", "1", "--out", f"{folder}/run", "--record-episodes", "0",
                                "--set", "evaluation.runs=8", *words], stdout=subprocess.DEVNULL)
    memory = Memory(process)
    memory.start()
    # Saved when the last phase is learned; tests and the report, which need memory of their own, come between.
    trained = until(process, lambda: any(pathlib.Path(folder, "run/checkpoint").glob(f"train_*_{list(SHARES)[-1]}-*")))
    tapes = [pathlib.Path(folder, f"{phase}.mcap") for phase in SHARES]
    tested, code = until(process, lambda: any(tape.exists() for tape in tapes)), process.wait()
    end = time.monotonic()
    print(f"run: exit code {code}; trained for {trained - start:.0f} s, tested and reported for {tested - trained:.0f} s, "
          f"recorded for {end - tested:.0f} s")
    sound = [judge("training", memory.between(start, trained)), judge("recording", memory.between(tested, end))]
    sound = code == 0 and all(sound)
    whole = [is_whole(program, (phase, f"{folder}/{phase}.mcap"), steps(phase, hours)) for phase in SHARES]
    return sound and all(whole)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--metal", default="target/release/metal", help="the program, or `cargo run --release --`")
    parser.add_argument("--plan", default="experiments/paper.toml")
    parser.add_argument("--hours", type=float, default=8.0, help="simulated hours of training")
    wanted = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        plan = shortened(wanted.plan, folder)
        sound = [run(wanted.metal.split(), plan, wanted.hours, folder) for run in (watched, recorded)]
    sys.exit(0 if all(sound) else 1)


if __name__ == "__main__":
    main()
