"""Faults of Step 5: the noise model."""



from __future__ import annotations

from importlib import resources

from tests.corpus.faults import Faulty
from tests.corpus.pieces import NOISE_GENERATOR, edit, lab, verbatim

STARTER = resources.files("grader.labs.imu").joinpath("starter", "noisy_imu.py.txt").read_text(encoding="utf-8")


def sheet(*changes: tuple[str, str]) -> dict[str, str]:
    return edit(verbatim(), "noisy_imu.py", *changes)


def tidy(*changes: tuple[str, str]) -> dict[str, str]:
    return lab(noise=edit({"n": NOISE_GENERATOR}, "n", *changes)["n"])


def fault(name: str, mistake: str, files: dict[str, str], **more: object) -> Faulty:
    return Faulty(name, mistake, "noise_model", files, **more)  # type: ignore[arg-type]


ACCEL_NOISE = "np.random.normal(0, self.accel_noise_std, 3)"
GYRO_NOISE = "np.random.normal(0, self.gyro_noise_std, 3)"
ACCEL_LINE = f"accel_noisy = accel + {ACCEL_NOISE} + self.accel_bias"
GYRO_LINE = f"gyro_noisy = gyro + {GYRO_NOISE} + self.gyro_bias"
TIDY_ACCEL = "self.rng.normal(0.0, self.accel_noise_std, size=3)"
TIDY_GYRO = "self.rng.normal(0.0, self.gyro_noise_std, size=3)"
DRAWN_ACCEL = "accel_bias if accel_bias is not None else np.random.normal(0, 0.1, 3)"
DRAWN_GYRO = "gyro_bias if gyro_bias is not None else np.random.normal(0, 0.01, 3)"
READ = "        accel, gyro = get_imu_readings(self.model, self.data, self.accel_id, self.gyro_id)\n"
LAST_OF_INIT = "        self.gyro_bias = np.asarray(gyro_bias, dtype=float)\n"


def both(accel: str, gyro: str) -> dict[str, str]:
    """The sheet with its two draws written otherwise."""
    return sheet((ACCEL_NOISE, accel), (GYRO_NOISE, gyro))


def both_tidy(accel: str, gyro: str) -> dict[str, str]:
    return tidy((TIDY_ACCEL, accel), (TIDY_GYRO, gyro))


NOISE_FAULTS = [
    fault("left-as-in-the-starter-file", "not-written", {**lab(), "noisy_imu.py": STARTER}),
    fault("bias-but-no-noise", "no-noise", both("0", "0")),
    fault("clean-reading-returned", "no-noise", tidy(("        accel = accel + self.accel_bias + self.rng.normal(0.0, self.accel_noise_std, size=3)\n", "        accel = accel + self.accel_bias\n"), (f"gyro + self.gyro_bias + {TIDY_GYRO}", "gyro + self.gyro_bias"))),
    fault("gyroscope-left-clean", "gyro-not-noisy", sheet((GYRO_LINE, "gyro_noisy = gyro + self.gyro_bias"))),
    fault("accelerometer-left-clean", "gyro-not-noisy", tidy((f"accel + self.accel_bias + {TIDY_ACCEL}", "accel + self.accel_bias"))),
    fault("std-taken-as-variance", "variance-as-std", both("np.random.normal(0, np.sqrt(self.accel_noise_std), 3)", "np.random.normal(0, np.sqrt(self.gyro_noise_std), 3)")),
    fault("std-squared", "variance-as-std", both_tidy("self.rng.normal(0.0, self.accel_noise_std ** 2, size=3)", "self.rng.normal(0.0, self.gyro_noise_std ** 2, size=3)")),
    fault("std-squared-in-covariance", "variance-as-std", both_tidy("self.rng.multivariate_normal(np.zeros(3), self.accel_noise_std * np.eye(3))", "self.rng.multivariate_normal(np.zeros(3), self.gyro_noise_std * np.eye(3))"), reason="the square root of the covariance is what is drawn"),
    fault("numbers-in-place-of-arguments", "std-ignored", both("np.random.normal(0, 0.05, 3)", "np.random.normal(0, 0.005, 3)")),
    fault("arguments-overwritten", "std-ignored", tidy(("self.accel_noise_std = accel_noise_std", "self.accel_noise_std = 0.05"), ("self.gyro_noise_std = gyro_noise_std", "self.gyro_noise_std = 0.005"))),
    fault("standard-normal-not-scaled", "std-ignored", both_tidy("self.rng.standard_normal(3)", "self.rng.standard_normal(3)")),
    fault("stds-exchanged", "stds-swapped", sheet(("self.accel_noise_std = accel_noise_std", "self.accel_noise_std = gyro_noise_std"), ("self.gyro_noise_std = gyro_noise_std", "self.gyro_noise_std = accel_noise_std"))),
    fault("stds-exchanged-in-read", "stds-swapped", both_tidy(TIDY_GYRO, TIDY_ACCEL)),
    fault("accel-std-for-both", "stds-swapped", sheet((GYRO_NOISE, "np.random.normal(0, self.accel_noise_std, 3)")), also=("std-ignored",)),
    fault("one-number-for-three-axes", "same-noise-on-axes", both("np.random.normal(0, self.accel_noise_std)", "np.random.normal(0, self.gyro_noise_std)")),
    fault("one-number-times-ones", "same-noise-on-axes", both_tidy("self.rng.normal(0.0, self.accel_noise_std) * np.ones(3)", "self.rng.normal(0.0, self.gyro_noise_std) * np.ones(3)")),
    fault("one-draw-for-both-sensors", "", tidy((READ, READ + "        noise = self.rng.standard_normal(3)\n"), (TIDY_ACCEL, "noise * self.accel_noise_std"), (TIDY_GYRO, "noise * self.gyro_noise_std")), loses=("noise_model.axes_and_sensors_independent",), never=("same-noise-on-axes",), reason="the gyroscope's noise is the accelerometer's, scaled"),
    fault("drawn-in-the-constructor", "frozen-noise", tidy((LAST_OF_INIT, LAST_OF_INIT + "        self.accel_noise = self.rng.normal(0, accel_noise_std, 3)\n        self.gyro_noise = self.rng.normal(0, gyro_noise_std, 3)\n"), (TIDY_ACCEL, "self.accel_noise"), (TIDY_GYRO, "self.gyro_noise"))),
    fault("seed-in-read", "reseeded", sheet((READ, "        np.random.seed(42)\n" + READ)), also=("frozen-noise", "bias-not-random"), reason="an instance that is made after a read draws its bias from the same seed"),
    fault("generator-in-read", "reseeded", both_tidy("np.random.default_rng(0).normal(0.0, self.accel_noise_std, size=3)", "np.random.default_rng(1).normal(0.0, self.gyro_noise_std, size=3)"), also=("frozen-noise",)),
    fault("uniform-of-the-same-std", "not-gaussian", both("np.random.uniform(-1.7320508, 1.7320508, 3) * self.accel_noise_std", "np.random.uniform(-1.7320508, 1.7320508, 3) * self.gyro_noise_std")),
    fault("laplace", "not-gaussian", both_tidy("self.rng.laplace(0.0, self.accel_noise_std / np.sqrt(2), size=3)", "self.rng.laplace(0.0, self.gyro_noise_std / np.sqrt(2), size=3)")),
    fault("uniform-within-one-std", "not-gaussian", both("np.random.uniform(-self.accel_noise_std, self.accel_noise_std, 3)", "np.random.uniform(-self.gyro_noise_std, self.gyro_noise_std, 3)")),
    fault("plus-or-minus-std", "not-gaussian", both_tidy("self.accel_noise_std * self.rng.choice([-1, 1], size=3)", "self.gyro_noise_std * self.rng.choice([-1, 1], size=3)")),
    fault("noisy-readings-rounded-to-two-decimals", "precision-lost", sheet(("        return accel_noisy, gyro_noisy\n", "        return np.round(accel_noisy, 2), np.round(gyro_noisy, 2)\n")), reason="the gyroscope's noise is half a step: its size, its law and its bias suffer from the same rounding", loses=("noise_model.white_and_gaussian",)),
    fault("noisy-readings-rounded-to-three-decimals", "precision-lost", tidy(("        return accel, gyro\n", "        return accel.round(3), gyro.round(3)\n")), loses=("noise_model.white_and_gaussian",)),
    fault("absolute-value-of-noise", "noise-not-zero-mean", both(f"np.abs({ACCEL_NOISE})", f"np.abs({GYRO_NOISE})")),
    fault("exponential", "noise-not-zero-mean", both("np.random.exponential(self.accel_noise_std, 3)", "np.random.exponential(self.gyro_noise_std, 3)"), reason="its standard deviation is the one asked for; its law is of one sign, and not normal", also=("not-gaussian",), loses=("noise_model.white_and_gaussian",)),
    fault("exponential-accelerometer", "noise-not-zero-mean", tidy((TIDY_ACCEL, "self.rng.exponential(self.accel_noise_std, size=3)")), also=("not-gaussian",), loses=("noise_model.white_and_gaussian",)),
    fault("exponential-about-its-mean", "not-gaussian", both_tidy("(self.rng.exponential(self.accel_noise_std, size=3) - self.accel_noise_std)", "(self.rng.exponential(self.gyro_noise_std, size=3) - self.gyro_noise_std)"), reason="zero mean and the right standard deviation, of another law"),
    fault("mean-of-one-std", "noise-not-zero-mean", both_tidy("self.rng.normal(self.accel_noise_std, self.accel_noise_std, size=3)", "self.rng.normal(self.gyro_noise_std, self.gyro_noise_std, size=3)")),
    fault("random-between-0-and-1", "noise-not-zero-mean", both("np.random.rand(3) * self.accel_noise_std", "np.random.rand(3) * self.gyro_noise_std"), also=("not-gaussian",)),
    fault("scaled-not-added", "multiplicative-noise", sheet((ACCEL_LINE, "accel_noisy = accel * (1 + np.random.normal(0, self.accel_noise_std, 3)) + self.accel_bias"), (GYRO_LINE, "gyro_noisy = gyro * (1 + np.random.normal(0, self.gyro_noise_std, 3)) + self.gyro_bias"))),
    fault("times-normal-about-one", "multiplicative-noise", tidy((f"accel + self.accel_bias + {TIDY_ACCEL}", "accel * self.rng.normal(1.0, self.accel_noise_std, size=3) + self.accel_bias"), (f"gyro + self.gyro_bias + {TIDY_GYRO}", "gyro * self.rng.normal(1.0, self.gyro_noise_std, size=3) + self.gyro_bias"))),
    fault("random-walk", "noise-accumulates", tidy((LAST_OF_INIT, LAST_OF_INIT + "        self.drift_a, self.drift_g = np.zeros(3), np.zeros(3)\n"), (READ, READ + f"        self.drift_a += {TIDY_ACCEL}\n        self.drift_g += {TIDY_GYRO}\n"), (f"self.accel_bias + {TIDY_ACCEL}\n", "self.accel_bias + self.drift_a\n"), (f"self.gyro_bias + {TIDY_GYRO}\n", "self.gyro_bias + self.drift_g\n"))),
    fault("bias-collects-the-noise", "noise-accumulates", sheet((READ, READ + f"        self.accel_bias = self.accel_bias + {ACCEL_NOISE}\n        self.gyro_bias = self.gyro_bias + {GYRO_NOISE}\n"), (f"accel + {ACCEL_NOISE} + self.accel_bias\n", "accel + self.accel_bias\n"), (f"gyro + {GYRO_NOISE} + self.gyro_bias\n", "gyro + self.gyro_bias\n"))),
    fault("bias-never-added", "no-bias", sheet((ACCEL_LINE, f"accel_noisy = accel + {ACCEL_NOISE}"), (GYRO_LINE, f"gyro_noisy = gyro + {GYRO_NOISE}"))),
    fault("bias-never-added-tidy", "no-bias", tidy(("accel + self.accel_bias + ", "accel + "), ("gyro + self.gyro_bias + ", "gyro + "))),
    fault("bias-drawn-in-read", "bias-redrawn", sheet((READ, READ + "        self.accel_bias = np.random.normal(0, 0.1, 3)\n        self.gyro_bias = np.random.normal(0, 0.01, 3)\n")), also=("bias-argument-ignored",)),
    fault("bias-drawn-in-read-if-none", "bias-redrawn", sheet((DRAWN_ACCEL, "accel_bias"), (DRAWN_GYRO, "gyro_bias"), (READ, READ + "        accel_bias = np.random.normal(0, 0.1, 3) if self.accel_bias is None else self.accel_bias\n        gyro_bias = np.random.normal(0, 0.01, 3) if self.gyro_bias is None else self.gyro_bias\n"), (f"{ACCEL_NOISE} + self.accel_bias\n", f"{ACCEL_NOISE} + accel_bias\n"), (f"{GYRO_NOISE} + self.gyro_bias\n", f"{GYRO_NOISE} + gyro_bias\n"))),
    fault("bias-always-drawn", "bias-argument-ignored", sheet((DRAWN_ACCEL, "np.random.normal(0, 0.1, 3)"), (DRAWN_GYRO, "np.random.normal(0, 0.01, 3)"))),
    fault("zero-bias-taken-for-none", "bias-argument-ignored", tidy(("if accel_bias is None:", "if accel_bias is None or not np.any(accel_bias):"), ("if gyro_bias is None:", "if gyro_bias is None or not np.any(gyro_bias):")), reason="a bias of zero is a bias"),
    fault("given-bias-tested-with-or", "raises", sheet((DRAWN_ACCEL, "accel_bias or np.random.normal(0, 0.1, 3)"), (DRAWN_GYRO, "gyro_bias or np.random.normal(0, 0.01, 3)")), loses=("noise_model.given_bias",)),
    fault("given-bias-of-four-numbers", "raises", sheet((DRAWN_ACCEL, "accel_bias.reshape(4) if accel_bias is not None else np.random.normal(0, 0.1, 3)")), reason="only a given bias raises: what is drawn, added and left alone is right", loses=("noise_model.given_bias",)),
    fault("given-bias-taken-apart-by-name", "raises", sheet((DRAWN_ACCEL, "[accel_bias.x, accel_bias.y, accel_bias.z] if accel_bias is not None else np.random.normal(0, 0.1, 3)"), (DRAWN_GYRO, "[gyro_bias.x, gyro_bias.y, gyro_bias.z] if gyro_bias is not None else np.random.normal(0, 0.01, 3)")), loses=("noise_model.given_bias",)),
    fault("zeros-by-default", "bias-not-random", sheet((DRAWN_ACCEL, "accel_bias if accel_bias is not None else np.zeros(3)"), (DRAWN_GYRO, "gyro_bias if gyro_bias is not None else np.zeros(3)"))),
    fault("constants-by-default", "bias-not-random", tidy(("accel_bias = self.rng.normal(0.0, 0.1, size=3)", "accel_bias = [0.05, -0.03, 0.08]"), ("gyro_bias = self.rng.normal(0.0, 0.01, size=3)", "gyro_bias = [0.002, -0.004, 0.001]"))),
    fault("constants-of-the-noise-size", "bias-not-random", tidy(("accel_bias = self.rng.normal(0.0, 0.1, size=3)", "accel_bias = self.accel_noise_std * np.array([1.0, -0.6, 1.6])"), ("gyro_bias = self.rng.normal(0.0, 0.01, size=3)", "gyro_bias = self.gyro_noise_std * np.array([0.4, -0.8, 0.2])")), loses=("noise_model.default_bias",)),
    fault("generator-with-a-fixed-seed", "bias-not-random", tidy(("np.random.default_rng() if rng is None", "np.random.default_rng(42) if rng is None"))),
    fault("one-bias-for-three-axes", "bias-shared", sheet(("np.random.normal(0, 0.1, 3)", "np.random.normal(0, 0.1) * np.ones(3)"), ("np.random.normal(0, 0.01, 3)", "np.random.normal(0, 0.01) * np.ones(3)"))),
    fault("bias-of-the-class", "bias-shared", tidy(("    def __init__(self", "    ACCEL_BIAS = np.random.normal(0.0, 0.1, 3)\n    GYRO_BIAS = np.random.normal(0.0, 0.01, 3)\n\n    def __init__(self"), ("accel_bias = self.rng.normal(0.0, 0.1, size=3)", "accel_bias = self.ACCEL_BIAS"), ("gyro_bias = self.rng.normal(0.0, 0.01, size=3)", "gyro_bias = self.GYRO_BIAS")), also=("bias-not-random",)),
    fault("bias-kept-on-the-class", "bias-shared", sheet(("self.accel_bias = accel_bias if", "NoisyIMU.accel_bias = accel_bias if"), ("self.gyro_bias = gyro_bias if", "NoisyIMU.gyro_bias = gyro_bias if")), reason="each new instance gives its bias to all that were made before", never=("bias-redrawn",), loses=("noise_model.default_bias",)),
    fault("bias-kept-in-a-global", "bias-shared", tidy(("        self.accel_bias = np.asarray(accel_bias, dtype=float)\n", "        global BIAS_A, BIAS_G\n        BIAS_A = np.asarray(accel_bias, dtype=float)\n"), (LAST_OF_INIT, "        BIAS_G = np.asarray(gyro_bias, dtype=float)\n"), ("accel + self.accel_bias", "accel + BIAS_A"), ("gyro + self.gyro_bias", "gyro + BIAS_G")), never=("bias-redrawn",), loses=("noise_model.default_bias",)),
    fault("bias-drawn-when-defined", "bias-shared", sheet(("accel_bias=None, gyro_bias=None):", "accel_bias=np.random.normal(0, 0.1, 3), gyro_bias=np.random.normal(0, 0.01, 3)):")), also=("bias-not-random",), reason="a default value is made once, when the class is defined"),
    fault("one-bias-for-both-sensors", "bias-shared", tidy(("gyro_bias = self.rng.normal(0.0, 0.01, size=3)", "gyro_bias = np.asarray(accel_bias) * 0.1"))),
    fault("bias-subtracted", "bias-sign-flipped", sheet((f"{ACCEL_NOISE} + self.accel_bias\n", f"{ACCEL_NOISE} - self.accel_bias\n"), (f"{GYRO_NOISE} + self.gyro_bias\n", f"{GYRO_NOISE} - self.gyro_bias\n"))),
    fault("bias-subtracted-tidy", "bias-sign-flipped", tidy(("accel + self.accel_bias", "accel - self.accel_bias"), ("gyro + self.gyro_bias", "gyro - self.gyro_bias"))),
    fault("noise-into-the-simulator", "mutates-sensordata", tidy((READ, "        a, g = self.model.sensor_adr[self.accel_id], self.model.sensor_adr[self.gyro_id]\n        accel, gyro = self.data.sensordata[a:a + 3], self.data.sensordata[g:g + 3]\n"), (f"        accel = accel + self.accel_bias + {TIDY_ACCEL}\n", f"        accel += self.accel_bias + {TIDY_ACCEL}\n"), (f"        gyro = gyro + self.gyro_bias + {TIDY_GYRO}\n        return accel, gyro\n", f"        gyro += self.gyro_bias + {TIDY_GYRO}\n        return accel.copy(), gyro.copy()\n")), also=("noise-accumulates",)),
    fault("writes-the-noise-back", "mutates-sensordata", sheet(("        return accel_noisy, gyro_noisy\n", "        adr = self.model.sensor_adr[self.accel_id]\n        self.data.sensordata[adr:adr+3] = accel_noisy\n        return accel_noisy, gyro_noisy\n")), also=("noise-accumulates",)),
    fault("steps-in-read", "disturbs-simulation", sheet((READ, "        mujoco.mj_step(self.model, self.data)\n" + READ)), reason="the noise and the bias of what it reads are right", loses=("noise_model.leaves_simulation_alone",)),
    fault("steps-after-read", "disturbs-simulation", tidy((READ, READ + "        mujoco.mj_step(self.model, self.data)\n")), loses=("noise_model.leaves_simulation_alone",)),
    fault("resets-in-read", "disturbs-simulation", tidy((READ, "        mujoco.mj_resetData(self.model, self.data)\n        mujoco.mj_forward(self.model, self.data)\n" + READ)), loses=("noise_model.leaves_simulation_alone",)),
    fault("steps-ten-times-in-read", "disturbs-simulation", sheet((READ, "        for _ in range(10):\n            mujoco.mj_step(self.model, self.data)\n" + READ)), loses=("noise_model.leaves_simulation_alone",)),
    fault("gyro-returned-first", "swapped-sensors", tidy(("        return accel, gyro\n", "        return gyro, accel\n")), reason="each vector is right, in the other's place", never=("stds-swapped",), loses=("noise_model.given_bias",)),
    fault("gyro-returned-first-in-the-sheet", "swapped-sensors", sheet(("        return accel_noisy, gyro_noisy\n", "        return gyro_noisy, accel_noisy\n")), never=("stds-swapped",), loses=("noise_model.given_bias",)),
    fault("ids-in-each-others-place", "swapped-sensors", sheet(("get_imu_readings(self.model, self.data, self.accel_id, self.gyro_id)", "get_imu_readings(self.model, self.data, self.gyro_id, self.accel_id)")), loses=("noise_model.given_bias",)),
    fault("clean-readings-unpacked-the-other-way-round", "swapped-sensors", tidy((READ, READ.replace("accel, gyro", "gyro, accel"))), loses=("noise_model.given_bias",)),
    fault("clean-reading-kept", "stale-clean-reading", tidy((LAST_OF_INIT, LAST_OF_INIT + "        self.clean = get_imu_readings(model, data, accel_id, gyro_id)\n"), (READ, "        accel, gyro = self.clean\n"))),
    fault("clean-reading-kept-at-first-read", "stale-clean-reading", sheet((READ, "        if not hasattr(self, 'clean'):\n            self.clean = get_imu_readings(self.model, self.data, self.accel_id, self.gyro_id)\n        accel, gyro = self.clean\n"))),
    fault("noise-raises", "raises", sheet((ACCEL_NOISE, "np.random.normal(0, -self.accel_noise_std, 3)"))),
    fault("deviation-not-kept", "raises", sheet(("        self.accel_noise_std = accel_noise_std\n", "        accel_noise_std = accel_noise_std\n"))),
    fault("noisy-read-returns-none", "wrong-return-type", sheet(("        return accel_noisy, gyro_noisy\n", "        self.last = accel_noisy, gyro_noisy\n"))),
    fault("noisy-read-returns-three-arrays", "wrong-return-type", tidy(("        return accel, gyro\n", "        return accel, gyro, self.accel_bias\n")), never=("not-finite",)),
    fault("noisy-read-returns-two-axes", "wrong-return-type", sheet(("        return accel_noisy, gyro_noisy\n", "        return accel_noisy[:2], gyro_noisy[:2]\n")), also=("wrong-length",), never=("not-finite",)),
    fault("noise-of-nan", "not-finite", both_tidy("np.log(self.rng.normal(0.0, self.accel_noise_std, size=3))", "np.log(self.rng.normal(0.0, self.gyro_noise_std, size=3))")),
    fault("rejects-for-ever", "never-returns", tidy((READ, READ + "        while self.rng.normal() < 1e9:\n            pass\n"))),
    fault("noise-recurses", "kills-its-process", tidy((READ, READ + "        import os\n        os.abort()\n"))),
    fault("class-under-another-name", "name-missing", lab(noise=NOISE_GENERATOR.replace("class NoisyIMU", "class NoisySensor")) | {"filters.py": lab()["filters.py"].replace("NoisyIMU", "NoisySensor"), "noisy_imu.py": lab(noise=NOISE_GENERATOR)["noisy_imu.py"].replace("NoisyIMU", "NoisySensor")}),
    fault("bias-walks-in-the-sheet", "bias-drifts", sheet((READ, READ + "        self.accel_bias = self.accel_bias + np.random.normal(0, 0.002, 3)\n        self.gyro_bias = self.gyro_bias + np.random.normal(0, 0.0002, 3)\n")), never=("bias-redrawn", "noise-accumulates"), loses=("noise_model.default_bias",)),
    fault("noise-for-a-rate-of-five-hundred", "noise-density", both("np.random.normal(0, self.accel_noise_std * 500 ** 0.5, 3)", "np.random.normal(0, self.gyro_noise_std * 500 ** 0.5, 3)"), never=("variance-as-std", "std-ignored"), loses=("noise_model.noise_size",)),
    fault("half-of-the-noise-before", "noise-correlated", tidy((LAST_OF_INIT, LAST_OF_INIT + "        self.before = np.zeros(6)\n"), (READ, READ + "        self.before = 0.5 * self.before + self.rng.standard_normal(6)\n"), (TIDY_ACCEL, "self.accel_noise_std * self.before[:3]"), (TIDY_GYRO, "self.gyro_noise_std * self.before[3:]")), never=("noise-accumulates", "bias-drifts"), loses=("noise_model.white_and_gaussian",)),
    fault("noise-within-two-and-a-half", "noise-clipped", both("np.clip(np.random.normal(0, self.accel_noise_std, 3), -2.5 * self.accel_noise_std, 2.5 * self.accel_noise_std)", "np.clip(np.random.normal(0, self.gyro_noise_std, 3), -2.5 * self.gyro_noise_std, 2.5 * self.gyro_noise_std)"), never=("not-gaussian",), loses=("noise_model.white_and_gaussian",)),
    fault("bias-from-z-to-x", "bias-axes-exchanged", sheet((ACCEL_LINE, ACCEL_LINE.replace("self.accel_bias", "np.flip(self.accel_bias)")), (GYRO_LINE, GYRO_LINE.replace("self.gyro_bias", "np.flip(self.gyro_bias)"))), never=("bias-argument-ignored",), loses=("noise_model.given_bias",)),
    fault("each-with-the-others-bias", "biases-exchanged", sheet((ACCEL_LINE, ACCEL_LINE.replace("self.accel_bias", "self.gyro_bias")), (GYRO_LINE, GYRO_LINE.replace("self.gyro_bias", "self.accel_bias"))), never=("bias-argument-ignored", "bias-shared", "swapped-sensors"), loses=("noise_model.given_bias",)),
]
