"""Opens pages that turn in headless Chromium: turning_page_test.py PSIVOX ASSETS FOLDER.

The canvas at rest is compared with the .png of `psivox render`, as it is and turned. The browser draws
with SwiftShader, a driver that shares no code with psivox's.
"""

import base64
import math
import pathlib
import re
import shlex
import subprocess
import sys
import time

from browser import SHIFT, SOFTWARE_GRAPHICS, Browser

SCENES = {
    "smoke": ["rotated.vdb", "--credit", "A & B", "--tolerance", "1e-4"],
    "fire": ["blobs.vdb", "--tolerance", "1e-4"],
    "light": ["blobs.vdb", "--light", "1,-1,-1", "--albedo-grid", "color", "--tolerance", "1e-4"],
    "function": ["rotated.vdb", "--transfer-function", "ASSETS/shells.json", "--background", "black",
                 "--pixel-samples", "2", "--tolerance", "1e-4", "--clip", "0.3,0,-1,3,2.5,1.4"],
    "cells": ["rotated.vdb", "--classification", "nearest", "--light", "1,-1,-1", "--tolerance", "1e-4"],
    "surface": ["rotated.vdb", "--mode", "isosurface", "--isovalue", "0.2", "--projection", "orthographic",
                "--tolerance", "1e-4"],
    "maximum": ["blobs.vdb", "--mode", "mip", "--background", "gray"],
    "slice": ["rotated.vdb", "--mode", "slice", "--slice", "1,1,0.5", "--clip-plane", "0,1,0"],
    "slice of colours": ["blobs.vdb", "--mode", "slice", "--luminance-grid", "color"],
    "volumes": ["slab.vdb", "--and", "ASSETS/ramp.vdb", "--background", "0.1,0.1,0.1", "--texel", "float32"],
}
# Both drivers march by the same formulas in float32. Where the page has its values as codes and the
# picture has them as floats, each keeps the tolerance, 1e-4 in these scenes: 2e-4 are 0.05 codes times the
# slope of sRGB's curve, which is 4.3 at a radiance of 0.02 and falls. What is left are codes that round to
# the other side. A march that is wrong differs by many codes where it is.
BOUND = 0.25  # RMS over R G B [codes of 8 bits]

failures = []


def expect(condition, what):
    if not condition:
        failures.append(what)
        print("FAILED:", what)


def render(program, arguments, output, assets):
    words = [word.replace("ASSETS", str(assets)) for word in arguments]
    subprocess.run([program, "render", assets / words[0], *words[1:], "-o", output, "-q",
                    "--resolution", "64x64"], check=True)


def rest(browser):
    """Waits until the page draws no more; returns its state."""
    for _ in range(6000):  # a machine may be slow
        state = browser.run("return canvas.dataset.state")
        if state in ("rest", "failed"):
            return state
        time.sleep(0.05)
    return "at work for 5 minutes"


def picture(browser):
    return browser.run("return canvas.toDataURL()")


def difference(browser, png):
    """RMS of the canvas and a picture's bytes [codes]."""
    return browser.run("""
      const pixels = source => {
        const copy = document.createElement("canvas");
        [copy.width, copy.height] = scene.size;
        const context = copy.getContext("2d");
        context.drawImage(source, 0, 0);
        return context.getImageData(0, 0, ...scene.size).data;
      };
      return createImageBitmap(new Blob([Uint8Array.from(atob(arguments[0]), c => c.charCodeAt(0))])).then(file => {
        const a = pixels(canvas), b = pixels(file);
        let sum = 0;
        for (let i = 0; i < a.length; ++i) if (i % 4 < 3) sum += (a[i] - b[i]) ** 2;
        return Math.sqrt(sum / (0.75 * a.length));
      })""", base64.b64encode(png).decode())


def middle(browser):
    return browser.run("const b = canvas.getBoundingClientRect(); return [b.left + b.width / 2, b.top + b.height / 2]")


def drag(browser, way):
    x, y = middle(browser)
    browser.drag((x, y), (x + way[0], y + way[1]))
    return rest(browser)


def check_command(browser, program, folder, what):
    """The command line that the page copies draws what it shows."""
    words = shlex.split(browser.run("return command()"))
    expect(words[:2] == ["psivox", "render"], f"{what}: {words}")
    output = folder / "turned.png"
    words = [f"--output={output}" if word.startswith("--output=") else word for word in words]
    subprocess.run([program, *words[1:], "-q"], check=True)
    rms = difference(browser, output.read_bytes())
    expect(rms <= BOUND, f"{what}: {rms:.3f} codes from its command line's picture")
    return rms


def test_scene(browser, program, assets, folder, name):
    page, output = folder / f"{name}.html", folder / f"{name}.png"
    arguments = SCENES[name]
    render(program, arguments, page, assets)
    render(program, [a for a in arguments if a not in ("--credit", "A & B")], output, assets)
    png = output.read_bytes()
    browser.open(page)
    state = rest(browser)
    expect(state == "rest", f"{name}: {state}: {browser.run('return document.body.innerText')}")
    if state != "rest":
        return
    first = picture(browser)
    rms = difference(browser, png)
    expect(rms <= BOUND, f"{name}: {rms:.3f} codes from render's picture")
    drag(browser, (17, 9))
    expect(difference(browser, png) > 2, f"{name}: it does not turn")
    turned = check_command(browser, program, folder, f"{name}, turned")
    drag(browser, (-17, -9))
    expect(picture(browser) == first, f"{name}: turned back, it is another picture")
    expect(not browser.log(), f"{name}: {browser.log()}")
    expect(not browser.run("return performance.getEntriesByType('resource').length"), f"{name}: it loads something")
    print(f"{name}: {page.stat().st_size / 1e6:.2f} MB, {rms:.3f} and {turned:.3f} codes from render's pictures")


def test_controls(browser, program, folder):
    """Of the open page."""
    first = picture(browser)
    for what, act in [("moved", lambda: (browser.keys(("keyDown", SHIFT)), drag(browser, (12, -7)),
                                         browser.keys(("keyUp", SHIFT)))),
                      ("near", lambda: browser.wheel(middle(browser), -250)),
                      ("by keys", lambda: browser.keys(("keyDown", "\ue012"), ("keyUp", "\ue012"), ("keyDown", "+"))),
                      ("brighter", lambda: browser.run("actions.brighter(); actions.ground()")),
                      ("on white", lambda: browser.run("actions.ground(); actions.ground()"))]:
        before = picture(browser)
        act()
        expect(rest(browser) == "rest" and picture(browser) != before, f"{what}: nothing happens")
        check_command(browser, program, folder, what)
    expect(browser.run("return contrast()") < 1, "on white smoke is as bright as on black")
    for again in (True, False):
        browser.keys(("keyDown", "r"), ("keyUp", "r"))
        rest(browser)
        expect(picture(browser) == first, "after a reset it is another picture")
        if again:
            check_double_click(browser)


def check_double_click(browser):
    """The point that a pixel shows comes into the middle."""
    x, y = middle(browser)
    browser.run("const own = pick; pick = pixel => window.picked = own(pixel)")
    expect(browser.run("return pick([0, 0])") is None, "something is beside the volume")
    # a pixel other than the middle one, in a surface without an edge nearby
    at = browser.run("""
      const flat = (x, y) => {
        const points = [[x, y], [x - 1, y - 1], [x + 1, y + 1], [x - 1, y + 1], [x + 1, y - 1]].map(pick);
        return points.every(Boolean) && points.every(p => length(minus(p, points[0])) < 0.2);
      };
      for (let y = 20; y < 44; ++y) for (let x = 20; x < 44; ++x) if (x < 30 && flat(x, y)) return [x, y];""")
    browser.double_click((x + at[0] - 32, y + at[1] - 32))
    rest(browser)
    point, target, eye = browser.run("return [picked, camera().target, camera().position]")
    expect(math.dist(point, target) < 1e-6 * math.dist(point, eye), f"it looks at {target}, not at {point}")
    there = browser.run("return pick([32, 32])")
    expect(there and math.dist(point, there) < 0.2, f"in the middle is {there}, not {point}")


def test_broken(browser, folder, name):
    """A shader that fails shows the picture that the page contains; one that is wrong is found."""
    page = (folder / f"{name}.html").read_text()
    broken = folder / "broken.html"
    broken.write_text(page.replace("void main() {", "void main() { broken", 1))
    browser.open(broken)
    expect(rest(browser) == "failed", "a broken shader does not fail")
    shown = browser.run("const i = element('still'); return [i.hidden, i.naturalWidth, canvas.hidden, "
                        "element('message').textContent]")
    expect(shown[:3] == [False, 64, True] and "does not compile" in shown[3], f"a broken shader shows {shown}")
    browser.log()
    wrong = page.replace("extinction = given.extinction", "extinction = 0.9 * given.extinction", 1)
    expect(wrong != page, "the page has no extinction")
    broken.write_text(wrong)
    browser.open(broken)
    rest(browser)
    rms = difference(browser, (folder / f"{name}.png").read_bytes())
    expect(rms > BOUND, f"an extinction of 0.9 differs by {rms:.3f} codes only")


def test_no_graphics(folder, name):
    with Browser(["--disable-3d-apis"]) as browser:
        browser.open(folder / f"{name}.html")
        state = rest(browser)
        shown = browser.run("return [element('still').hidden, element('message').textContent]")
        expect(state == "failed" and not shown[0] and "WebGL 2" in shown[1], f"without WebGL: {state}, {shown}")


def test_codes(program, assets, folder):
    """Where the device has codes, the page has these alone. They have half of the bits of float32 or less,
    and what corners do not tell of each other is mostly 0: deflated they have less than half of float32's bytes."""
    def elements(name, *options):
        page = folder / f"{name}.html"
        render(program, ["rotated.vdb", *options], page, assets)
        found = re.findall(r'id="density_(codes|texels)-\d">([^<]*)', page.read_text())
        return {kind for kind, _ in found}, sum(len(text) for _, text in found)
    (coded, small), (plain, large) = elements("coded"), elements("plain", "--texel", "float32")
    expect(coded == {"codes"} and plain == {"texels"}, f"the pages have {coded} and {plain}")
    expect(2 * small < large, f"codes take {small} bytes, values {large}")


def test_docs(browser, program, root, folder):
    """Each page of the docs shows at rest the picture that it contains."""
    subprocess.run([sys.executable, root / "tools/docs_pages.py", program, folder], check=True)
    for page in folder.iterdir():
        browser.open(page)
        state = rest(browser)
        png = base64.b64decode(re.search(r"data:image/png;base64,([^\"]*)", page.read_text())[1])
        rms = difference(browser, png) if state == "rest" else math.inf
        expect(rms <= BOUND, f"{page.name}: {state}, {rms:.3f} codes from its picture")


def main(program, assets, folder):
    test_codes(program, assets, folder)
    with Browser(SOFTWARE_GRAPHICS) as browser:
        for name in SCENES:
            test_scene(browser, program, assets, folder, name)
            if name == "smoke":
                text = browser.run("return document.body.innerText")
                for part in ("rotated.vdb", "estimated error RMS", "A & B"):
                    expect(part in text, f"the page does not say {part}")
                test_controls(browser, program, folder)
                test_broken(browser, folder, name)
        test_docs(browser, program, assets.parent, folder / "docs")
    test_no_graphics(folder, "smoke")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], pathlib.Path(sys.argv[2]).resolve(), pathlib.Path(sys.argv[3]).resolve()))
