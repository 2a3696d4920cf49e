"""Wear over many turns: depths and volumes, worn profiles, jumps over cycles, and lives."""
