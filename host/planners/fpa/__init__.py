"""The flower pollination algorithm of *roberge*, with and without the 2-opt operator."""
