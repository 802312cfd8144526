"""`python -m symid`: the command line, where no script of it is on the path."""

from symid.cli import main

main()
