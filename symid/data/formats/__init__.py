"""Files as tables of named columns: one module for each kind of format, which lists its suffixes in `READERS`."""

from symid.data.formats.registry import FOLDER_SUFFIXES, SUFFIXES, layout_found, open_table, suffix_of

__all__ = ["FOLDER_SUFFIXES", "SUFFIXES", "layout_found", "open_table", "suffix_of"]
