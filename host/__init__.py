"""The host side of pathgene: terrain, evaluation, planners, link to a board, command line."""
