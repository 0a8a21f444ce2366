"""Tools of the developers: set-up, and the record of what the program computes."""
