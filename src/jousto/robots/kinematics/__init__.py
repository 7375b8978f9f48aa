"""Kinematics and dynamics of robots: topology, loops, Jacobians, trees, inverse kinematics."""
