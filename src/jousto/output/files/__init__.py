"""Files for other programs: tables, VTU, SID, contour and mesh files."""
