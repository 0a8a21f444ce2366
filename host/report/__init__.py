"""Files of a run: the summary, the evaluated grid, the path as GeoJSON and a picture."""
