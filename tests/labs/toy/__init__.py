"""A toy lab without MuJoCo: the engine that grades it knows neither."""
