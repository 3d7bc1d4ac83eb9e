"""Many runs: batches, studies, tuning, and Gymnasium environments."""
