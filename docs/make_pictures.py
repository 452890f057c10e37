"""Makes the pictures of the page: healthy.png and broken.png beside this file.

.venv/bin/python -m docs.make_pictures [--chromium /usr/bin/chromium]
"""

import argparse
from pathlib import Path

from playwright.sync_api import ViewportSize, sync_playwright

from network.control import SetFault
from tests.browser.browser_run import BrowserRun
from tests.browser.conftest import FLAGS
from tests.browser.driven import Driven

HERE = Path(__file__).parent
SIZE = ViewportSize(width=1680, height=980)


def dismiss_notices(driven: Driven) -> None:
    """Close what covers the picture."""
    driven.page.evaluate("document.querySelectorAll('.mantine-Notification-closeButton').forEach(b => b.click())")


def main() -> None:
    """Run a triangle, take a picture, set faults, take another."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--chromium", default="/usr/bin/chromium")
    options = parser.parse_args()
    with BrowserRun("triangle-circle", robots=3) as run, sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=options.chromium, args=FLAGS)
        driven = Driven(browser, run.url)
        driven.page.set_viewport_size(SIZE)
        driven.open(run.url)
        dismiss_notices(driven)
        driven.wait_text(r"t = [12]\d\.", 60.0)
        driven.press("Follow")
        driven.page.wait_for_timeout(4000)
        driven.page.screenshot(path=HERE / "healthy.png")
        run.ask(SetFault(link="1->2", changes={"latency": 0.4, "loss": 0.3}))
        run.ask(SetFault(link="2->3", changes={"cut": True}))
        driven.page.wait_for_timeout(9000)
        dismiss_notices(driven)
        driven.page.wait_for_timeout(1000)
        driven.page.screenshot(path=HERE / "broken.png")
        browser.close()


if __name__ == "__main__":
    main()
