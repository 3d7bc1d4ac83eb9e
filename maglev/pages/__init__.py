"""What all pages have: colours, and the way to the other pages that lie beside them."""
