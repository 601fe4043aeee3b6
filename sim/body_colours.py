"""The colours of road users, as often as they are seen: white, black and grey cars before all others."""

import numpy as np

from sim.body_pieces import Material
from sim.lights import Rgb

Palette = tuple[tuple[float, Rgb], ...]  # weights and colours

_CARS: Palette = (
    (30, (0.88, 0.88, 0.87)),
    (18, (0.07, 0.07, 0.08)),
    (14, (0.30, 0.31, 0.33)),
    (13, (0.60, 0.61, 0.63)),
    (7, (0.12, 0.20, 0.42)),
    (5, (0.50, 0.07, 0.08)),
    (3, (0.72, 0.10, 0.09)),
    (3, (0.22, 0.40, 0.60)),
    (2, (0.42, 0.33, 0.24)),
    (2, (0.14, 0.30, 0.20)),
    (1, (0.86, 0.62, 0.10)),
    (1, (0.80, 0.36, 0.10)),
    (1, (0.68, 0.74, 0.60)),
)
_WORK: Palette = (
    (40, (0.87, 0.87, 0.85)),
    (12, (0.20, 0.35, 0.62)),
    (10, (0.55, 0.57, 0.60)),
    (8, (0.83, 0.64, 0.12)),
    (6, (0.60, 0.12, 0.10)),
    (5, (0.12, 0.14, 0.16)),
    (4, (0.14, 0.36, 0.24)),
)
_BUSES: Palette = (
    (4, (0.14, 0.34, 0.66)),
    (4, (0.18, 0.50, 0.28)),
    (3, (0.74, 0.14, 0.12)),
    (2, (0.85, 0.84, 0.80)),
    (2, (0.84, 0.62, 0.12)),
)
_TARPAULINS: Palette = (
    (5, (0.16, 0.28, 0.48)),
    (4, (0.15, 0.34, 0.25)),
    (4, (0.80, 0.80, 0.78)),
    (3, (0.62, 0.15, 0.12)),
    (3, (0.48, 0.46, 0.42)),
    (2, (0.80, 0.45, 0.10)),
)
_CLOTHES: Palette = (
    (6, (0.10, 0.10, 0.12)),
    (4, (0.20, 0.24, 0.34)),
    (4, (0.55, 0.55, 0.56)),
    (3, (0.83, 0.82, 0.78)),
    (3, (0.40, 0.12, 0.14)),
    (3, (0.66, 0.56, 0.42)),
    (2, (0.75, 0.20, 0.16)),
    (2, (0.20, 0.42, 0.30)),
    (2, (0.24, 0.44, 0.66)),
    (2, (0.82, 0.66, 0.20)),
    (1, (0.72, 0.36, 0.52)),
    (1, (0.86, 0.46, 0.12)),
)
_TROUSERS: Palette = (
    (6, (0.13, 0.16, 0.24)),
    (5, (0.10, 0.10, 0.11)),
    (3, (0.30, 0.32, 0.36)),
    (3, (0.56, 0.49, 0.38)),
    (2, (0.26, 0.36, 0.50)),
    (1, (0.72, 0.71, 0.68)),
)
_SKINS: Palette = (
    (5, (0.86, 0.68, 0.56)),
    (4, (0.78, 0.58, 0.45)),
    (3, (0.62, 0.43, 0.31)),
    (2, (0.42, 0.28, 0.20)),
    (1, (0.30, 0.20, 0.15)),
)
_HAIRS: Palette = (
    (7, (0.07, 0.06, 0.06)),
    (4, (0.20, 0.13, 0.09)),
    (2, (0.42, 0.30, 0.18)),
    (2, (0.62, 0.60, 0.58)),
    (1, (0.70, 0.56, 0.32)),
    (1, (0.46, 0.20, 0.10)),
)
_BAGS: Palette = (
    (3, (0.12, 0.12, 0.14)),
    (2, (0.45, 0.32, 0.20)),
    (2, (0.60, 0.16, 0.14)),
    (2, (0.20, 0.32, 0.50)),
    (1, (0.75, 0.62, 0.20)),
)
_METALS: Palette = (
    (5, (0.56, 0.57, 0.58)),
    (3, (0.36, 0.37, 0.38)),
    (2, (0.16, 0.16, 0.17)),
)
_CARGOES: Palette = (
    (3, (0.52, 0.42, 0.28)),
    (2, (0.40, 0.36, 0.32)),
    (2, (0.62, 0.58, 0.50)),
    (1, (0.20, 0.32, 0.46)),
)
_SECOND: Palette = (*_WORK, *_TARPAULINS)

_ALWAYS: dict[Material, Rgb] = {
    Material.GLASS: (0.09, 0.11, 0.13),
    Material.TYRE: (0.06, 0.06, 0.06),
    Material.TRIM: (0.13, 0.13, 0.14),
    Material.HEADLAMP: (0.90, 0.90, 0.84),
    Material.TAIL_LAMP: (0.58, 0.05, 0.05),
}
_PALETTES: dict[Material, Palette] = {
    Material.PAINT: _CARS,
    Material.SECOND_PAINT: _SECOND,
    Material.METAL: _METALS,
    Material.SKIN: _SKINS,
    Material.HAIR: _HAIRS,
    Material.CLOTH: _CLOTHES,
    Material.TROUSERS: _TROUSERS,
    Material.BAG: _BAGS,
    Material.CARGO: _CARGOES,
}
_PAINTS: dict[str, Palette] = {"delivery_van": _WORK, "light_truck": _WORK, "lorry": _WORK, "city_bus": _BUSES}
_BRIGHTER, _TINTED = 0.10, 0.025  # no two are painted quite alike: spread of brightness, and of each channel


def colour_of(kind: str, material: Material, rng: np.random.Generator) -> Rgb:
    """A colour for one material of one user."""
    if material in _ALWAYS:
        return _ALWAYS[material]
    palette = _PAINTS.get(kind, _CARS) if material is Material.PAINT else _PALETTES[material]
    weights = np.array([weight for weight, _ in palette], np.float64)
    _, rgb = palette[rng.choice(len(palette), p=weights / weights.sum())]
    levels = np.array(rgb) * (1.0 + _BRIGHTER * rng.normal() + _TINTED * rng.normal(size=3))
    red, green, blue = np.clip(levels, 0.02, 0.95).tolist()
    return red, green, blue
