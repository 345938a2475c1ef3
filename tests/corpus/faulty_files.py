"""Faults of whole files, and a submission that looks for the grader."""



from __future__ import annotations

from tests.corpus import sheet
from tests.corpus.faults import Faulty
from tests.corpus.pieces import edit, lab, listy, looping, tidy, verbatim

READER_CRITERIA = ("data_collection", "visualization")


def without(files: dict[str, str], name: str) -> dict[str, str]:
    return {path: text for path, text in files.items() if path != name}


TAMPERING = '''\


def _peek():
    """Look for the answers."""
    import sys
    found = {}
    for frame in list(sys._current_frames().values()):
        while frame is not None:
            found.update({k: v for k, v in frame.f_locals.items() if "expected" in k or "truth" in k})
            frame = frame.f_back
    for name, module in list(sys.modules.items()):
        if name.startswith("grader"):
            for key in dir(module):
                if "points" in key:
                    setattr(module, key, lambda *a, **k: 100)
    return found


_peek()
'''

FILE_FAULTS = [
    Faulty("no-imu-reader", "file-missing", "sensor_access", without(tidy(), "imu_reader.py"), also=("name-missing",), elsewhere=READER_CRITERIA, reason="three criteria need what this file should hold"),
    Faulty("no-imu-reader-sheet", "file-missing", "sensor_access", without(verbatim(), "imu_reader.py"), also=("name-missing",), elsewhere=READER_CRITERIA),
    Faulty("no-noisy-imu", "file-missing", "noise_model", without(tidy(), "noisy_imu.py"), also=("name-missing",)),
    Faulty("no-filters", "file-missing", "filtering", without(listy(), "filters.py"), also=("name-missing",), elsewhere=("visualization",), reason="the comparison was drawn there"),
    Faulty("reader-with-a-syntax-error", "does-not-import", "sensor_access", edit(verbatim(), "imu_reader.py", ("def get_imu_readings(model, data, accel_sensor_id, gyro_sensor_id):", "def get_imu_readings(model, data, accel_sensor_id, gyro_sensor_id)")), elsewhere=("data_collection", "visualization"), reason="the three criteria need what this file should hold"),
    Faulty("recorder-with-a-syntax-error", "does-not-import", "data_collection", edit(verbatim(), "imu_reader.py", ("    for i in range(n_steps):", "    for i in range(n_steps)")), elsewhere=("sensor_access", "visualization"), reason="the three criteria need what this file should hold"),
    Faulty("noise-with-a-syntax-error", "does-not-import", "noise_model", edit(tidy(), "noisy_imu.py", ("    def read(self):", "    def read(self:"))),
    Faulty("noise-with-python-2-print", "does-not-import", "noise_model", edit(looping(), "noisy_imu.py", ('    print("noisy reading:", *imu.read())', '    print "noisy reading:", imu.read()'))),
    Faulty("filter-with-mixed-indentation", "does-not-import", "filtering", edit(listy(), "filters.py", ("        self.alpha = alpha\n", "\tself.alpha = alpha\n"))),
    Faulty("noise-imports-what-is-not-there", "missing-package", "noise_model", edit(tidy(), "noisy_imu.py", ("import mujoco\n", "import mujoco\nimport pymavlink\n"), ("    def read(self):\n", "    def read(self):\n        pymavlink.wait()\n"))),
    Faulty("reader-of-the-programs-own-data", "global-for-parameter", "sensor_access", edit(verbatim(), "imu_reader.py", ("def get_imu_readings(model, data,", "def get_imu_readings(m, d,")), loses=("sensor_access.returns_two_vectors",)),
    Faulty("filter-asks-for-the-time-step", "other-parameters", "filtering", edit(tidy(), "filters.py", ("def update(self, measurement):", "def update(self, measurement, dt):"), ("low_pass.update(", "low_pass.update(dt=0.002, measurement="))),
    Faulty("filter-raises-at-import", "does-not-import", "filtering", edit(tidy(), "filters.py", ("class LowPassFilter:\n", "class LowPassFilter:\n    SETTINGS = open('settings.json').read()\n"))),
    Faulty("noise-loops-at-import", "never-returns", "noise_model", edit(tidy(), "noisy_imu.py", ("class NoisyIMU:\n", "class NoisyIMU:\n    while True:\n        pass\n"))),
    Faulty("noise-exits-at-import", "kills-its-process", "noise_model", edit(listy(), "noisy_imu.py", ("class NoisyIMU:\n", "class NoisyIMU:\n    import os\n\n    os._exit(0)\n"))),
    Faulty("looks-for-the-grader", "tampering", "", {**tidy(), "imu_reader.py": tidy()["imu_reader.py"] + TAMPERING}, reason="costs nothing by itself"),
    Faulty("ships-a-conftest", "tampering", "", {**lab(low_pass=sheet.LOW_PASS), "conftest.py": "import pytest\n\n\n@pytest.hookimpl(hookwrapper=True)\ndef pytest_runtest_makereport(item, call):\n    outcome = yield\n    outcome.get_result().outcome = 'passed'\n"}, reason="costs nothing by itself"),
]
