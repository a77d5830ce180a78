"""Hostile files, names and strangers: cases as data and generators, and where they are tried."""
