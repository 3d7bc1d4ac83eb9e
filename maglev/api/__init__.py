"""What one does with this package, as functions: the command line calls them, and `import maglev` has them."""
