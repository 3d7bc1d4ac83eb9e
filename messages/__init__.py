"""Wording of messages, for all packages that refuse what a person has given them."""
