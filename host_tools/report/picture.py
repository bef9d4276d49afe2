"""A picture of the report of a replay, as in README.md: what came out, the calibration, the path.

    cmake --workflow --preset demo
    .venv/bin/python host_tools/report/picture.py build/host/demo/euroc_mh01_out/report.html docs/report.png

Needs chromium, chromium-driver and selenium, which host_tools/setup.sh installs."""

import io
import os
import shutil
import sys
from pathlib import Path

from PIL import Image
from selenium import webdriver
from selenium.webdriver.chrome.service import Service

SHOWN = ["Calibration", "Path, seen from above", "Residuals over the image"]  # the first on the left
WIDTH = 1200  # px
COLORS = 128  # a page has few; a third of the size
ARRANGE = """
const [shown] = arguments, box = document.createElement("div");
box.style.cssText = "display: grid; grid-template-columns: 46% 52%; column-gap: 2%; align-items: start";
const of = title => [...document.querySelectorAll("section")].find(s => s.querySelector("h2")?.textContent == title);
const [first, ...others] = shown.map(of), right = document.createElement("div");
document.body.style.maxWidth = "none";
first.querySelectorAll(".note").forEach(n => n.remove());
right.append(...others); box.append(first, right);
document.querySelectorAll("body > *").forEach(e => e.matches("h1, .headline, script, style") || e.remove());
document.querySelectorAll(".headline ul").forEach(e => e.remove());
document.body.append(box);
document.querySelectorAll("table").forEach(t => { t.style.fontSize = "13px"; });
document.querySelectorAll("h2").forEach(t => { t.style.marginTop = "0.8rem"; });
document.querySelectorAll("th, td").forEach(c => { c.style.paddingTop = c.style.paddingBottom = "1px"; });
document.querySelectorAll(".modebar-container").forEach(m => m.remove());
box.querySelectorAll(".js-plotly-plot").forEach(f => {
  f.style.height = f.parentElement.style.height = "320px";
  Plotly.relayout(f, {autosize: false, width: right.clientWidth, height: 320, "margin.t": 70});
});
right.querySelectorAll(".note").forEach(n => n.remove());
"""


def main(report, out):
    options = webdriver.ChromeOptions()
    options.binary_location = shutil.which("chromium")
    for argument in ("--headless=new", "--disable-gpu", "--hide-scrollbars", "--disable-dev-shm-usage", *(["--no-sandbox"] if os.geteuid() == 0 else [])):
        options.add_argument(argument)
    driver = webdriver.Chrome(options=options, service=Service(shutil.which("chromedriver")))
    try:
        view = {"width": WIDTH, "height": 900, "deviceScaleFactor": 1, "mobile": False}
        driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", view)
        driver.get(Path(report).resolve().as_uri())
        driver.execute_script(ARRANGE, SHOWN)
        driver.execute_async_script("setTimeout(arguments[0], 500)")  # Plotly follows the new width
        view["height"] = driver.execute_script("return Math.ceil(document.body.getBoundingClientRect().bottom)")
        driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", view)
        driver.execute_async_script("setTimeout(arguments[0], 500)")
        with Image.open(io.BytesIO(driver.get_screenshot_as_png())) as picture:
            picture.convert("RGB").quantize(COLORS).save(out, optimize=True)
    finally:
        driver.quit()


if __name__ == "__main__":
    main(*sys.argv[1:])
