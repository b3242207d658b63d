"""Joint maps: drawings, traces and outlines of files of many kinds become geometry decks (doc/drawings.md)."""
