"""The desk: a local web page for drawing a problem, planning it and viewing the result."""
