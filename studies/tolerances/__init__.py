"""What each law tolerates of measurements and of its supply: the flights, the maps and their pictures."""
