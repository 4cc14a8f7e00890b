"""`python -m neurbs` is the command `neurbs`."""

from neurbs.cli import main

main()
