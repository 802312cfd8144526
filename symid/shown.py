"""Results that show themselves: as a line, as text, in a notebook, as a figure, as a page."""

from __future__ import annotations

from abc import ABC, abstractmethod
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from symid.text import visible

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class Shown(ABC):
    """Result that can be displayed.

    `symid.report.views` defines how each kind looks. It is imported when a result is shown, so that computing does not
    load the drawing libraries.

    >>> from symid import load_axis
    >>> load_axis("rigid_1m")
    <Axis rigid_1m: motor moved by F, measured by q, parameters M, Fv, Fs>
    """

    @property
    @abstractmethod
    def headline(self) -> str:
        """One line that summarises the result."""

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {visible(self.headline)}>"

    def _repr_html_(self) -> str:
        """HTML that notebooks show."""
        return str(_views().as_html(self))

    def summary(self) -> str:
        """The text that the command line prints.

        >>> from symid import derive
        >>> print(derive("rigid_1m").summary().splitlines()[3])
            F = Fs*sign(q_motor_d1) + Fv*q_motor_d1 + M*q_motor_d2
        """
        return str(_views().as_text(self))

    def plot(self, **settings: Any) -> Figure:
        """A figure of it, which a notebook shows and ``savefig`` writes.

        Parameters
        ----------
        **settings
            ``palette``: ``LIGHT`` or ``DARK`` of `symid.report.figures.colours`. Of an identification also ``axis`` and
            ``runs``, its declaration and its logs, for the residual over the motion and the frequency response, where
            it was made from a generated model and does not keep them.

        Raises
        ------
        SettingError
            If there is nothing to draw, or nothing is known of a setting.
        """
        figure: Figure = _views().figure(self, **settings)
        return figure

    def report(self, path: str | Path) -> Path:
        """Write a self-contained page, and return its path.

        Parameters
        ----------
        path : path-like
            Ends with .html.

        Raises
        ------
        SettingError
            If the suffix is another one, or the folder does not exist.
        """
        written: Path = _views().write_page(self, path)
        return written


def _views() -> Any:
    return import_module("symid.report.views")
