"""Diagnoses of real logs by models that lack something, beside what is published of these machines.

`recordings` reads the files with numpy and scipy, `machines` declares the cases, `plain` fits each of them by a short
script that shares nothing with symid, `judge` says which answers are right or absurd, `table` prints.
"""
