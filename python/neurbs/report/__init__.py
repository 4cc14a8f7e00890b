"""The report of a reconstruction: an HTML page that needs no network."""

from neurbs.report.page import write, write_page

__all__ = ["write", "write_page"]
