"""Sound ways to find the sensors and to record them."""



from __future__ import annotations

from tests.corpus.pieces import COLLECT_LOOKUP, HEAD

# ---------------------------------------------------------------- where the ids come from

IDS_AT_IMPORT = HEAD + '''\

model = mujoco.MjModel.from_xml_path(MODEL_PATH)
data = mujoco.MjData(model)
accel_id = model.sensor("torso_accelerometer").id
gyro_id = model.sensor("torso_gyroscope").id
'''

IDS_UNDER_MAIN = '''\
if __name__ == "__main__":
    model = mujoco.MjModel.from_xml_path(MODEL_PATH)
    data = mujoco.MjData(model)
    accel_id = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SENSOR, "torso_accelerometer")
    gyro_id = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SENSOR, "torso_gyroscope")
    imu_data = simulate_and_collect(model, data, duration_seconds=3.0)
    plot_imu_data(imu_data)
'''

COLLECT_IDS_LAST = COLLECT_LOOKUP.replace(
    "(model, data, duration_seconds=5.0)", "(model, data, duration_seconds=5.0, accel_sensor_id=None, gyro_sensor_id=None)"
).replace(
    "    accel_id = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SENSOR, \"torso_accelerometer\")\n"
    "    gyro_id = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SENSOR, \"torso_gyroscope\")\n",
    '    accel_id = model.sensor("torso_accelerometer").id if accel_sensor_id is None else accel_sensor_id\n'
    '    gyro_id = model.sensor("torso_gyroscope").id if gyro_sensor_id is None else gyro_sensor_id\n',
)

COLLECT_IDS_FIRST = '''\
def simulate_and_collect(gyro_id, accelerometer, model, data, duration_seconds=5.0):
    """The sensors are parameters here: the function knows no names."""
    n = int(duration_seconds / model.opt.timestep)
    t = (np.arange(n) + 1) * model.opt.timestep
    acceleration = np.full((n, 3), np.nan)
    angular_velocity = np.full((n, 3), np.nan)
    mujoco.mj_resetData(model, data)
    data.qvel[0] = 0.5
    for i in range(n):
        mujoco.mj_step(model, data, nstep=1)
        acceleration[i, :], angular_velocity[i, :] = get_imu_readings(model, data, accelerometer, gyro_id)
    return {"time": t, "acceleration": acceleration, "angular_velocity": angular_velocity, "dt": model.opt.timestep}
'''
MAIN_IDS_FIRST = '''\
if __name__ == "__main__":
    m = mujoco.MjModel.from_xml_path(MODEL_PATH)
    d = mujoco.MjData(m)
    plot_imu_data(simulate_and_collect(m.sensor("torso_gyroscope").id, m.sensor("torso_accelerometer").id, m, d, 3))
'''

COLLECT_NAMES_AS_OPTIONS = '''\
def simulate_and_collect(model, data, duration_seconds=5.0, *, accelerometer="torso_accelerometer",
                         gyroscope="torso_gyroscope", push=0.5, verbose=False):
    """`model.sensor` takes a name as well as an id."""
    accel, gyro = model.sensor(accelerometer).id, model.sensor(gyroscope).id
    n = round(duration_seconds / model.opt.timestep)
    mujoco.mj_resetData(model, data)
    data.qvel[0] = push
    samples = np.zeros((n, 7))
    for row in samples:
        mujoco.mj_step(model, data)
        row[0] = data.time
        row[1:4], row[4:7] = get_imu_readings(model, data, accel, gyro)
    if verbose:
        print("collected", n, "samples")
    return {"time": samples[:, 0], "acceleration": samples[:, 1:4], "angular_velocity": samples[:, 4:7], "samples": n}
'''

# ---------------------------------------------------------------- how it is simulated

COLLECT_FRESH_DATA = '''\
def simulate_and_collect(model, data, duration_seconds=5.0):
    sim = mujoco.MjData(model)      # the caller's data stays as it is
    sim.qvel[0] = 0.5
    n = int(duration_seconds // model.opt.timestep)
    acc, gyr, t = np.zeros((n, 3)), np.zeros((n, 3)), np.zeros(n)
    for i in range(n):
        mujoco.mj_step(model, sim)
        acc[i] = sim.sensor("torso_accelerometer").data
        gyr[i] = sim.sensor("torso_gyroscope").data
        t[i] = sim.time
    return {"time": t, "acceleration": acc, "angular_velocity": gyr}
'''

COLLECT_TWO_HALVES = '''\
def simulate_and_collect(model, data, duration_seconds=5.0):
    accel_id = model.sensor("torso_accelerometer").id
    gyro_id = model.sensor("torso_gyroscope").id
    mujoco.mj_resetData(model, data)
    data.qvel[0] = 0.5
    steps = int(round(duration_seconds / model.opt.timestep))
    history = []
    for step in range(steps):
        mujoco.mj_step1(model, data)      # position and velocity: a controller would act here
        data.ctrl[:] = 0
        mujoco.mj_step2(model, data)      # acceleration, sensors, integration
        history.append((data.time, *get_imu_readings(model, data, accel_id, gyro_id)))
    time, acceleration, angular_velocity = map(np.array, zip(*history))
    return {"time": time, "acceleration": acceleration, "angular_velocity": angular_velocity}
'''

COLLECT_GENERATOR = '''\
def samples(model, data, n):
    """Yields (time, acceleration, angular velocity) after each step."""
    ids = [model.sensor(f"torso_{kind}").id for kind in ("accelerometer", "gyroscope")]
    for _ in range(n):
        mujoco.mj_step(model, data)
        yield (data.time, *get_imu_readings(model, data, *ids))


def simulate_and_collect(model, data, duration_seconds=5.0):
    mujoco.mj_resetData(model, data)
    data.qvel[:] = 0
    data.qvel[0] += 0.5
    mujoco.mj_forward(model, data)
    t, a, w = zip(*samples(model, data, int(duration_seconds / model.opt.timestep)))
    return {"time": np.array(t), "acceleration": np.stack(a), "angular_velocity": np.stack(w)}
'''

COLLECT_LISTS = '''\
def simulate_and_collect(model, data, duration_seconds=5.0):
    imu_data = {"time": [], "acceleration": [], "angular_velocity": []}
    accel_id = model.sensor("torso_accelerometer").id
    gyro_id = model.sensor("torso_gyroscope").id
    mujoco.mj_resetData(model, data)
    data.qvel[0] = 0.5
    for i in range(int(duration_seconds / model.opt.timestep)):
        mujoco.mj_step(model, data)
        acceleration, angular_velocity = get_imu_readings(model, data, accel_id, gyro_id)
        imu_data["time"].append(data.time)
        imu_data["acceleration"].append(acceleration)
        imu_data["angular_velocity"].append(angular_velocity)
    return imu_data
'''
PLOT_LISTS = '''\
def plot_imu_data(imu_data):
    t = imu_data["time"]
    plt.figure(1, figsize=(10, 8))
    plt.clf()
    for panel, (key, label) in enumerate([("acceleration", "Acceleration (m/s^2)"),
                                          ("angular_velocity", "Angular velocity (rad/s)")]):
        plt.subplot(2, 1, panel + 1)
        for k in range(3):
            plt.plot(t, [row[k] for row in imu_data[key]], label="xyz"[k])
        plt.xlabel("Time (s)")
        plt.ylabel(label)
        plt.title(label.split(" (")[0] + " of the torso")
        plt.legend()
    plt.savefig("imu_data.png")
    plt.close()
'''

COLLECT_THREAD = '''\
import queue
import threading


def _simulate(model, data, n, out):
    for _ in range(n):
        mujoco.mj_step(model, data)
        out.put((data.time, data.sensor("torso_accelerometer").data.copy(), data.sensor("torso_gyroscope").data.copy()))
    out.put(None)


def simulate_and_collect(model, data, duration_seconds=5.0):
    """A thread simulates, this one collects."""
    mujoco.mj_resetData(model, data)
    data.qvel[0] = 0.5
    out = queue.Queue()
    worker = threading.Thread(target=_simulate, args=(model, data, int(duration_seconds / model.opt.timestep), out))
    worker.start()
    rows = list(iter(out.get, None))
    worker.join()
    t, acc, gyro = (np.array(part) for part in zip(*rows))
    return {"time": t, "acceleration": acc, "angular_velocity": gyro}
'''

COLLECT_REAL_TIME = '''\
import time as clock


def simulate_and_collect(model, data, duration_seconds=5.0, realtime=True):
    """Keeps pace with the wall clock, so that a viewer beside it looks right."""
    accel_id = model.sensor("torso_accelerometer").id
    gyro_id = model.sensor("torso_gyroscope").id
    n = int(duration_seconds / model.opt.timestep)
    t, a, w = np.zeros(n), np.zeros((n, 3)), np.zeros((n, 3))
    mujoco.mj_resetData(model, data)
    data.qvel[0] = 0.5
    started = clock.time()
    for i in range(n):
        mujoco.mj_step(model, data)
        t[i] = data.time
        a[i], w[i] = get_imu_readings(model, data, accel_id, gyro_id)
        ahead = data.time - (clock.time() - started)
        if realtime and ahead > 0:
            clock.sleep(ahead)
        if i % 500 == 0:
            print(f"\\r{100 * i // n} %", end="", flush=True)
    print("\\rdone ")
    return {"time": t, "acceleration": a, "angular_velocity": w}
'''
