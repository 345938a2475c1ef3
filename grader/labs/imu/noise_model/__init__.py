"""The criterion *Noise model*: judges whether `NoisyIMU` adds white Gaussian noise of the requested size and a constant bias."""
