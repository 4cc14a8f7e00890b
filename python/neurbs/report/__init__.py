"""The report: one page that shows a result, in any browser, without a network."""

from neurbs.report.page import write, write_page

__all__ = ["write", "write_page"]
