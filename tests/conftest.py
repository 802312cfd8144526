"""What all tests share: the catalogue of axes on the path, and properties that draw the same examples every time."""

import sys
from pathlib import Path

from hypothesis import settings

sys.path.insert(0, str(Path(__file__).parent))

settings.register_profile(
    "same examples every time", derandomize=True, deadline=None, database=None, max_examples=50
)
settings.load_profile("same examples every time")
