"""Export: an arm as a C++ header."""
