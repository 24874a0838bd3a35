#!/usr/bin/env python3
"""memory_limit_test.py PSIVOX MAKE_ASSETS: a volume that is several times as large as --memory-limit
is drawn within the limit + 10 %, by the peak of resident memory that the system reports, and the
picture is that of the whole; in light, too. The program does not link OpenVDB, which its reading
process loads."""
import os
import re
import subprocess
import sys
import tempfile

program, make_assets = (os.path.abspath(path) for path in sys.argv[1:3])
MIB = 1 << 20
os.environ["MESA_SHADER_CACHE_DISABLE"] = "true"  # the driver's compiler takes its memory each time


devices = subprocess.run([program, "render", "--list-devices"], capture_output=True, text=True)
if not re.search(r"4\.[5-9]", devices.stdout):
    sys.exit(77)  # no EGL device


def peak_of(*arguments):
    """Runs a command; what it printed to stderr, and the peak of its resident memory [bytes]."""
    child = subprocess.Popen(arguments, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    said = child.stderr.read()
    _, status, usage = os.wait4(child.pid, 0)
    assert os.waitstatus_to_exitcode(status) == 0, said
    return said, usage.ru_maxrss * 1024


def render(output, *options):
    return peak_of(program, "render", "fog.vdb", "-o", output, "--sampling", "cells",
                   "--early-termination", "0", "--resolution", "160x90", "--look", "plain",
                   *options)


libraries = subprocess.run(["ldd", program], capture_output=True, text=True, check=True).stdout
assert "libopenvdb" not in libraries, libraries

with tempfile.TemporaryDirectory() as folder:
    os.chdir(folder)
    subprocess.run([make_assets, "--fog", "fog.vdb", "256"], check=True, stdout=subprocess.DEVNULL)
    _, whole = render("whole.exr", "--memory-limit", "4G")
    limit = 150 * MIB
    # 64 MiB of values, which become 94 MiB of an atlas, from which a driver on the CPU draws
    said, parts = render("parts.exr", "--memory-limit", str(limit))
    print(f"peak: whole {whole / MIB:.0f} MiB, in parts {parts / MIB:.0f} MiB")
    assert "64.00 MiB, stay in the file" in said, said
    assert re.search(r"drawn in \d+ parts", said), said
    assert whole > 1.3 * limit, "the volume is too small to tell"
    assert parts < 1.1 * limit, parts / limit
    subprocess.run([program, "compare", "whole.exr", "parts.exr", "--max-rms", "1e-6"], check=True)

    # values and atlas, 158 MiB beside the program's 170, and no room for another atlas
    limit = 345 * MIB
    said, between = render("between.exr", "--memory-limit", str(limit))
    print(f"peak of the whole under a limit: {between / MIB:.0f} MiB")
    assert "parts" not in said, said
    assert between < limit, between / limit
    subprocess.run([program, "compare", "whole.exr", "between.exr", "--max-abs", "0"], check=True)

    # in light the values are in memory, and those of the light as well: 64 MiB each
    def lit(output, limit):
        return peak_of(program, "render", "fog.vdb", "-o", output, "--resolution", "160x90",
                       "--look", "plain", "--light", "0.3,-1,0.2",
                       "--memory-limit", str(limit))

    _, whole = lit("whole.exr", 4096 * MIB)
    limit = 320 * MIB
    said, parts = lit("parts.exr", limit)
    print(f"peak in light: whole {whole / MIB:.0f} MiB, in parts {parts / MIB:.0f} MiB")
    assert re.search(r"drawn in \d+ parts", said), said
    assert parts < min(1.1 * limit, 0.9 * whole), (parts / limit, parts / whole)
    # each is within 1e-3 of the exact picture
    subprocess.run([program, "compare", "whole.exr", "parts.exr", "--max-rms", "2e-3"], check=True)
    limit = 520 * MIB  # 316 MiB of values, light and an atlas of each
    said, between = lit("between.exr", limit)
    print(f"peak of the whole in light under a limit: {between / MIB:.0f} MiB")
    assert "parts" not in said, said
    assert between < limit, between / limit
    subprocess.run([program, "compare", "whole.exr", "between.exr", "--max-rms", "2e-3"], check=True)

    child = subprocess.run([program, "render", "fog.vdb", "-o", "a.exr", "--resolution", "32x18",
                            "--memory-limit", "299M", "--light", "0,-1,0"], capture_output=True,
                           text=True)
    assert child.returncode == 6 and "light needs" in child.stderr.splitlines()[-1], child

    # what needs all values at once says so
    for options, word in ((["--light", "0,-1,0"], "light"), (["--check-error", "10"], "raise"),
                          (["--explain"], "raise"), (["--aov", "error"], "layer error")):
        child = subprocess.run([program, "render", "fog.vdb", "-o", "a.exr", "--resolution", "32x18",
                                "--memory-limit", "170M", *options], capture_output=True, text=True)
        assert child.returncode == 6 and word in child.stderr.splitlines()[-1], (options, child)
