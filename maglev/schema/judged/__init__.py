"""What an experiment is judged by: claims, and the procedures that evaluate several runs."""
