"""The report: one page that shows a result, in any browser, without a network."""

from neurbs.report.page import write

__all__ = ["write"]
