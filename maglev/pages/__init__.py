"""What all pages have: colours, panels, and the way to the other pages that lie next to them."""
