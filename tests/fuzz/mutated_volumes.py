#!/usr/bin/env python3
"""Changes small volumes at random and gives each to psivox. All must end in exit code 0, 3 or 6 (too
large) within the limit of processor time, with one line on stderr for 3 and 6, and a whole output or
none.

    mutated_volumes.py PSIVOX SEED.vdb... [--count N] [--first N] [--jobs N] [--keep FOLDER]

A file's number decides everything about it, so that a finding can be made again with
--first NUMBER --count 1. Prints a table, and the findings. With ASAN_OPTIONS=detect_leaks=0 in the
environment PSIVOX may be a program built with PSIVOX_SANITIZE; it has more time and addresses.
"""
import argparse
import collections
import concurrent.futures
import ctypes
import os
import random
import resource
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import time
import zlib

TIME_LIMIT = 20  # [s] of processor time
ADDRESSES = 16 << 30  # [bytes] of each process, so that a finding does not take the machine's memory
try:
    BLOSC = ctypes.CDLL("libblosc.so.1")
except OSError:
    BLOSC = None

EXTREMES = [0, 1, 2, 7, 0x7F, 0xFF, 0x7FFF, 0xFFFF, 1 << 20, 1 << 30, (1 << 31) - 1, 1 << 31,
            (1 << 32) - 1, 1 << 40, (1 << 63) - 1, 1 << 63, (1 << 64) - 1]
MOST = 3.4028234663852886e38
FLOATS = [float("nan"), float("inf"), float("-inf"), -1.0, 1e38, -1e38, 1e-40, 0.0, 1e30, MOST, -MOST,
          5e37, -5e37, 1e36, 1e20, -9999.0]
# Looks, light, functions, modes, pages and studies. The first is the most frequent: light at the
# voxels of a volume that became huge takes its time. The reference has no light: it casts a ray from
# each voxel.
OPTIONS = [["--look", "plain"]] * 4 + [option.split() for option in [
    "", "--look smoke", "--look scan", "--look signed", "--look labels", "--look surface",
    "--colormap viridis", "--colormap viridis --opacity 0:1,1:1 --light 1,-1,-1",
    "--look plain --light 1,-1,-1", "--look plain --sky 1,1,1", "--look plain --step 1",
    "--look plain --texel code7", "--look plain --integrator psi-table",
    "--colormap hot --integrator preintegrated", "--classification nearest", "--lod 1",
    "--classification pre --colormap gray", "--mode mip", "--mode lmip", "--mode xray",
    "--mode isosurface", "--mode slice", "--renderer reference --look plain",
    "--renderer march-double",
    "--fill-value none", "--fill-value none --colormap viridis", "--range 1%,99%",
    "--luminance-grid density --look plain", "--background white", "--exposure auto",
    "page", "page --look plain", "page --look labels", "page --mode mip",
    "study --integrators psi-weighted,cell-exact --steps 2,1 --look plain"]]
# What a call writes, and how its first bytes are.
OUTPUTS = {"render": (".exr", b"\x76\x2f\x31\x01"), "page": (".html", b"<!DOCTYPE html>"),
           "study": ("", None)}


class Block:
    """A compressed block of values: its length is the integer of 64 bits at `at`."""

    def __init__(self, at, length, values, codec):
        self.at, self.length, self.values, self.codec = at, length, values, codec


def unpack(data, at, length):
    """The values of the block at `at`, and its codec; None if there is none."""
    begin = at + 8
    if data[begin] == 0x78:
        try:
            return zlib.decompress(data[begin:begin + length]), "zip"
        except zlib.error:
            return None
    if BLOSC and length >= 16 and data[begin] == 2:
        size, _, packed = struct.unpack_from("<iii", data, begin + 4)
        if packed != length or not 0 < size < 1 << 22:
            return None
        values = ctypes.create_string_buffer(size)
        if BLOSC.blosc_decompress_ctx(bytes(data[begin:begin + length]), values, size, 1) == size:
            return values.raw, "blosc"
    return None


def pack(values, codec):
    if codec == "zip":
        return zlib.compress(values)
    room = ctypes.create_string_buffer(len(values) + 16)
    n = BLOSC.blosc_compress_ctx(9, 1, ctypes.c_size_t(4), ctypes.c_size_t(len(values)),
                                 bytes(values), room, ctypes.c_size_t(len(room)), b"lz4",
                                 ctypes.c_size_t(0), 1)
    return room.raw[:n]


def find_blocks(data):
    blocks = []
    for at in range(len(data) - 24):
        (length,) = struct.unpack_from("<q", data, at)
        if 0 < length <= len(data) - at - 8:
            found = unpack(data, at, length)
            if found:
                blocks.append(Block(at, length, *found))
    return blocks


def find_positions(data):
    """Places of the three positions that end each entry of the directory."""
    places = []
    for at in range(len(data) - 24):
        grid, block, end = struct.unpack_from("<qqq", data, at)
        if grid == at + 24 and grid <= block <= end <= len(data):
            places.append(at)
    return places


class Seed:
    def __init__(self, path):
        with open(path, "rb") as file:
            self.data = file.read()
        self.blocks, self.positions = find_blocks(self.data), find_positions(self.data)


def change_bytes(data, rng, count):
    for _ in range(count):
        at = rng.randrange(len(data))
        if rng.random() < 0.5:
            data[at] ^= 1 << rng.randrange(8)
        else:
            data[at] = rng.randrange(256)


def anywhere(seed, rng):
    data = bytearray(seed.data)
    change_bytes(data, rng, rng.randint(1, 20))
    return data


def structure(seed, rng):
    """Extreme numbers in the header, the directory, metadata and upper nodes."""
    data = bytearray(seed.data)
    near = rng.choice([0] + seed.positions)
    for _ in range(rng.randint(1, 4)):
        at = near + int(rng.random() ** 2 * 1500)
        size = rng.choice([1, 4, 8])
        if at + size <= len(data):
            value = rng.choice(EXTREMES) % (1 << 8 * size)
            data[at:at + size] = value.to_bytes(size, "little")
    return data


def header(seed, rng):
    """Magic number, versions, codec, half precision."""
    data = bytearray(seed.data)
    if rng.random() < 0.5:
        struct.pack_into("<I", data, 8, rng.choice([rng.randrange(300), *EXTREMES[:12]]) % (1 << 32))
    else:
        data[rng.randrange(60)] ^= 1 << rng.randrange(8)
    return data


def inside_blocks(seed, rng):
    """Values inside compressed blocks, with right lengths and positions around them."""
    if not seed.blocks:
        return anywhere(seed, rng)
    data = bytearray(seed.data)
    chosen = rng.sample(seed.blocks, min(rng.randint(1, 5), len(seed.blocks)))
    for block in sorted(chosen, key=lambda b: -b.at):  # from the back: places before stay
        values = bytearray(block.values)
        for _ in range(rng.randint(1, 20)):
            at = rng.randrange(max(1, len(values) // 4)) * 4
            if rng.random() < 0.7 and at + 4 <= len(values):
                struct.pack_into("<f", values, at, rng.choice(FLOATS))
            else:
                change_bytes(values, rng, 1)
        if rng.random() < 0.1:  # another number of values
            values = values[:rng.randrange(len(values))] if rng.random() < 0.5 else values * 2
        packed = pack(values, block.codec)
        more = len(packed) - block.length
        data[block.at:block.at + 8 + block.length] = struct.pack("<q", len(packed)) + packed
        for place in seed.positions:
            for at in range(place, place + 24, 8):
                (position,) = struct.unpack_from("<q", data, at)
                if position > block.at:
                    struct.pack_into("<q", data, at, position + more)
    return data


def codec_bytes(seed, rng):
    """The compressed bytes themselves and their lengths."""
    if not seed.blocks:
        return anywhere(seed, rng)
    data = bytearray(seed.data)
    for _ in range(rng.randint(1, 5)):
        block = rng.choice(seed.blocks)
        at = block.at + rng.choice([rng.randrange(8), 8 + rng.randrange(16),
                                    8 + rng.randrange(block.length)])
        if at < len(data):
            data[at] = rng.choice([rng.randrange(256), data[at] ^ 1 << rng.randrange(8)])
    return data


def runs(seed, rng):
    """Runs of equal bytes, which reach whole masks of nodes."""
    data = bytearray(seed.data)
    for _ in range(rng.randint(1, 3)):
        at, length = rng.randrange(len(data)), rng.choice([8, 16, 64, 512, 4096])
        end = min(len(data), at + length)
        data[at:end] = bytes([rng.choice([0, 0xFF, rng.randrange(256)])]) * (end - at)
    return data


def moved(seed, rng):
    """Cut, extended, or with bytes left out or doubled."""
    data = bytearray(seed.data)
    at, length = rng.randrange(len(data)), rng.randint(1, 200)
    kind = rng.randrange(4)
    if kind == 0:
        del data[at:]
    elif kind == 1:
        del data[at:at + length]
    elif kind == 2:
        data[at:at] = data[at:at + length]
    else:
        other = rng.randrange(len(data))
        data[at:at + length] = data[other:other + length]
    return data


# Read, refused in one line, and refused because the guarded process crashed.
GOOD = ("read", "refused", "crashed")
MUTATIONS = [anywhere, structure, header, inside_blocks, inside_blocks, codec_bytes, runs, moved]


def set_limits():
    if "ASAN_OPTIONS" not in os.environ:  # whose shadow memory is terabytes, and which takes its time
        resource.setrlimit(resource.RLIMIT_AS, (ADDRESSES, ADDRESSES))
        resource.setrlimit(resource.RLIMIT_CPU, (TIME_LIMIT, TIME_LIMIT + 1))


def try_file(psivox, seed, number, folder):
    """The mutation's name and the options, the result, and the seconds."""
    rng = random.Random(number)
    mutation = MUTATIONS[number % len(MUTATIONS)]
    path = os.path.join(folder, f"{number}.vdb")
    with open(path, "wb") as file:
        file.write(mutation(seed, rng))
    options = rng.choice(OPTIONS) if number // len(MUTATIONS) % 4 == 0 else ["info"]
    command, output = command_of(psivox, path, options)
    begin = time.monotonic()
    try:
        done = subprocess.run(command, capture_output=True, timeout=30 * TIME_LIMIT,
                              preexec_fn=set_limits, check=False)
        result = judge(done, output)
    except subprocess.TimeoutExpired:
        result = "hangs"
    seconds = time.monotonic() - begin
    if output:
        remove(output.path)
    if result in GOOD:
        os.remove(path)
    return mutation.__name__, " ".join(options), result, seconds


class Output:
    """A file with its first bytes, or the folder of a study, whose `begin` is None."""

    def __init__(self, path, begin):
        self.path, self.begin = path, begin

    def is_whole(self):
        path = self.path if self.begin else os.path.join(self.path, "index.html")
        if not os.path.exists(path):
            return False
        with open(path, "rb") as file:
            return file.read(15).startswith(self.begin or b"<") and os.path.getsize(path) > 300


def command_of(psivox, path, options):
    """The call, and what it writes: None for info."""
    if options == ["info"]:
        return [psivox, "info", path, "--json"], None
    kind = options[0] if options and options[0] in OUTPUTS else "render"
    extension, begin = OUTPUTS[kind]
    output = Output(path[:-len(".vdb")] + extension, begin)
    return [psivox, "study" if kind == "study" else "render", path, "-o", output.path,
            "--resolution", "16x16", "-q", *options[options[:1] == [kind]:]], output


def remove(path):
    if os.path.isdir(path):
        shutil.rmtree(path)
    elif os.path.exists(path):
        os.remove(path)


def judge(done, output):
    said = done.stderr.decode(errors="replace").strip("\n").split("\n")
    # OpenVDB's own, which only a sanitized reader's stderr shows
    lines = [line for line in said if line != "WARNING: multi-buffer trees are no longer supported"]
    if done.returncode == -signal.SIGXCPU:
        return "slow"
    if done.returncode == 0:
        return "read" if not output or output.is_whole() else "no whole output"
    if done.returncode in (3, 6):
        if output and os.path.exists(output.path):
            return "output of an error"
        if is_of_reader(lines):
            return "crashed"
        if len(lines) != 1 or not lines[0]:
            return f"{len(lines)} lines: {lines}"
        return "crashed" if "reading it crashed" in lines[0] else "refused"
    return f"exit code {done.returncode}: {lines[-1][:200]}"


def is_of_reader(lines):
    """Whether AddressSanitizer's report is OpenVDB's own, in the guarded process. Sizes that a file
    claims end it there: the sanitizer's new throws no std::bad_alloc."""
    report = "\n".join(lines)
    in_reader = "(psivox-readers)" in report or "out-of-memory" in report
    if "AddressSanitizer" not in report or not in_reader:
        return False
    first, own = report.find("openvdb::"), report.find("psivox::")
    return first >= 0 and (own < 0 or first < own)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n", maxsplit=1)[0])
    parser.add_argument("psivox")
    parser.add_argument("seeds", nargs="+")
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--keep", help="folder for the files of findings")
    call = parser.parse_args()
    seeds = [Seed(path) for path in sorted(call.seeds)]
    table, findings, slowest = collections.Counter(), [], 0
    with tempfile.TemporaryDirectory() as scratch:
        folder = call.keep or scratch
        os.makedirs(folder, exist_ok=True)
        with concurrent.futures.ThreadPoolExecutor(call.jobs) as pool:
            numbers = range(call.first, call.first + call.count)
            tries = pool.map(lambda n: try_file(call.psivox, seeds[n // 7 % len(seeds)], n, folder),
                             numbers)
            for number, (mutation, options, result, seconds) in zip(numbers, tries):
                table[mutation, result if result in GOOD else "finding"] += 1
                slowest = max(slowest, seconds)
                if result not in GOOD:
                    findings.append(f"{number} ({mutation}, {options}, {seconds:.1f} s): {result}")
                    print(findings[-1], flush=True)
        hidden = [name for name in os.listdir(folder) if name.startswith(".")]
    if hidden:
        findings.append(f"unfinished files are left: {hidden}")
    print(f"{'mutation':<14}{'read':>8}{'refused':>9}{'crashed':>9}{'findings':>10}")
    for mutation in dict.fromkeys(m.__name__ for m in MUTATIONS):
        row = [table[mutation, result] for result in (*GOOD, "finding")]
        print(f"{mutation:<14}{row[0]:>8}{row[1]:>9}{row[2]:>9}{row[3]:>10}")
    print(f"{call.count} files of {len(seeds)} seeds, {len(findings)} findings; the slowest took "
          f"{slowest:.1f} s")
    return 1 if findings else 0


if __name__ == "__main__":
    sys.exit(main())
