#!/usr/bin/env python3
"""Measures how a job grows with its ranks, and computes from the costs where more of them stop to help.

    python growth.py --arboleda arboleda --scene "--scene city" --photons 20000000 --ranks 1,2

Measured in turns, as medians: photons a second with these ranks of one thread, of all time and of processor time, which
also holds on a busy machine; the seconds in which rank 0 speaks, for each range that it hands out; the seconds of adding
counts, for each triangle and level of the tree, least of all because ranks wait for each other; the processor time of
`merge`, for each triangle and part. Needs the feature `mpi`. The table is of a job of --job photons on a scene of
--triangles, with --gigabits between machines.
"""

import argparse
import math
import os
import re
import resource
import shlex
import statistics
import subprocess
import tempfile
import time

# As in the program: the longest range in seconds, the fewest photons of a range, bytes of counts of a triangle, the pause
# of rank 0 while nobody asks.
LONGEST, CHUNK, COUNTS, PAUSE = 60.0, 1024, 16, 5e-4
# Ranges in which a rank grows from its first to its longest.
RAMP = 4


def processor_time():
    """Seconds of processor time of all processes that ended."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def run(command, folder):
    """Runs a command. Returns its seconds, those of processor time, and what it said."""
    begun, used = time.perf_counter(), processor_time()
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    if done.returncode != 0:
        raise SystemExit(f"{shlex.join(command)}: {done.stderr.strip()}")
    return time.perf_counter() - begun, processor_time() - used, done.stdout + done.stderr


def seconds(text):
    """Reads a duration as the program writes it."""
    number, unit = text.split()
    return float(number) * {"us": 1e-6, "ms": 1e-3, "s": 1.0}[unit]


def shoot(given, folder, ranks, photons, *more):
    """Shoots with ranks. Returns the seconds, all and of processor time, the ranges handed out, and the seconds of
    speaking and of adding."""
    command = ["mpirun", "-n", str(ranks), given.arboleda, "shoot", *shlex.split(given.scene), "--photons", str(photons)]
    took, used, said = run([*command, "--index", "wide-bvh", "--threads", "1", *more], folder)
    found = re.search(r"(\d+) ranges handed out in (\S+ \S+), counts added in (\S+ \S+)", said)
    return took, used, int(found[1]), seconds(found[2]), seconds(found[3])


def triangles_of(given, folder):
    said = run([given.arboleda, "shoot", *shlex.split(given.scene), "--photons", "1", "--index", "bvh"], folder)[2]
    return int(re.search(r"([\d,]+) triangles", said)[1].replace(",", ""))


def measure(given, folder):
    """Measures the costs. Few photons more are shot in between, so that the time of a start is not counted."""
    few = given.photons // 10
    rates, speaks, adds = {ranks: [] for ranks in given.ranks}, [], []
    used = {ranks: [] for ranks in given.ranks}
    triangles = triangles_of(given, folder)
    for _ in range(given.turns):
        for ranks in given.ranks:
            start = shoot(given, folder, ranks, few)
            all_of_it = shoot(given, folder, ranks, given.photons)
            rates[ranks].append((given.photons - few) / (all_of_it[0] - start[0]))
            used[ranks].append((given.photons - few) / (all_of_it[1] - start[1]))
            if ranks > 1:
                speaks.append(all_of_it[3] / all_of_it[2])
                adds.append(all_of_it[4] / triangles / math.ceil(math.log2(ranks)))
    merges = []
    for count in (2, 12):
        parts = []
        for part in range(count):
            cut = [str(given.photons * at // count // 100) for at in (part, part + 1)]
            parts.append(f"{count}-{part}.part")
            run([given.arboleda, "shoot", *shlex.split(given.scene), "--photons", str(given.photons // 100),
                 "--index", "wide-bvh", "--photon-range", "..".join(cut), "--part", parts[-1]], folder)
        took = [run([given.arboleda, "merge", *parts], folder)[1] for _ in range(given.turns)]
        merges.append(statistics.median(took))
    return rates, used, {
        "photon": 1.0 / statistics.median(used[min(given.ranks)]),
        "speak": statistics.median(speaks) if speaks else math.nan,
        "add": min(adds) if adds else math.nan,
        "part": (merges[1] - merges[0]) / 10 / triangles,
    }, triangles


def model(cost, ranks, photons, triangles, gigabits):
    """Seconds of a job, by what they are for."""
    shot = photons * cost["photon"] / ranks
    # Long ranges first; then each turn of all ranks takes a share of 1 - exp(-1/2) of what is left.
    short = min(photons, 2 * ranks * LONGEST / cost["photon"])
    turns = max(0.0, 2 * math.log(max(1.0, short / (2 * ranks * CHUNK))))
    ranges = (photons - short) * cost["photon"] / LONGEST + ranks * (turns + RAMP)
    levels = math.ceil(math.log2(ranks)) if ranks > 1 else 0
    sent = COUNTS * triangles * 8 / (gigabits * 1e9)
    return {
        "shoot": shot,
        # Rank 0 speaks while the others shoot: it is in the way only where it takes longer than they do.
        "speak": max(0.0, ranges * cost["speak"] - shot),
        "add": levels * (triangles * cost["add"] + sent),
        # The last range of the slowest rank, and rank 0's pauses before it looks who asks.
        "tail": min(shot, CHUNK * cost["photon"]) + (turns * PAUSE if ranks > 1 else 0.0),
    }


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--arboleda", default="arboleda", help="the program, with the feature mpi")
    parser.add_argument("--scene", default="--scene city", help="the scene, as on its command line")
    parser.add_argument("--photons", type=int, default=20_000_000)
    parser.add_argument("--ranks", type=lambda text: [int(part) for part in text.split(",")], default=[1, 2])
    parser.add_argument("--turns", type=int, default=5)
    parser.add_argument("--job", type=float, default=1e11, help="photons of the job in the table")
    parser.add_argument("--triangles", type=float, default=1e6, help="triangles of its scene")
    parser.add_argument("--gigabits", type=float, default=10.0, help="between two machines, in a second")
    given = parser.parse_args()
    os.environ.update(OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1",
                      OMPI_MCA_rmaps_base_oversubscribe="1", OMPI_MCA_btl_base_warn_component_unused="0")
    with tempfile.TemporaryDirectory() as folder:
        rates, used, cost, triangles = measure(given, folder)
    print(f"{given.scene}, {triangles:,} triangles; medians of {given.turns} turns, the least and the most of them")
    for ranks, all_rates in rates.items():
        median, least, most = statistics.median(all_rates), min(all_rates), max(all_rates)
        print(f"  {ranks} ranks: {median / 1e6:.3f} million photons/s ({least / 1e6:.3f} to {most / 1e6:.3f}), "
              f"{statistics.median(used[ranks]) / 1e6:.3f} of processor time")
    print(f"  a photon {cost['photon'] * 1e6:.3f} us, a range handed out {cost['speak'] * 1e6:.1f} us, "
          f"adding {cost['add'] * 1e9:.2f} ns a triangle and level, merging {cost['part'] * 1e9:.2f} ns a triangle "
          "and part")
    print(f"\na job of {given.job:.0e} photons, {given.triangles:.0e} triangles, {given.gigabits:g} Gbit/s:")
    print("| ranks | shooting | rank 0 in the way | adding | end | photons/s | efficiency |")
    print("|---:|---:|---:|---:|---:|---:|---:|")
    ranks = 1
    while ranks <= 1 << 20:
        parts = model(cost, ranks, given.job, given.triangles, given.gigabits)
        whole = sum(parts.values())
        efficiency = given.job * cost["photon"] / ranks / whole
        print(f"| {ranks:,} | {parts['shoot']:.3g} s | {parts['speak']:.3g} s | {parts['add']:.3g} s "
              f"| {parts['tail']:.3g} s | {given.job / whole:.3g} | {efficiency:.0%} |")
        ranks *= 4
    # From here on, adding takes as long as shooting.
    half = next(ranks for ranks in (2**power for power in range(1, 60))
                if sum(model(cost, ranks, given.job, given.triangles, given.gigabits).values())
                > 2 * given.job * cost["photon"] / ranks)
    print(f"\nhalf of the time is lost from {half:,} ranks on")


if __name__ == "__main__":
    main()
