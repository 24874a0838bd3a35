"""Opens a study's pages in headless Chromium and reads what a user sees: page_test.py FOLDER.

FOLDER holds the page study/. The browser is driven over the WebDriver protocol.
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
        """Runs with `section`, `chart` (Chart.js's own object) and arguments[1], ..."""
        return self.browser.run(
            "const section = document.getElementById(arguments[0]);"
            "const chart = Chart.getChart(section.querySelector('canvas'));" + script, self.name, *arguments)

    def points(self):
        """Visible points: their name, their curve's entries of the legend and their place in the window."""
        return self.run("""
          const box = chart.canvas.getBoundingClientRect();
          return chart.getSortedVisibleDatasetMetas().flatMap(meta => meta.data.map((mark, i) => {
            const dataset = chart.data.datasets[meta.index];
            return {...dataset.data[i], entries: dataset.entries, at: [box.left + mark.x, box.top + mark.y]};
          }))""")

    def point(self, name, entry):
        return next(p for p in self.points() if p["name"] == name and entry in p["entries"])

    def axes(self):
        return self.run("return ['x', 'y'].map(axis => [chart.scales[axis].min, chart.scales[axis].max])")

    def middle(self):
        return self.run("""
          const box = chart.canvas.getBoundingClientRect(), area = chart.chartArea;
          return [box.left + (area.left + area.right) / 2, box.top + (area.top + area.bottom) / 2]""")

    def legend(self, text):
        """The middle of the legend's button."""
        return self.run("""
          const button = [...section.querySelectorAll('.legend button')].find(b => b.innerText.trim() === arguments[1]);
          button.scrollIntoView({block: 'nearest'});
          const box = button.getBoundingClientRect();
          return [box.left + box.width / 2, box.top + box.height / 2]""", text)

    def names(self):
        return {p["name"] for p in self.points() if "Pareto front" not in p["entries"]}


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
    plot.run("[...section.querySelectorAll('header button')].find(b => b.innerText === 'Show all').click()")
    expect(plot.names() == everything, f"Show all: {plot.names()}")


def test_zoom(browser, plot):
    whole = plot.axes()
    x, y = plot.middle()
    browser.drag((x - 60, y - 40), (x + 60, y + 40))
    zoomed = plot.axes()
    expect(all(w[0] < z[0] < z[1] < w[1] for w, z in zip(whole, zoomed)), f"drag: {whole} became {zoomed}")

    browser.keys(("keyDown", SHIFT))
    browser.drag((x, y), (x + 50, y))
    browser.keys(("keyUp", SHIFT))
    moved = plot.axes()
    expect(moved[0][0] < zoomed[0][0] and moved[0][1] < zoomed[0][1], f"Shift+drag: {zoomed} became {moved}")
    # The axes are logarithmic: a shift keeps the ratio of the ends. Pixels of the drag are whole
    # numbers, and so only rounding is left.
    expect(abs(moved[0][1] / moved[0][0] / (zoomed[0][1] / zoomed[0][0]) - 1) < 1e-9, "Shift+drag changes the scale")

    plot.run("[...section.querySelectorAll('header button')].find(b => b.innerText === 'Reset zoom').click()")
    expect(plot.axes() == whole, f"Reset zoom: {plot.axes()}, not {whole}")

    browser.wheel((x, y), -200)
    expect(plot.axes() == whole, "the wheel alone zooms instead of scrolling the page")
    x, y = plot.middle()
    plot.run("""chart.canvas.dispatchEvent(new WheelEvent('wheel', {
      deltaY: -200, ctrlKey: true, clientX: arguments[1], clientY: arguments[2], cancelable: true}))""", x, y)
    expect(all(w[0] < z[0] < z[1] < w[1] for w, z in zip(whole, plot.axes())), f"Ctrl+wheel: {plot.axes()}")
    browser.double_click((x, y))
    expect(plot.axes() == whole, f"double click: {plot.axes()}, not {whole}")


def test_phone(browser, page):
    """At a phone's width the page scrolls down alone: wide tables scroll by themselves."""
    metrics = {"width": 390, "height": 844, "deviceScaleFactor": 1, "mobile": True}
    browser.call("/goog/cdp/execute", {"cmd": "Emulation.setDeviceMetricsOverride", "params": metrics})
    browser.open(page)
    width = browser.run("return document.documentElement.scrollWidth")
    expect(width <= 390, f"at a width of 390 pixels {page} is {width} wide")
    browser.call("/goog/cdp/execute", {"cmd": "Emulation.clearDeviceMetricsOverride", "params": {}})


def main(folder):
    with Browser() as browser:
        page = folder / "study/index.html"
        browser.open(page)
        plots = browser.run("return [...document.querySelectorAll('.plot')].map(p => p.id)")
        expect(plots[:2] == ["error-step", "error-samples"] and "error-cpu" in plots, f"plots: {plots}")
        expect(browser.run("return document.querySelectorAll('.plot canvas').length") == len(plots),
               "a plot has no chart")
        plot = Plot(browser, "error-samples")
        test_hover(browser, plot, folder)
        test_legend(browser, plot)
        test_zoom(browser, plot)
        test_phone(browser, page)
        turning = browser.run("return document.querySelector('.first a').href")
        expect(turning == (folder / "study/turning.html").as_uri(), f"the page links to {turning}")
        size = (folder / "study/turning.html").stat().st_size
        expect(size <= 2e6, f"the page that turns has {size} bytes")
        requested = browser.run("return performance.getEntriesByType('resource').map(r => r.name)")
        expect(all(name.startswith("data:") for name in requested), f"the page asks for {requested}")
        expect(not browser.log(), f"the page complains: {browser.log()}")
    print("all passed" if not failures else f"{len(failures)} failed")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main(pathlib.Path(sys.argv[1]).resolve()))
