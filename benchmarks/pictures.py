"""Pictures of pages for the README, photographed in Chromium.

The page is the diagnosis of EMPS with a model without Coulomb friction and offset; its gap is measured on the log with
pulses (the case emps-viscous of `benchmarks.diagnosis.real`).

Usage: python -m benchmarks.pictures writes docs/pictures/diagnosis_page.png
"""

import shutil
import subprocess
import tempfile
from pathlib import Path

from symid.report.pages.diagnosis_page import write_diagnosis_html

from .diagnosis.real.rigs import emps

FOLDER = Path(__file__).parents[1] / "docs" / "pictures"
CASE = "emps-viscous"
WIDTH, HEIGHT = 1120, 1360
"""In pixels: from the verdict to the places of the gap."""
_BROWSERS = ("chromium", "chromium-browser", "google-chrome", "chrome")


def photograph(page: Path, picture: Path, width: int, height: int) -> None:
    """Write the top of a page as PNG, in light colours.

    Raises
    ------
    SystemExit
        If there is no browser.
    """
    browser = next(filter(None, map(shutil.which, _BROWSERS)), None)
    if browser is None:
        raise SystemExit("pictures of pages need a browser: install Chromium (apt-get install chromium)")
    with tempfile.TemporaryDirectory() as profile:
        flags = ("--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", "--no-first-run")
        settings = (
            f"--user-data-dir={profile}",
            f"--window-size={width},{height}",
            f"--screenshot={picture}",
        )
        command = [
            browser,
            *flags,
            *settings,
            "--blink-settings=preferredColorScheme=1",
            page.resolve().as_uri(),
        ]
        subprocess.run(command, check=True, capture_output=True)


def main() -> None:
    case = next(case for case in emps() if case.name == CASE)
    with tempfile.TemporaryDirectory() as folder:
        page = Path(folder) / "diagnosis.html"
        write_diagnosis_html(case.found(), page)
        picture = FOLDER / "diagnosis_page.png"
        photograph(page, picture, WIDTH, HEIGHT)
    print(f"{picture.name}: {picture.stat().st_size / 1000:.0f} kB")


if __name__ == "__main__":
    main()
