"""Meshes of finite elements: cells, places and surfaces picked on them, their quality."""
