"""The desk: a local web page to draw a problem, plan it and look at the result."""
