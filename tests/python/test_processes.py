"""Threads, signals, forks and memory."""

import os
import resource
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import psivox
from psivox import _core

SMALL = (48, 32)


def test_a_session_draws_what_render_draws(blobs):
    # light as exact as a tolerance asks goes by the first picture's rays
    look = {"look": "plain", "light": (1, -1, 0), "extinction": 4, "light_quality": "exact"}
    with psivox.Session(blobs, resolution=SMALL, **look) as session:
        for scene in ({}, {"azimuth": 40}, {"tolerance": 1e-4}, {"mode": "mip"},
                      {"extinction": 2}, {"light": "camera:0,-1,0", "zoom": 2}, {"resolution": (20, 30), "step": 2},
                      {"clip": (-1, -1, -1, 0, 1, 1)}, {}):
            kept = {**look, "resolution": SMALL, **scene}
            a, b = session.render(**scene), psivox.render(blobs, **kept)
            # light that was computed for a picture before is summed in another order
            assert psivox.compare(a, b).max <= 2**-22, scene
            assert {**a.scene, "integrator": 0, "sampling": 0} == \
                {**b.scene, "integrator": 0, "sampling": 0}


@pytest.mark.parametrize("kind", ["file", "array"])
def test_a_sessions_pictures_do_not_depend_on_those_before(blobs, kind):
    """The look is chosen for the session's own scene, and what a call gives counts."""
    source = blobs if kind == "file" else np.random.default_rng(0).random((20, 20, 20), dtype="f4")
    scenes = [{}, {"azimuth": 90}, {"camera_position": (0, 0, 9)}, {"azimuth": 0, "elevation": 0},
              {"light": "none"}, {"step": 0.5},
              {"azimuth": 50, "check_error": 16}]
    with psivox.Session(source, resolution=SMALL) as session, \
            psivox.Session(source, resolution=SMALL) as other:
        forth = [session.render(**scene) for scene in scenes]
        back = [other.render(**scene) for scene in reversed(scenes)][::-1]
    for scene, a, b in zip(scenes, forth, back):
        assert psivox.compare(a, b).max <= 2**-22, scene
        for name in a.scene.keys() - {"integrator", "sampling", "early-termination"}:  # or auto
            assert a.scene[name] == b.scene[name], (scene, name)
        given = psivox.render(source, resolution=(4, 3), **scene).scene
        for name in scene.keys() & given.keys():
            assert a.scene[name] == given[name]
    assert psivox.compare(forth[0], psivox.render(source, resolution=SMALL)).max == 0


def resident_mib():
    with open("/proc/self/statm", encoding="ascii") as file:
        return int(file.read().split()[1]) * resource.getpagesize() / 2**20


def test_the_limit_of_memory_is_kept_in_light():
    """43 MiB of values that all differ, as many of their light, and an atlas in parts beside them."""
    limit = 280 << 20
    drawn = subprocess.run([sys.executable, "-c", f"""
import numpy as np, psivox
values = np.random.default_rng(1).random((224, 224, 224), dtype="f4")
picture = psivox.render(values, resolution=(64, 36), light=(0.3, -1, 0.2), memory_limit={limit})
assert any("parts" in line for line in picture.notices), picture.notices
# its own peak: that of getrusage begins with what pytest's process has
print(open("/proc/self/status").read().split("VmHWM:")[1].split()[0])
"""], check=True, capture_output=True, text=True)
    assert 1024 * int(drawn.stdout) < 1.1 * limit


def test_many_pictures_leak_nothing():
    """Memory and OpenGL objects: the last 700 of 1,000 pictures need none."""
    values = np.random.RandomState(1).rand(16, 16, 16).astype("f4")
    counts = []
    with psivox.Session(values, look="plain", resolution=(8, 8), step=1) as session:
        def count(fraction):
            if fraction == 1:  # a context is current
                counts.append(_core.gl_objects())
        for n in range(1000):
            session.render(azimuth=n, progress=count if n % 100 == 99 else None)
            if n == 300:
                before = resident_mib()
        # a leak of 16 KiB a picture would be 11 MiB; malloc grows by arenas of some MiB
        assert resident_mib() - before < 8
    assert len(counts) == 10 and all(c == counts[0] for c in counts)


def test_sessions_leak_nothing():
    """Each with a volume of 2 MiB, drawn and forgotten."""
    values = np.random.RandomState(1).rand(80, 80, 80).astype("f4")
    for n in range(30):
        psivox.render(values, look="plain", resolution=(8, 8), step=4)
        if n == 9:
            before = resident_mib()
    assert resident_mib() - before < 10


def test_two_threads_draw_at_a_time(blobs):
    """Each with a session of its own, and both with one."""
    expected = psivox.render(blobs, resolution=SMALL)
    shared = psivox.Session(blobs, resolution=SMALL)
    inside, most, differences = [0], [0], []

    def draw():
        def progress(fraction):
            if fraction == 0:
                inside[0] += 1
                most[0] = max(most[0], inside[0])
                time.sleep(0.05)  # without the GIL the other thread comes as far
                inside[0] -= 1
        for session in (None, shared):
            image = session.render() if session else psivox.render(blobs, resolution=SMALL,
                                                                   progress=progress)
            differences.append(psivox.compare(image, expected).max)
    threads = [threading.Thread(target=draw) for _ in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert differences == [0] * 6


def run_python(code, **options):
    return subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True,
                            **options)


def test_ctrl_c_ends_a_picture():
    process = run_python("""
import numpy as np, psivox
values = np.random.rand(40, 40, 40)
def progress(fraction):
    print("drawing", flush=True)
try:
    psivox.render(values, resolution=(3000, 3000), tolerance=1e-6, progress=progress)
    print("done")
except KeyboardInterrupt:
    psivox.render(values, resolution=(8, 8))
    print("ended")
""")
    assert process.stdout.readline() == "drawing\n"
    process.send_signal(signal.SIGINT)
    assert process.communicate(timeout=60)[0].endswith("ended\n") and process.returncode == 0


def test_python_ends_while_a_thread_draws():
    process = run_python("""
import numpy as np, psivox, threading, time
values, drawing = np.random.rand(40, 40, 40), threading.Event()
def draw():
    while True:
        psivox.render(values, resolution=(400, 400), progress=lambda fraction: drawing.set())
threading.Thread(target=draw, daemon=True).start()
drawing.wait()
""", stderr=subprocess.DEVNULL)
    assert process.wait(timeout=60) == 0


def test_a_forked_process_is_told(blobs):
    process = run_python(f"""
import os, psivox
psivox.render({blobs!r}, resolution=(4, 4))
if os.fork() == 0:
    try:
        psivox.render({blobs!r}, resolution=(4, 4))
    except psivox.Error as error:
        print(error.exit_code, "spawn" in str(error), flush=True)
    os._exit(0)  # as multiprocessing does: the driver has no threads here to end
else:
    os.wait()
""")
    assert process.communicate(timeout=60)[0] == "1 True\n" and process.returncode == 0


def test_readers_end_with_the_process(blobs):
    process = run_python(f"import psivox; psivox.open({blobs!r}); print('open', flush=True); input()",
                         stdin=subprocess.PIPE)
    process.stdout.readline()
    children = open(f"/proc/{process.pid}/task/{process.pid}/children").read().split()
    assert children
    process.kill()
    process.wait()
    for _ in range(100):
        if not any(os.path.exists(f"/proc/{child}") for child in children):
            return
        time.sleep(0.05)
    pytest.fail("a reader is still there")


def test_the_module_runs_the_program(command):
    """The one in PATH, where the package has none of its own."""
    folder = os.path.dirname(os.environ["PSIVOX_PROGRAM"])
    for path, code in ((folder, 0), ("/nowhere", 1)):
        ran = subprocess.run([sys.executable, "-m", "psivox", "help", "info"], capture_output=True,
                             text=True, env={**os.environ, "PATH": path})
        assert ran.returncode == code, ran.stderr
    assert "has no program" in ran.stderr and ran.stdout == ""
    assert command("help", "info").startswith("Tells")
