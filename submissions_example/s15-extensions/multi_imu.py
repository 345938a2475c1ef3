import mujoco


def read_all_imus(model, data):
    names = [mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_SENSOR, i) for i in range(model.nsensor)]
    readings = {}
    for name in names:
        if name and name.endswith("_accelerometer"):
            place = name[:-len("_accelerometer")]
            if place + "_gyroscope" in names:
                accel = data.sensor(name).data.copy()
                gyro = data.sensor(place + "_gyroscope").data.copy()
                readings[place] = (accel, gyro)
    return readings
