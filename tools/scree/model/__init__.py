"""Models by words: `scree.Model` writes and reads decks (doc/model.md)."""
from .model import Model
from .shapes import arc

__all__ = ["Model", "arc"]
