"""Nouns to arrays: numbering, entities, start, numbers of every row, the largest stable step."""
