# Copyright 2026 The heading_intercompare authors
#
# Licensed under the Apache License, Version 2.0 (the "License");
# you may not use this file except in compliance with the License.
# You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software
# distributed under the License is distributed on an "AS IS" BASIS,
# WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
# See the License for the specific language governing permissions and
# limitations under the License.

"""
What a recording keeps when the machine loses power: a disk of its own, cut off again and again.

Each round makes a disk in a file, mounts it, and starts the live graph, which records two sensors
at 100 Hz to it. After some random seconds the disk is shut down as a power cut would: the file
system takes nothing more, and what it had not written is gone. Then the graph is killed. The disk
is mounted again, as after the restart of the machine, and the bag is read.

Each reading has its number as its heading, so it is known which ones are in the bag. The table has
by round the age of the oldest reading lost, seconds before the cut; the readings in the bag; how
many are missing before the last of them; and whether recovery keeps all, and the journal is read.

Promise: no reading is lost that is older than a second, and none is missing before the last, in
twenty cuts. The exit code is 1 if it is broken. It needs Linux, ext4, and the rights to mount.

    sudo python benchmarks/power_cuts.py
    sudo python benchmarks/power_cuts.py --rounds 3 --split 2
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from contextlib import contextmanager
import fcntl
import json
import os
from pathlib import Path
import random
import socket
import struct
import subprocess
import sys
from tempfile import TemporaryDirectory
import time

import history
from live import free_port, make_sentence, Process, TOPICS
import numpy as np

from heading_intercompare.bags.recovery.recover_bag import recover
from heading_intercompare.bags.rosbag2.bag_reader import BagReader
from heading_intercompare.journal.journal_file import read_journal

RATE_HZ = 100.0
#: The recorder keeps 1 GB free.
DISK_MB = 4096
SHORTEST_S, LONGEST_S = 3.0, 9.0
LONGEST_WAIT_S = 60.0
OLDEST_MOST_S = 1.0
#: More than a journal without readings has, which holds the settings.
SETTINGS_BYTES = 40_000
#: A heading in sentences has three decimals.
PER_DEG = 1000
#: The ioctl that shuts down ext4, and the flag to drop what it has not written.
SHUT_DOWN, DROP = 0x8004587D, struct.pack('I', 2)


@contextmanager
def mounted(image: Path, place: Path) -> Iterator[None]:
    """Mount a disk that is a file."""
    subprocess.run(['mount', '-o', 'loop', image, place], check=True)
    try:
        yield
    finally:
        subprocess.run(['umount', place], check=True)


def send(ports: list[int], journal: Path, seconds: float, graph: Process) -> np.ndarray:
    """Send numbers as headings to both drivers; stop some seconds after they are kept."""
    sent_s: list[float] = []
    began_s, end_s = time.monotonic(), time.monotonic() + LONGEST_WAIT_S
    recording = False
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as line:
        while time.monotonic() < end_s:
            sent_s.append(time.monotonic())
            sentence = make_sentence(len(sent_s) / PER_DEG)
            for port in ports:
                line.sendto(sentence, ('127.0.0.1', port))
            time.sleep(max(0.0, began_s + len(sent_s) / RATE_HZ - time.monotonic()))
            # It ends the benchmark if the graph is gone.
            if not recording and graph.memory_mb() and journal.exists() and (
                    journal.stat().st_size > SETTINGS_BYTES):
                recording, end_s = True, time.monotonic() + seconds
    return np.array(sent_s)


def shut_down(place: Path) -> float:
    """Drop what the file system of a place has not written, and take nothing more; return when."""
    descriptor = os.open(place, os.O_RDONLY)
    try:
        now_s = time.monotonic()
        fcntl.ioctl(descriptor, SHUT_DOWN, DROP)
        return now_s
    finally:
        os.close(descriptor)


def read_numbers(bag: Path) -> list[np.ndarray]:
    """Return the numbers of the readings in a bag, by topic."""
    topics = [f'/{topic}' for topic in TOPICS]
    chunks = list(BagReader(bag).headings(dict.fromkeys(topics, 'enu')))
    return [np.concatenate([np.rint(chunk[topic].heading_deg * PER_DEG).astype(int) - 1
                            for chunk in chunks if topic in chunk] or [np.empty(0, int)])
            for topic in topics]


def cut(folder: Path, domain: int, seconds: float, split_s: float) -> tuple[float, int, int, str]:
    """Record, cut, read; return the age of the oldest lost, held, missing, and what is wrong."""
    image, place = folder / 'disk', folder / 'place'
    place.mkdir()
    with image.open('wb') as file:
        file.truncate(DISK_MB << 20)
    subprocess.run(['mkfs.ext4', '-q', image], check=True)
    ports = [free_port(), free_port()]
    parameters = {f'{topic[:2]}_driver': {'source': f'udp://127.0.0.1:{port}', 'sentence': 'HDT'}
                  for topic, port in zip(TOPICS, ports)}
    parameters['recorder'] = {'split_duration_s': split_s}
    # A parameter file is YAML, and so is JSON.
    (folder / 'config.yaml').write_text(json.dumps(
        {node: {'ros__parameters': values} for node, values in parameters.items()}), 'utf-8')
    with mounted(image, place):
        process = Process(['-m', 'heading_intercompare', 'live', '--config',
                           str(folder / 'config.yaml'), '-o', 'trial', '--quiet',
                           '--set=norms.sigma_max_deg=0.3', '--set=norms.sigma_ref_max_deg=0.1'],
                          place, domain)
        sent_s = send(ports, place / 'trial.journal', seconds, process)
        cut_s = shut_down(place)
        process.process.kill()
        process.process.wait(LONGEST_WAIT_S)
    with mounted(image, place):
        numbers = read_numbers(place / 'trial')
        recover(place / 'trial', folder / 'recovered')
        wrong = []
        if not all(map(np.array_equal, numbers, read_numbers(folder / 'recovered'))):
            wrong.append('recovery loses readings')
        if not read_journal(place / 'trial.journal').records:
            wrong.append('the journal is empty')
    oldest_s = max(cut_s - sent_s[of_topic[-1] + 1] if of_topic[-1] + 1 < len(sent_s) else 0.0
                   for of_topic in numbers)
    missing = sum(int(np.setdiff1d(np.arange(of_topic[0], of_topic[-1]), of_topic).size)
                  for of_topic in numbers)
    return oldest_s, sum(map(len, numbers)), missing, ', '.join(wrong) or '-'


def main() -> int:
    """Print the table; return 1 if the promise is broken."""
    parser = argparse.ArgumentParser(description=__doc__.partition('\n\n')[0])
    parser.add_argument('--rounds', type=int, default=20)
    parser.add_argument('--split', type=float, default=0.0, metavar='S',
                        help='begin a new file of the bag every S seconds (default: never)')
    parser.add_argument('--domain', type=int, default=87, help='ROS domain (default: 87)')
    history.add_option(parser)
    arguments = parser.parse_args()
    if os.geteuid() or sys.platform != 'linux':
        raise SystemExit('mounting a disk needs Linux and the rights of root')
    rng, results = random.Random(1), []
    print('| cut | oldest reading lost | in the bag | missing before its last | wrong |')
    print('|---|---|---|---|---|')
    for number in range(arguments.rounds):
        with TemporaryDirectory(prefix='power') as name:
            seconds = rng.uniform(SHORTEST_S, LONGEST_S)
            results.append(cut(Path(name), arguments.domain, seconds, arguments.split))
        oldest_s, held, missing, wrong = results[-1]
        print(f'| {number + 1} | {oldest_s:.2f} s | {held} | {missing} | {wrong} |', flush=True)
    oldest_s = max(result[0] for result in results)
    if arguments.keep:
        history.keep('power_cuts', {'oldest reading lost, s': oldest_s})
    broken = oldest_s > OLDEST_MOST_S or any(result[2] or result[3] != '-' for result in results)
    print(f'\n{"BROKEN" if broken else "Held"}: the oldest reading lost was sent {oldest_s:.2f} s '
          f'before the cut; {OLDEST_MOST_S:g} s promised.')
    return int(broken)


if __name__ == '__main__':
    sys.exit(main())
