"""Mechanisms as data: bodies, joints, springs, drivers, loads and their parameters, without arrays."""
