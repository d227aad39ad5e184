"""A real browser for tests of pages: Chromium without a window, driven by its driver.

    with Browser(width=1440, dark=False) as page:
        page.open("report.html")
        page.screenshot("report.png")
        assert page.complaints() == []
"""

import base64
import pathlib
import shutil

from selenium import webdriver
from selenium.webdriver.chrome.service import Service
from selenium.webdriver.support.ui import WebDriverWait


def missing():
    """What stands in the way of a browser, or None."""
    for program in ("chromium", "chromedriver"):
        if shutil.which(program) is None:
            return f"{program} is not installed"
    return None


class Browser:
    """`driver` is selenium's own, for whatever has no name here. Nothing moves of its own accord, unless
    motion is asked for."""

    def __init__(self, width=1440, height=900, dark=False, webgl=True, motion=False):
        options = webdriver.ChromeOptions()
        options.binary_location = shutil.which("chromium")
        # Charts are drawn as by a browser without a graphics card: WebGL in software would draw them too, slowly.
        for argument in ("--headless=new", "--no-sandbox", "--disable-dev-shm-usage", "--hide-scrollbars",
                         "--disable-accelerated-2d-canvas",
                         f"--window-size={width},{height}", "--force-device-scale-factor=1"):
            options.add_argument(argument)
        if webgl:
            options.add_argument("--use-angle=swiftshader")
            options.add_argument("--enable-unsafe-swiftshader")
        else:
            options.add_argument("--disable-3d-apis")
        options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
        self.driver = webdriver.Chrome(service=Service(shutil.which("chromedriver")), options=options)
        self.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {
            "width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 600})
        self.driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {
            "features": [{"name": "prefers-color-scheme", "value": "dark" if dark else "light"},
                         {"name": "prefers-reduced-motion", "value": "no-preference" if motion else "reduce"}]})

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.driver.quit()

    def open(self, address):
        """A file or an address, until all of its charts are there."""
        if "://" not in str(address):
            address = pathlib.Path(address).resolve().as_uri()
        self.driver.get(address)
        self.wait("document.documentElement.dataset.ready === 'yes'")

    def wait(self, condition, seconds=20):
        """Until a condition in JavaScript holds."""
        WebDriverWait(self.driver, seconds, poll_frequency=0.02).until(
            lambda driver: driver.execute_script(f"return {condition}"))

    def run(self, script, *arguments):
        """What a script in the page returns."""
        return self.driver.execute_script(script, *arguments)

    def complaints(self):
        """What the page has written to the console since the last call, warnings and errors."""
        return [entry["message"] for entry in self.driver.get_log("browser")
                if entry["level"] in ("WARNING", "SEVERE")]

    def screenshot(self, file, whole=True):
        """The page as a picture, the whole of it or what the window shows."""
        picture = self.driver.execute_cdp_cmd("Page.captureScreenshot", {
            "format": "png", "captureBeyondViewport": whole})
        pathlib.Path(file).write_bytes(base64.b64decode(picture["data"]))

    def webp(self, width):
        """The bytes of the page in its whole length as a small picture."""
        height = self.run("return Math.ceil(document.body.getBoundingClientRect().bottom)")
        picture = self.driver.execute_cdp_cmd("Page.captureScreenshot", {
            "format": "webp", "quality": 60, "captureBeyondViewport": True,
            "clip": {"x": 0, "y": 0, "width": width, "height": height, "scale": 1}})
        return base64.b64decode(picture["data"])

    def pdf(self, file):
        """The page on A4 paper."""
        printed = self.driver.execute_cdp_cmd("Page.printToPDF", {
            "paperWidth": 8.27, "paperHeight": 11.69, "preferCSSPageSize": True, "printBackground": True})
        pathlib.Path(file).write_bytes(base64.b64decode(printed["data"]))
