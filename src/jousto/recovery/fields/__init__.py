"""Stress and strain fields: any place, any instant, in blocks that fit the memory."""
