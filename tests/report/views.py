"""Opens a view of the report and waits until it is complete."""

import time

from .chromium import TIMEOUT, Chromium


def open_view(browser: Chromium, address: str, route: str = "") -> None:
    """Load the page anew at a route such as `#/trials?sort=seed`."""
    browser.open(address + route)
    wait_for(browser, "document.documentElement?.dataset.route === location.hash")


def wait_for(browser: Chromium, condition: str) -> None:
    """Wait until a JavaScript expression is true."""
    deadline = time.monotonic() + TIMEOUT
    while not browser.run(condition):
        if time.monotonic() > deadline:
            raise TimeoutError(f"{condition}: not within {TIMEOUT} s; errors: {browser.errors}")
        time.sleep(0.02)
