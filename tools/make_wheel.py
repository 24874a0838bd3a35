#!/usr/bin/env python3
"""Makes a wheel of the bundle: tools/make_wheel.py [ROOT]

Into build/bundle it writes psivox-VERSION-cpPYTHON-cpPYTHON-manylinux_2_36_x86_64.whl: the Python
package of build/release, the program, and the libraries of the folder that tools/make-bundle.sh has
made. It is for this system's Python, or for that of another Debian's root, of which it takes the
headers (python3-dev, pybind11-dev). Needs g++ and patchelf.
"""
import base64
import hashlib
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import tomllib
import zipfile

source = pathlib.Path(__file__).resolve().parent.parent
version = re.search(r"project\(psivox VERSION ([0-9.]+)", (source / "CMakeLists.txt").read_text())[1]
bundle = source / f"build/bundle/psivox-{version}-linux-x86_64"
built = source / "build/release"
root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else "/")
headers = sorted(root.glob("usr/include/python3.[0-9]*"))
for needed, maker in ((bundle, "tools/make-bundle.sh"), (built / "python/psivox/__init__.pyi",
                                                         "cmake --build --preset python")):
    if not needed.exists():
        sys.exit(f"make_wheel.py: no {needed}: {maker} makes it")
if not headers:
    sys.exit(f"make_wheel.py: no headers of Python in {root} (Debian: python3-dev pybind11-dev)")
python = headers[0].name.removeprefix("python").replace(".", "")


def patch(path, up):
    """Lets a file find libraries as the bundle's do; `up` leads to the package's folder."""
    system = "/usr/lib/x86_64-linux-gnu:/usr/lib64:/usr/lib"
    own = f"$ORIGIN/{up}lib"
    subprocess.run(["patchelf", "--set-rpath", f"{own}:{system}:{own}/fallback:{own}/mesa", path],
                   check=True)


def make_core(path):
    """Compiles the module for that Python."""
    with tempfile.TemporaryDirectory() as work:  # Python's headers without that root's C library
        for name in ("pybind11", f"x86_64-linux-gnu/{headers[0].name}"):
            place = pathlib.Path(work, name)
            place.parent.mkdir(exist_ok=True)
            place.symlink_to(root / "usr/include" / name)
        folders = [source / "include", source / "src", source / "shaders", built / "generated",
                   headers[0], work]
        subprocess.run(
            ["g++", "-std=c++20", "-O1", "-DNDEBUG", "-fPIC", "-shared", "-fvisibility=hidden",
             "-ffp-contract=off", "-s", f'-DPSIVOX_VERSION="{version}"',
             *(f"-I{folder}" for folder in folders),
             *(source / "src/python" / name for name in ("core.cpp", "drawing.cpp", "grids.cpp")),
             f"-L{bundle}/lib", "-l:libpsivox.so.0", f"-Wl,-rpath-link,{bundle}/lib", "-o", path],
            check=True)


def write(wheel, package):
    """Writes the package's folder, with what pip reads, as a wheel."""
    tag = f"cp{python}-cp{python}-manylinux_2_36_x86_64"
    project = tomllib.loads((source / "pyproject.toml").read_text())["project"]
    info = f"psivox-{version}.dist-info"
    texts = {
        "METADATA": f"Metadata-Version: 2.1\nName: psivox\nVersion: {version}\n"
                    f"Summary: {project['description']}\nLicense: Apache-2.0\n"
                    f"Requires-Python: {project['requires-python']}\nRequires-Dist: numpy\n"
                    "Description-Content-Type: text/markdown\n\n"
                    + (source / project["readme"]).read_text(),
        "WHEEL": f"Wheel-Version: 1.0\nGenerator: make_wheel.py\nRoot-Is-Purelib: false\nTag: {tag}\n",
        "entry_points.txt": "[console_scripts]\npsivox = psivox.__main__:main\n",
        "LICENSE": (source / "LICENSE").read_text(),
    }
    rows = []
    path = bundle.parent / f"{wheel}-{tag}.whl"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as out:
        def add(name, data, mode=0o644):
            entry = zipfile.ZipInfo(name, (1980, 1, 1, 0, 0, 0))
            entry.external_attr = (0o100000 | mode) << 16
            entry.compress_type = zipfile.ZIP_DEFLATED
            out.writestr(entry, data)
            digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
            rows.append(f"{name},sha256={digest},{len(data)}")

        for file in sorted(package.rglob("*")):
            if file.is_file():
                add(f"psivox/{file.relative_to(package)}", file.read_bytes(),
                    0o755 if file.stat().st_mode & 0o100 else 0o644)
        for name, text in texts.items():
            add(f"{info}/{name}", text.encode())
        out.writestr(f"{info}/RECORD", "\n".join([*rows, f"{info}/RECORD,,"]) + "\n")
    print(path, f"{path.stat().st_size / 1e6:.0f} MB")


with tempfile.TemporaryDirectory() as folder:
    package = pathlib.Path(folder, "psivox")
    shutil.copytree(built / "python/psivox", package,
                    ignore=shutil.ignore_patterns("_core.*", "__pycache__"))
    for part in ("bin", "lib", "licenses"):
        shutil.copytree(bundle / part, package / part)
    core = package / f"_core.cpython-{python}-x86_64-linux-gnu.so"
    make_core(core)
    patch(core, "")
    patch(package / "_readers", "")
    patch(package / "bin/psivox", "../")
    write(f"psivox-{version}", package)
