"""Scenes that programs for many blocks in contact find hard, and what must be true of any run of them."""
