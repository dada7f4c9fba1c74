#!/usr/bin/env python3
"""Shoots a job in parts on the workers of Dask, and merges them as they come.

    python dask_parts.py --scheduler tcp://head:8786 --parts 100 --all 10000000000 --folder parts --out flux.npy \\
        -- shoot city.obj --photons 10000000000

ALL is the number of all photons (--photons, times --passes of a picture). FOLDER is one that all workers see. The
program, the scene with its materials, and the points are at the same absolute paths on all workers, and here. Without
--scheduler, two workers of this machine are started. A part that is there is not shot again, so a job that was stopped
goes on where it was. Options of `arboleda merge` may follow --out, as in --merge "--values city.exr".
"""

import argparse
import os
import shlex
import subprocess
import sys
from pathlib import Path

from dask.distributed import Client, LocalCluster, as_completed

# Parts that are merged at once: then all levels of merges together read little more than the parts.
AT_ONCE = 8


def run(arboleda, *arguments):
    """Runs the program. An error has what it said."""
    done = subprocess.run([arboleda, *map(str, arguments)], capture_output=True, text=True)
    if done.returncode != 0:
        raise RuntimeError(f"{shlex.join(done.args)}: {done.stderr.strip()}")
    return done.stdout


def shoot(arboleda, command, start, end, path):
    """Shoots a range of the photons; a part that is there is whole."""
    if not os.path.exists(path):
        run(arboleda, *command, "--photon-range", f"{start}..{end}", "--part", path)
    return path


def merge(arboleda, parts, path):
    """Makes one part of neighbours."""
    if not os.path.exists(path):
        run(arboleda, "merge", *parts, "--part", path)
    return path


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scheduler", help="address of the scheduler")
    parser.add_argument("--parts", type=int, required=True)
    parser.add_argument("--all", type=int, required=True, help="number of all photons")
    parser.add_argument("--folder", type=Path, required=True)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--merge", default="", help="more options of `arboleda merge`")
    parser.add_argument("--arboleda", default="arboleda", help="the program, at the same path on all workers")
    parser.add_argument("command", nargs="+", help="-- and the command of arboleda")
    given = parser.parse_args()
    if not 1 <= given.parts <= given.all:
        parser.error("--parts must be 1 up to --all")
    return given


def main():
    given = arguments()
    folder = given.folder.resolve()
    folder.mkdir(parents=True, exist_ok=True)
    # Parts that are there count only if they are of this job, cut alike.
    job = shlex.join([str(given.parts), str(given.all), *given.command])
    file = folder / "job"
    if file.exists() and file.read_text() != job:
        sys.exit(f"{folder} has parts of another job: {file.read_text()}; give another folder")
    file.write_text(job)
    cuts = [given.all * part // given.parts for part in range(given.parts + 1)]
    cluster = None if given.scheduler else LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None)
    with Client(given.scheduler or cluster) as client:
        # 1. The parts. Photons are numbered, so it does not matter which worker shoots which.
        row = [
            client.submit(shoot, given.arboleda, given.command, start, end, str(folder / f"{start}-{end}.part"),
                          pure=False, retries=3)
            for start, end in zip(cuts, cuts[1:])
        ]
        parts, merged, level = list(row), [], 0
        # 2. Neighbours are merged as soon as all of them are there.
        while len(row) > AT_ONCE:
            groups = [row[first:first + AT_ONCE] for first in range(0, len(row), AT_ONCE)]
            names = [f"level{level}-{number}-of-{len(groups)}.merged" for number in range(len(groups))]
            row = [
                client.submit(merge, given.arboleda, group, str(folder / name), pure=False, retries=3)
                for group, name in zip(groups, names)
            ]
            merged, level = merged + row, level + 1
        for done, future in enumerate(as_completed(parts), 1):
            future.result()
            print(f"{done} of {len(parts)} parts", file=sys.stderr)
        last = client.gather(row)
        merged = client.gather(merged)
    if cluster:
        cluster.close()
    # 3. The result.
    print(run(given.arboleda, "merge", *last, "--out", given.out, *shlex.split(given.merge)), end="")
    for path in merged:
        os.remove(path)


if __name__ == "__main__":
    main()
