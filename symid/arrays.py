"""Array types that all rooms of the numeric half share."""

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]
"""Array of 64 bit floating point numbers of any shape."""

BoolArray = npt.NDArray[np.bool_]
"""Array of truth values of any shape."""

ComplexArray = npt.NDArray[np.complex128]
"""Array of complex numbers of any shape."""
