"""Bodies: links, rigid bodies, point masses, frames, and their cross sections."""

from .model.bodies import Frame, Link, Member, Pin, PointMass, RigidBody, Section

__all__ = ["Frame", "Link", "Member", "Pin", "PointMass", "RigidBody", "Section"]
