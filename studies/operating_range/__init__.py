"""How far each law can go: the flights, the maps and their pictures."""
