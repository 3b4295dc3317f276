"""What runs in the far process: sent there as source, so Python 3.8 and NumPy are all it may ask for."""
