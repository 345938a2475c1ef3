"""Repairs of submitted files: made, suggested, and made again after a regrade."""
