"""What all tests share: the path, one thread of linear algebra, the same examples of properties every time."""

import os
import sys
from pathlib import Path

from hypothesis import settings

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE), str(HERE.parent)]  # the catalogue of axes, and the benchmarks, are not installed

# Matrices are small: threads would wait for each other, and take the cores from the other workers. Read by numpy.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

settings.register_profile(
    "same examples every time", derandomize=True, deadline=None, database=None, max_examples=50
)
settings.load_profile("same examples every time")
