import math


class ComplementaryFilter:
    def __init__(self, dt, alpha=0.98):
        self.dt = dt
        self.alpha = alpha
        self.roll = 0.0
        self.pitch = 0.0

    def update(self, accel, gyro):
        ax, ay, az = accel
        accel_roll = math.atan2(-ay, -az)
        accel_pitch = math.atan2(ax, math.hypot(ay, az))
        self.roll = (1 - self.alpha) * (self.roll + gyro[0] * self.dt) + self.alpha * accel_roll
        self.pitch = (1 - self.alpha) * (self.pitch + gyro[1] * self.dt) + self.alpha * accel_pitch
        return self.roll, self.pitch
