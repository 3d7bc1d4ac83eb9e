"""What is drawn and written about an FMU: icon, sketch, and the page with equations and variables."""
