"""The report of a reconstruction: an HTML page that needs no network."""

from neurbs.report.page import write, write_page

__all__ = ["write", "write_page"]


def __dir__() -> list[str]:
    """Return the public names, without the modules behind them."""
    return sorted({*__all__, "__doc__", "__file__", "__name__", "__path__", "__spec__"})
