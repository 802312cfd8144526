"""One browser for all tests of pages, an empty page for each."""

from collections.abc import Iterator

import pytest
from browser import Page, running_browser


@pytest.fixture(scope="session")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Page]:
    """The browser, which starts once."""
    with running_browser(tmp_path_factory.mktemp("profile")) as started:
        yield started


@pytest.fixture
def page(browser: Page) -> Page:
    """An empty page, as a browser that has just been started would show it."""
    browser.renew(width=1280, height=800)
    return browser
