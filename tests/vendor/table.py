"""The vendor's table of 2019-04-30 (hardware 2019-03-31), typed by hand, row by row, from the Chinese original.

It imports nothing, so that a mistake in the product's catalogue cannot hide here. What the printed frames say, codes
and the byte of each yes and no among it, is in `frames`.
"""

STEPS = {
    "light": 10,  # 该值=电压值/0.1
    "light_threshold": 10,
    "attitude_threshold": 1,  # degrees
    "freefall_acceleration": 10,  # 值为加速度值乘以10
    "freefall_time": 100,  # 单位为0.01s
    "boot_count": 1,
    "cell_voltage": 50,  # 0.02V的倍数
}
"""What D4 is divided by to give V, °, g, s or a count."""

BAUD_CODES = {1: 4800, 2: 9600, 3: 19200, 4: 38400, 5: 57600, 6: 115200}

DEFAULTS = {
    "attitude_trigger": 0x00,  # 默认开启
    "freefall_trigger": 0x00,
    "attitude_threshold": 60,  # 默认60°
    "freefall_acceleration": 5,  # 默认0.5g
    "freefall_time": 160,  # 默认时间阈值1.6秒
    "baud_rate": 6,  # 默认115200
}
"""D4 as delivered."""

LOWEST_ADVISED_ATTITUDE_DEG = 55  # 建议设置成55°以上
ACCELERATION_ADVISED_BELOW_G = 0.7  # 建议小于0.7g
RESET_BELOW_THRESHOLD_DEG = 10  # 复位角度=姿态阈值角度减10°
RECORDS_KEPT = 9  # 记录最近的9次触发记录

STATUS_BYTES = {"tilt_deg": 3, "acceleration_g": 4, "triggered": 5, "active": 6}
"""Where each value stands in the eight bytes; the header is D0 and D1. Acceleration is in 0.1 g, 01 is yes."""
STATUS_LENGTH = 8

RECORD_BYTES = {
    "boot_count": 4,
    "uptime_s": 5,  # and 6, the high byte first; seconds
    "sources": 7,
    "attitude_threshold_deg": 8,
    "freefall_acceleration_g": 9,
    "freefall_time_s": 10,
    "serial_connected": 11,  # 0x00:串口连接正常
    "charging": 12,  # 0x00:设备连接正常在充电, the other way round than the answer to 33
    "light_v": 13,
    "cell_voltage_v": 14,
}
"""Where each value stands in the sixteen bytes."""
RECORD_LENGTH = 16
RECORD_STEPS = {
    "boot_count": 1,
    "attitude_threshold_deg": 1,
    "freefall_acceleration_g": 10,
    "freefall_time_s": 100,
    "light_v": 10,
    "cell_voltage_v": 50,
}
RECORD_YES = {"serial_connected": 0x00, "charging": 0x00}
SOURCES = {0x01: "serial", 0x02: "attitude", 0x04: "pwm", 0x08: "freefall"}  # 串口触发 姿态触发 PWM触发 失重触发
