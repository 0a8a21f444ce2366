"""What a run leaves behind: the summary, the evaluated grid, the path as GeoJSON and a picture."""
