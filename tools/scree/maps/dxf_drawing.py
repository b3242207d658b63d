"""A DXF drawing: the shapes that each visible layer holds, with INSERTs exploded, in the plane of a deck."""
import logging

import ezdxf

from .dxf_shapes import matrix_rows, shapes_of
from .joint_map import JointMap
from .layers import shown
from .shapes import MapError


def attribute(entity, name, code, default):
    """An attribute that every entity has, of those too that ezdxf does not know and only keeps."""
    if hasattr(entity, "xtags"):
        return next((tag.value for tags in entity.xtags.subclasses[:2] for tag in tags if tag.code == code), default)
    return entity.dxf.get(name, default) if entity.dxf.is_supported(name) else default


class Drawing(JointMap):
    """The model space of a DXF file: what each visible layer holds."""

    def __init__(self, path, view):
        super().__init__(path, view)
        logging.disable()  # ezdxf's; what matters of it is said here
        try:
            self.document = ezdxf.readfile(path)
            space = self.document.modelspace()
        except Exception as error:  # a damaged file fails anywhere in ezdxf
            reason = error.strerror if isinstance(error, OSError) and error.strerror else str(error) or type(error).__name__
            raise MapError(f"{path}: expected a DXF file, found: {shown(reason)}") from None
        self.names = {layer.dxf.name.lower(): layer.dxf.name for layer in self.document.layers}
        for layer, kind, shapes in self.walk(space):
            self.held[layer].append((kind, shapes if isinstance(shapes, str) else
                                     [view.of(shape) for shape in shapes]))
        self.on_paper = sum(entity.dxftype() != "VIEWPORT" for layout in self.document.layouts
                            if layout.is_any_paperspace for entity in layout)

    def why_hidden(self, layer):
        """Whether a layer is frozen or off."""
        entry = self.document.layers.get(layer) if layer in self.document.layers else None
        return "" if entry is None else "frozen" if entry.is_frozen() else "off" if entry.is_off() else ""

    def walk(self, entities, outer=None, blocks=()):
        """Layer, kind and shapes (or why there are none) of each visible entity. Layer 0 in a block is that of its INSERT."""
        for entity in entities:
            name, kind = attribute(entity, "layer", 8, "0"), entity.dxftype()
            layer = name.lower() if name != "0" or outer is None else outer
            self.names.setdefault(layer, name)
            why = self.why_hidden(layer)
            if attribute(entity, "invisible", 60, 0):
                self.hidden[layer, "invisible"] += 1
            elif why == "frozen" or why and kind != "INSERT":  # a block whose INSERT is off shows what lies on other layers
                self.hidden[layer, why] += 1
            elif kind == "INSERT":
                yield from self.explode(entity, layer, blocks)
            else:
                yield layer, kind, shapes_of(entity)

    def explode(self, insert, layer, blocks):
        """What walk says, of an INSERT."""
        name = insert.dxf.get("name", "")
        block = insert.block() if name else None
        yield from self.walk(insert.attribs, layer, blocks)
        if block is None or block.block.is_xref:
            yield layer, "INSERT", f"INSERT of the {'missing' if block is None else 'external'} block '{shown(name)}'"
            return
        if name.lower() in blocks:
            raise MapError(f"{self.path}: expected blocks that end, found '{shown(name)}' within itself")
        for one in insert.multi_insert() if insert.mcount > 1 else [insert]:
            matrix = matrix_rows(one.matrix44())
            for inner, kind, shapes in self.walk(block, layer, (*blocks, name.lower())):
                yield inner, kind, shapes if isinstance(shapes, str) else [shape.moved(matrix) for shape in shapes]
