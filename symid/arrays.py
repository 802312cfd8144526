"""Array types of the numeric packages."""

from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]
"""Array of 64 bit floating point numbers of any shape."""

BoolArray = npt.NDArray[np.bool_]
"""Array of truth values of any shape."""

IntArray = npt.NDArray[np.intp]
"""Array of indices of any shape."""

ComplexArray = npt.NDArray[np.complex128]
"""Array of complex numbers of any shape."""

Values = TypeVar("Values", bound=npt.NDArray[Any])


def read_only(values: Values) -> Values:
    """View of an array that cannot be written to.

    Examples
    --------
    >>> read_only(np.zeros(2)).flags.writeable
    False
    """
    view = values.view()
    view.flags.writeable = False
    return view
