"""Diagnoses of real logs with incomplete models, and published facts about these machines.

`recordings` reads the files with numpy and scipy, `machines` declares the cases, `plain` fits each of them by a short
script without code of symid, `judge` decides which answers are right or absurd, `table` prints.
"""
