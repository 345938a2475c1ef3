"""Measurements that are run by hand; their last figures stand in the README."""
