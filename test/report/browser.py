"""Debian's chromium without a window, and what of a page it says to be wrong."""

import os
import shutil

from selenium import webdriver
from selenium.webdriver.chrome.service import Service

PROGRAMS = "chromium", "chromedriver"

# What does not fit: elements beyond the page, text beyond its figure, boxes that hide a part of what they hold. Figures: those in
# which nothing is drawn.
LOOK = """
const width = document.documentElement.clientWidth, wrong = [], name = e => e.tagName + "." + (e.className.baseVal ?? e.className);
if (document.documentElement.scrollWidth > width) wrong.push(`page ${document.documentElement.scrollWidth} px wide on ${width}`);
for (const e of document.querySelectorAll("body *")) {
  if (e.closest(".js-plotly-plot, #js-plotly-tester, script, style")) continue;
  const r = e.getBoundingClientRect();
  if (r.width && (r.right > width + 1 || r.left < -1)) wrong.push(`${name(e)} from ${r.left} to ${r.right}: ${e.textContent.slice(0, 40)}`);
  if (!e.matches(".tall") && (e.scrollWidth > e.clientWidth + 1 && getComputedStyle(e).overflowX != "visible"))
    wrong.push(`${name(e)} hides text: ${e.textContent.slice(0, 40)}`);
}
const figures = [...document.querySelectorAll(".plotly-graph-div")];
for (const f of figures) {
  const title = f.closest("section")?.querySelector("h2")?.textContent ?? "?", box = f.getBoundingClientRect();
  const marks = [...f.querySelectorAll(".trace path, .trace .point, .hm image, .points path, .gl-container canvas")].filter(e => e.getBoundingClientRect().width > 0);
  if (!f.matches(".js-plotly-plot") || marks.length == 0) wrong.push(`figure "${title}" is empty`);
  for (const t of f.querySelectorAll(".main-svg text")) {
    const r = t.getBoundingClientRect();
    if (r.width && (r.left < box.left - 1 || r.right > box.right + 1 || r.top < box.top - 1 || r.bottom > box.bottom + 1))
      wrong.push(`figure "${title}" cuts "${t.textContent}": ${[r.left - box.left, box.right - r.right, r.top - box.top, box.bottom - r.bottom].map(Math.round)}`);
  }
}
return [figures.map(f => f.closest("section")?.querySelector("h2")?.textContent), wrong];
"""


# Plotly follows the window a tenth of a second later.
FOLLOWED = """
const done = arguments[0], narrower = f => Math.abs(f.querySelector(".main-svg").getBoundingClientRect().width - f.clientWidth) > 1;
(function look() { [...document.querySelectorAll(".js-plotly-plot")].some(narrower) ? setTimeout(look, 20) : done(); })();
"""


def missing():
    return [program for program in PROGRAMS if not shutil.which(program)]


class Browser:
    def __enter__(self):
        options = webdriver.ChromeOptions()
        options.binary_location = shutil.which("chromium")
        for argument in ("--headless=new", "--disable-gpu", "--hide-scrollbars", "--disable-dev-shm-usage", *(["--no-sandbox"] if os.geteuid() == 0 else [])):
            options.add_argument(argument)
        options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
        self.driver = webdriver.Chrome(options=options, service=Service(shutil.which("chromedriver")))
        self.driver.set_script_timeout(30)
        return self

    def __exit__(self, *_):
        self.driver.quit()

    def resize(self, width):
        self.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": width < 600})

    def open(self, file, width):
        self.resize(width)
        self.driver.get(file.as_uri())
        self.settle()

    def at_widths(self, file, widths):
        """Opens the page at the first width, then makes the window as wide as each: figures follow, at half the time of opening it again."""
        self.open(file, widths[0])
        for width in widths:
            self.resize(width)
            self.driver.execute_async_script(FOLLOWED)
            self.settle()
            yield width

    def settle(self):
        """Two frames after what has been asked for: drawn."""
        self.driver.execute_async_script("const done = arguments[0]; requestAnimationFrame(() => requestAnimationFrame(() => done()));")

    def look(self):
        """(titles of the sections of all figures, what is wrong)."""
        return self.driver.execute_script(LOOK)

    def print_preview(self, width):
        """The page as it goes to paper of that width."""
        self.driver.execute_script("dispatchEvent(new Event('beforeprint'))")
        self.driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "print"})
        self.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {"width": width, "height": 1000, "deviceScaleFactor": 1, "mobile": False})
        self.settle()

    def on_screen(self):
        self.driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": ""})
        self.driver.execute_script("dispatchEvent(new Event('afterprint'))")

    def errors(self):
        """Errors on the console since the last call; warnings of the software renderer are not the page's."""
        return [entry["message"] for entry in self.driver.get_log("browser") if entry["level"] == "SEVERE"]
