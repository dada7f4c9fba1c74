#!/usr/bin/env python3
"""Measures the memory of processes that run at the same time, as Linux counts it.

    python memory.py --processes 4 -- arboleda shoot --index-file city.arb --photons 10M --threads 1

Looks each 20 ms, and prints the largest that it saw of each process: its own memory (Anonymous, which no other process
has), the same with pages of files that it wrote and that are not on the disk yet (Private_Dirty), its share of all (Pss),
and all that it touches (Rss), of which the pages of files are shared. PID in the command is a number of the
process, so that each may write a file of its own.
"""

import argparse
import subprocess
import time

MEBI = 1024.0


def rollup(process):
    """Reads the sums over all maps of a process in MiB; zeros if it has ended."""
    try:
        with open(f"/proc/{process}/smaps_rollup", encoding="ascii") as lines:
            fields = (line.split() for line in lines if line.endswith("kB\n"))
            return {field[0].rstrip(":"): int(field[1]) / MEBI for field in fields}
    except (OSError, ValueError):
        return {}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--processes", type=int, default=1)
    parser.add_argument("command", nargs="+")
    given = parser.parse_args()
    commands = [[word.replace("PID", str(number)) for word in given.command] for number in range(given.processes)]
    started = [subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) for command in commands]
    most = [dict.fromkeys(("Anonymous", "Private_Dirty", "Pss", "Rss"), 0.0) for _ in started]
    all_pss = 0.0
    while any(process.poll() is None for process in started):
        pss = 0.0
        for process, peaks in zip(started, most):
            now = rollup(process.pid)
            pss += now.get("Pss", 0.0)
            for name in peaks:
                peaks[name] = max(peaks[name], now.get(name, 0.0))
        all_pss = max(all_pss, pss)
        time.sleep(0.02)
    if any(process.returncode != 0 for process in started):
        raise SystemExit("a process failed")
    for number, peaks in enumerate(most):
        print(f"process {number}: " + ", ".join(f"{name} {value:.1f} MiB" for name, value in peaks.items()))
    print(f"all together: Pss {all_pss:.1f} MiB")


if __name__ == "__main__":
    main()
