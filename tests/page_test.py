"""Opens a study's pages in headless Chromium and reads what a user sees: page_test.py FOLDER.

FOLDER holds some of the pages study/, suite/ and frames/. The browser is driven over the WebDriver protocol.
Screenshots stay in FOLDER.
"""

import json
import pathlib
import re
import sys

from browser import SHIFT, Browser

failures = []


def expect(condition, what):
    if not condition:
        failures.append(what)
        print("FAILED:", what)


class Plot:
    """One plot of the open page, scrolled into view."""

    def __init__(self, browser, name):
        self.browser, self.name = browser, name
        self.run("section.scrollIntoView({block: 'center'})")

    def run(self, script, *arguments):
        """Runs with `section`, `box` (the plot's place in the window) and arguments[1], ..."""
        return self.browser.run(
            "const section = document.getElementById(arguments[0]);"
            "const box = section.querySelector('.frame').getBoundingClientRect();" + script,
            self.name, *arguments)

    def points(self):
        """Visible marks: their name, their curve's entries of the legend and their place in the window."""
        return self.run("""
          return [...section.querySelectorAll('.frame .mark')].map(mark => {
            const {left, top, width, height} = mark.getBoundingClientRect();
            return {name: mark.dataset.name, at: [left + width / 2, top + height / 2],
                    entries: mark.closest('g').dataset.entries.split('\\n')};
          })""")

    def point(self, name, entry):
        return next(p for p in self.points() if p["name"] == name and entry in p["entries"])

    def places(self):
        """Where the marks of the curves are, by name."""
        return {p["name"]: p["at"] for p in self.points() if "Pareto front" not in p["entries"]}

    def middle(self):
        return self.run("return [box.left + box.width / 2, box.top + box.height / 2]")

    def legend(self, text):
        """The middle of the legend's button."""
        return self.run("""
          const button = [...section.querySelectorAll('.legend button')].find(b => b.innerText.trim() === arguments[1]);
          button.scrollIntoView({block: 'nearest'});
          const {left, top, width, height} = button.getBoundingClientRect();
          return [left + width / 2, top + height / 2]""", text)

    def press(self, text):
        self.run("[...section.querySelectorAll('header button')].find(b => b.innerText === arguments[1]).click()",
                 text)

    def names(self):
        return set(self.places())


def tip(browser):
    """The tooltip's text and the number of pictures in it that have loaded; None if it is hidden."""
    return browser.run("""
      const tip = document.querySelector('.tip');
      return tip.hidden ? null : {
        text: tip.innerText,
        pictures: [...tip.querySelectorAll('img')].filter(i => i.naturalWidth > 0).length,
        inside: tip.getBoundingClientRect().bottom <= innerHeight && tip.getBoundingClientRect().right <= innerWidth
      }""")


def test_hover(browser, plot, folder):
    results = json.loads((folder / "study/results.json").read_text())
    measured = next(p for p in results["points"] if p["integrator"] == "psi-exact" and p["step"] == 0.5)
    plot.browser.pointer(plot.point("psi-exact step 0.5", "psi-exact")["at"])
    shown = tip(browser)
    browser.screenshot(folder / "hover.png")
    expect(shown is not None, "no tooltip at a mark")
    if shown is None:
        return
    expect(shown["text"].startswith("psi-exact step 0.5\n"), f"the tooltip does not name its variant: {shown['text']}")
    for label, value in [("look-ups per ray", f"{measured['samples_per_ray']:.1f}"),
                         ("RMS", re.sub(r"e-0*", "e-", f"{measured['error']['rms']:.1e}")),
                         ("CPU ms", f"{measured['times_ms'][0]['cpu']:.1f}")]:
        expect(re.search(rf"(?m)^{label}\s+{re.escape(value)}", shown["text"]),
               f"the tooltip lacks {label} {value}: {shown['text']}")
    expect(shown["pictures"] == 2, f"the tooltip shows {shown['pictures']} pictures, expected 2")
    expect(shown["inside"], "the tooltip is cut off")
    browser.pointer((5, 5))
    expect(tip(browser) is None, "the tooltip stays when the pointer leaves")


def test_legend(browser, plot):
    everything = plot.names()
    browser.click(plot.legend("psi-exact"))
    rest = {name for name in everything if not name.startswith("psi-exact ")}
    expect(rest and rest != everything, "the study has too few variants for this test")
    expect(plot.names() == rest, f"psi-exact hidden: {plot.names()}")
    browser.click(plot.legend("cells"))
    expect(plot.names() == {n for n in rest if " step " in n}, f"cells hidden too: {plot.names()}")
    browser.click(plot.legend("cells"))
    browser.click(plot.legend("psi-exact"))
    expect(plot.names() == everything, f"shown again: {plot.names()}")
    browser.double_click(plot.legend("porter-duff"))
    expect(plot.names() == {n for n in everything if n.startswith("porter-duff ")},
           f"porter-duff alone: {plot.names()}")
    plot.press("Show all")
    expect(plot.names() == everything, f"Show all: {plot.names()}")


def spread(places):
    """The extent of the marks across and down the window."""
    return [max(axis) - min(axis) for axis in zip(*places.values())]


def test_zoom(browser, plot):
    whole = plot.places()
    wide = spread(whole)
    x, y = plot.middle()
    browser.drag((x - 60, y - 40), (x + 60, y + 40))
    zoomed = plot.places()
    expect(all(z > 2 * w for z, w in zip(spread(zoomed), wide)), f"drag: {wide} became {spread(zoomed)}")

    browser.keys(("keyDown", SHIFT))
    browser.drag((x, y), (x + 50, y))
    browser.keys(("keyUp", SHIFT))
    moved = plot.places()
    # all marks move with the pointer, which is at whole pixels
    expect(all(abs(moved[name][0] - zoomed[name][0] - 50) < 1 and abs(moved[name][1] - zoomed[name][1]) < 1
               for name in whole), f"Shift+drag: {zoomed} became {moved}")
    plot.press("Reset zoom")
    expect(plot.places() == whole, f"Reset zoom: {plot.places()}, not {whole}")

    browser.wheel((x, y), -200)
    expect(spread(plot.places()) == wide, "the wheel alone zooms instead of scrolling the page")
    x, y = plot.middle()
    plot.run("""section.querySelector('.frame').dispatchEvent(new WheelEvent('wheel', {
      deltaY: -200, ctrlKey: true, clientX: arguments[1], clientY: arguments[2], cancelable: true}))""", x, y)
    zoomed = spread(plot.places())
    # e^(0.002 * 200) in each direction
    expect(all(abs(z / w - 1.4918) < 0.01 for z, w in zip(zoomed, wide)), f"Ctrl+wheel: {wide} became {zoomed}")
    browser.double_click((x, y))
    expect(spread(plot.places()) == wide, f"double click: {spread(plot.places())}, not {wide}")


def test_file(plot):
    """The plot's link holds it as an SVG, legend and all."""
    text = plot.run("""
      const link = section.querySelector('header a');
      link.addEventListener('click', event => event.preventDefault());
      link.click();
      const text = decodeURIComponent(link.href.slice(link.href.indexOf(',') + 1));
      const svg = new DOMParser().parseFromString(text, 'image/svg+xml');
      return [link.download, svg.documentElement.localName, svg.querySelectorAll('.mark').length,
              [...svg.querySelectorAll('text')].map(t => t.textContent).join(' ')]""")
    expect(text[:2] == [f"{plot.name}.svg", "svg"] and text[2] == len(plot.points()), f"the file has {text}")
    expect("psi-exact" in text[3] and "field look-ups per ray" in text[3], f"the file says {text[3]}")


def test_text(browser, folder):
    """What the page says beside its plots."""
    results = json.loads((folder / "study/results.json").read_text())
    text = browser.run("return document.body.innerText")
    sentence = results["conclusion"]["sentence"].replace("`", "")
    expect(browser.run("return document.querySelector('h1 + noscript + main > p').innerText") == sentence,
           "the conclusion is not first")
    exact = next(p for p in results["points"] if p["integrator"] == "cell-exact")
    for part in ["Cheapest ways to an error", "Rules by samplings", "What an error takes", "All numbers",
                 "cell-exact: step 2, step 1, step 0.5", "Porter and Duff 1984", results["input"]["sha256"],
                 results["date"], "peer 2 (foreign)", f"{exact['samples_per_ray']:.1f}", "Cite as: psivox", '"extinction": ']:
        expect(part in text, f"the page lacks {part}")
    links = browser.run("return [...document.querySelectorAll('main a')].map(a => a.getAttribute('href'))")
    expect(all(re.match(r"https://doi\.org/10|results\.(csv|json)$|turning\.html$|#$", link) for link in links),
           f"the page links to {links}")
    # the reference and, of 11 settings and another renderer, picture and difference
    loaded = browser.run("return [...document.querySelectorAll('main img')].filter(i => i.naturalWidth > 0).length")
    expect(loaded == 1 + 2 * len(results["points"] + results["foreign"]), f"{loaded} pictures are shown")
    expect(Plot(browser, "error-cpu").point("peer 2 (foreign)", "peer (foreign, time as given)"),
           "another renderer is not in the plot of times")
    expect(browser.run("return document.querySelectorAll('.command span').length") > 3, "the command has no breaks")


def test_foreign(browser, folder):
    """A name in a foreign results.json is text and runs nothing."""
    evil = "<img src=x onerror=document.title='run'>"
    begin, rest = (folder / "study/index.html").read_text().split('id="data">')
    data, end = rest.split("</script>", 1)
    inside = json.dumps(evil).replace("<", "\\u003c")[1:-1]
    (folder / "study/evil.html").write_text(
        f'{begin}id="data">{data.replace("psi-exact", inside)}</script>{end}')
    browser.open(folder / "study/evil.html")
    expect(evil in browser.run("return document.body.innerText"), "a name is not shown")
    expect(browser.run("return document.title").startswith("psivox study of"), "a name runs")


def test_phone(browser, page):
    """At a phone's width the page scrolls down alone: wide tables scroll by themselves."""
    metrics = {"width": 390, "height": 844, "deviceScaleFactor": 1, "mobile": True}
    browser.call("/goog/cdp/execute", {"cmd": "Emulation.setDeviceMetricsOverride", "params": metrics})
    browser.open(page)
    width = browser.run("return document.documentElement.scrollWidth")
    expect(width <= 390, f"at a width of 390 pixels {page} is {width} wide")
    browser.call("/goog/cdp/execute", {"cmd": "Emulation.clearDeviceMetricsOverride", "params": {}})


def test_study(browser, folder):
    page = folder / "study/index.html"
    browser.open(page)
    plots = browser.run("return [...document.querySelectorAll('.plot')].map(p => p.id)")
    expect(plots[:2] == ["error-step", "error-samples"] and "error-cpu" in plots, f"plots: {plots}")
    test_text(browser, folder)
    plot = Plot(browser, "error-samples")
    test_hover(browser, plot, folder)
    test_legend(browser, plot)
    test_zoom(browser, plot)
    test_file(plot)
    test_phone(browser, page)
    turning = browser.run("return document.querySelector('.first a').href")
    expect(turning == (folder / "study/turning.html").as_uri(), f"the page links to {turning}")
    size = (folder / "study/turning.html").stat().st_size
    expect(size <= 2e6, f"the page that turns has {size} bytes")
    requested = browser.run("return performance.getEntriesByType('resource').map(r => r.name)")
    expect(all(name.startswith("data:") for name in requested), f"the page asks for {requested}")
    complaints = browser.log()
    expect(not complaints, f"the page complains: {complaints}")
    test_foreign(browser, folder)


WORDS = {"suite": ["Orders of convergence", "as expected", "gaussian", "Values that glow"],
         "frames": ["For 8 bits in all", "midpoint step 1", "Frames"],
         "frames/frame.0001": ["scattered once", "times 'temperature'", "camera:0.8"]}


def main(folder):
    with Browser() as browser:
        if (folder / "study").exists():
            test_study(browser, folder)
        for name, words in WORDS.items():
            if not (folder / name).exists():
                continue
            browser.open(folder / name / "index.html")
            text = browser.run("return document.body.innerText")
            for word in words:
                expect(word in text, f"{name}: the page lacks {word}")
            complaints = browser.log()
            expect(not complaints, f"{name}: the page complains: {complaints}")
    print("all passed" if not failures else f"{len(failures)} failed")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main(pathlib.Path(sys.argv[1]).resolve()))
