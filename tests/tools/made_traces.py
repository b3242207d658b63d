"""Traces of a face of rock as a geologist would draw them, from a seed."""
import json

import numpy as np


def made_traces(count, width, height, seed):
    """Joint traces in a window from 0 0 to width height, as GeoJSON (a text): three sets whose directions scatter (von Mises), with
    lengths of a power law of exponent 2.5 cut at half the height, that bend as hand-drawn lines do, and whose second and third sets
    often end at the first as joints do that are younger."""
    random = np.random.default_rng(seed)
    sets = ((10.0, 60.0, 0.4), (95.0, 40.0, 0.35), (140.0, 25.0, 0.25))  # direction (degrees), concentration, share of the traces
    least, most, exponent = 0.04 * height, 0.5 * height, 2.5
    features = []
    for number, (direction, concentration, share) in enumerate(sets, 1):
        for _ in range(round(share * count)):
            u = random.uniform()
            length = (least**(1 - exponent) + u * (most**(1 - exponent) - least**(1 - exponent)))**(1 / (1 - exponent))
            angle = np.radians(direction) + random.vonmises(0, concentration) / 2
            pieces = max(1, round(length / (0.03 * height)))
            turns = angle + np.cumsum(random.normal(0, np.radians(3), pieces))
            steps = length / pieces * np.column_stack([np.cos(turns), np.sin(turns)])
            middle = random.uniform((0, 0), (width, height))
            places = np.vstack([[0, 0], np.cumsum(steps, axis=0)])
            places += middle - places.mean(0)
            features.append({"type": "Feature", "properties": {"azimuth_set": str(number), "length": length},
                             "geometry": {"type": "LineString", "coordinates": places.tolist()}})
    return json.dumps({"type": "FeatureCollection", "features": features})
