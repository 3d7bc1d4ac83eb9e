"""Linear models of plants, controllers and their loops about an equilibrium, differentiated from the equations."""
