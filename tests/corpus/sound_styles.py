"""Sound ways to write the reader, the recording, the noise and the filter."""



from __future__ import annotations

from tests.corpus import sheet
from tests.corpus.pieces import (
    COLLECT_APPEND,
    COLLECT_FORWARD_FIRST,
    COLLECT_WHILE,
    PLOT_PYPLOT,
    READ_FANCY,
    READ_LISTS,
    READ_NAMED,
    lab,
    listy,
)
from tests.corpus.sound_models import (
    FILTER_CLOSURE,
    FILTER_COROUTINE,
    FILTER_DATACLASS,
    FILTER_HISTORY,
    FILTER_LFILTER,
    FILTER_PER_AXIS,
    NOISE_BLOCKS,
    NOISE_LAZY_BIAS,
    NOISE_RANDOM_MODULE,
    NOISE_SCIPY,
    NOISE_STANDARD_NORMAL,
)
from tests.corpus.sound_recordings import (
    COLLECT_FRESH_DATA,
    COLLECT_GENERATOR,
    COLLECT_IDS_FIRST,
    COLLECT_IDS_LAST,
    COLLECT_LISTS,
    COLLECT_NAMES_AS_OPTIONS,
    COLLECT_REAL_TIME,
    COLLECT_THREAD,
    COLLECT_TWO_HALVES,
    IDS_AT_IMPORT,
    IDS_UNDER_MAIN,
    MAIN_IDS_FIRST,
    PLOT_LISTS,
)

MAIN_LOGGING = '''\
import argparse
import logging
from pathlib import Path

log = logging.getLogger(__name__)


def main(argv=None):
    parser = argparse.ArgumentParser(description="Record and plot the IMU of the humanoid")
    parser.add_argument("--model", type=Path, default=Path(MODEL_PATH))
    parser.add_argument("--duration", type=float, default=3.0)
    args = parser.parse_args(argv)
    logging.basicConfig(level=logging.DEBUG, format="%(levelname)s %(message)s")
    model = mujoco.MjModel.from_xml_path(str(args.model))
    log.info("model has %d sensors", model.nsensor)
    plot_imu_data(simulate_and_collect(model, mujoco.MjData(model), args.duration))


if __name__ == "__main__":
    raise SystemExit(main())
'''

MAIN_SPEC = '''\
if __name__ == "__main__":
    if hasattr(mujoco, "MjSpec"):        # newer MuJoCo: edit the model before it is compiled
        spec = mujoco.MjSpec.from_file(MODEL_PATH)
        model = spec.compile()
    else:
        model = mujoco.MjModel.from_xml_path(MODEL_PATH)
    data = mujoco.MjData(model)
    plot_imu_data(simulate_and_collect(model, data, 3.0))
'''

MAIN_FROM_STRING = '''\
if __name__ == "__main__":
    with open(MODEL_PATH, encoding="utf-8") as file:
        model = mujoco.MjModel.from_xml_string(file.read())
    data = mujoco.MjData(model)
    plot_imu_data(simulate_and_collect(model, data, 3.0))
'''

# Only the commented sheet: module level, ids nowhere but in the demonstration of another file.
NO_IDS = lab(collect=sheet.COLLECT, main="", plot=sheet.PLOT)
NO_IDS["run_lab.py"] = '''\
import mujoco

import imu_reader

model = mujoco.MjModel.from_xml_path("textbook/assets/robot-models/mujoco/humanoid-sensors.xml")
data = mujoco.MjData(model)
imu_reader.accel_id = model.sensor("torso_accelerometer").id
imu_reader.gyro_id = model.sensor("torso_gyroscope").id
imu_reader.plot_imu_data(imu_reader.simulate_and_collect(model, data, 3.0))
'''

STYLES = {
    "tidy_functions": lab(),
    "lists_that_grow": listy(),
    "ids_as_globals_at_import": lab(head=IDS_AT_IMPORT, collect=sheet.COLLECT),
    "ids_as_globals_under_main": lab(collect=sheet.COLLECT, main=IDS_UNDER_MAIN),
    "ids_as_globals_nowhere": NO_IDS,
    "ids_as_last_parameters": lab(collect=COLLECT_IDS_LAST, read=READ_FANCY),
    "ids_as_first_parameters": lab(collect=COLLECT_IDS_FIRST, main=MAIN_IDS_FIRST, noise=NOISE_SCIPY),
    "names_as_keyword_options": lab(collect=COLLECT_NAMES_AS_OPTIONS, low_pass=FILTER_DATACLASS),
    "sensors_by_name_fresh_data": lab(read=READ_NAMED, collect=COLLECT_FRESH_DATA, noise=NOISE_STANDARD_NORMAL),
    "step_in_two_halves": lab(collect=COLLECT_TWO_HALVES, low_pass=FILTER_LFILTER),
    "forward_read_step": lab(collect=COLLECT_FORWARD_FIRST, low_pass=FILTER_CLOSURE),
    "while_time_is_left": lab(collect=COLLECT_WHILE, noise=NOISE_BLOCKS, low_pass=FILTER_HISTORY),
    "generator_of_samples": lab(read=READ_FANCY, collect=COLLECT_GENERATOR, low_pass=FILTER_COROUTINE),
    "lists_everywhere": lab(
        read=READ_LISTS, collect=COLLECT_LISTS, plot=PLOT_LISTS, noise=NOISE_RANDOM_MODULE, low_pass=FILTER_PER_AXIS
    ),
    "thread_and_queue": lab(collect=COLLECT_THREAD, noise=NOISE_LAZY_BIAS, plot=PLOT_PYPLOT),
    "real_time_pacing_and_progress": lab(collect=COLLECT_REAL_TIME, main=MAIN_LOGGING),
    "logging_argparse_pathlib": lab(main=MAIN_LOGGING, collect=COLLECT_APPEND, noise=NOISE_SCIPY),
    "model_from_a_specification": lab(main=MAIN_SPEC, read=READ_NAMED, low_pass=sheet.LOW_PASS),
    "model_from_a_string": lab(main=MAIN_FROM_STRING, noise=sheet.NOISY_IMU, low_pass=FILTER_LFILTER),
}
