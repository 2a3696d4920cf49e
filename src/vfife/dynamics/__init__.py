"""Maps of motions: bifurcation diagrams, Poincaré sections, basins of attraction, waterfalls."""
