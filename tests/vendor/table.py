"""The vendor's table of 2019-04-30 (hardware 2019-03-31), typed by hand, row by row, from the Chinese original.

It imports nothing, so that a mistake in the product's catalogue cannot hide here. The literal frames are in `frames`.
"""

CODES = {
    "heartbeat": 0x01,  # 正常心跳包
    "activation": 0x10,  # 伞降激活/锁定
    "deploy": 0x11,  # 串口触发开伞
    "shutdown": 0x12,  # 伞降关机
    "serial_output": 0x13,  # 允许/禁止串口输出
    "light": 0x14,  # 查询当前光线值
    "light_threshold": 0x15,  # 设置光线阈值
    "attitude_trigger": 0x16,  # 禁止/使能姿态触发
    "freefall_trigger": 0x17,  # 禁止/使能失重触发
    "attitude_threshold": 0x20,  # 姿态开伞阈值
    "freefall_acceleration": 0x21,  # 失重加速度阈值
    "freefall_time": 0x22,  # 失重时间
    "boot_count": 0x23,  # 开机次数
    "baud_rate": 0x24,  # 波特率
    "zero_sensor": 0x25,  # 传感器置零
    "active": 0x30,  # 查询模块是否激活
    "triggered": 0x31,  # 开伞状态
    "status": 0x32,  # 降落伞状态
    "charging": 0x33,  # 充电状态
    "cell_voltage": 0x34,  # 电芯电压
    "trigger_records": 0x35,  # 触发记录
}

QUERIES = {
    "heartbeat": "42 61 01 a5 5a 00",
    "light": "42 61 14 01 01 16",  # the only one with D4 = 01
    "light_threshold": "42 61 15 01 00 16",
    "attitude_threshold": "42 61 20 01 00 21",
    "freefall_acceleration": "42 61 21 01 00 22",
    "freefall_time": "42 61 22 01 00 23",
    "boot_count": "42 61 23 01 00 24",
    "zero_sensor": "42 61 25 01 00 26",  # an act in the form of a query
    "active": "42 61 30 01 00 31",
    "triggered": "42 61 31 01 00 32",
    "status": "42 61 32 01 00 33",
    "charging": "42 61 33 01 00 34",
    "cell_voltage": "42 61 34 01 00 35",
    "trigger_records": "42 61 35 01 00 36",
}
"""What has no entry cannot be asked."""

SETS = (
    ("activation", True, "42 61 10 02 01 13"),
    ("activation", False, "42 61 10 02 00 12"),
    ("deploy", True, "42 61 11 02 01 14"),
    ("deploy", False, "42 61 11 02 00 13"),
    ("shutdown", True, "42 61 12 02 01 15"),
    ("serial_output", True, "42 61 13 02 01 16"),
    ("serial_output", False, "42 61 13 02 00 15"),
    ("light_threshold", 1.8, "42 61 15 02 12 29"),
    ("attitude_trigger", False, "42 61 16 02 01 19"),  # 0x01关闭 (off), 0x00开启 (on)
    ("attitude_trigger", True, "42 61 16 02 00 18"),
    ("freefall_trigger", False, "42 61 17 02 01 1a"),
    ("freefall_trigger", True, "42 61 17 02 00 19"),
    ("attitude_threshold", 60, "42 61 20 02 3c 5e"),
    ("freefall_acceleration", 0.5, "42 61 21 02 05 28"),
    ("freefall_time", 1.6, "42 61 22 02 a0 c4"),
    ("baud_rate", 4800, "42 61 24 02 01 27"),  # the table prints the last of the six, and lists all codes
    ("baud_rate", 9600, "42 61 24 02 02 28"),
    ("baud_rate", 19200, "42 61 24 02 03 29"),
    ("baud_rate", 38400, "42 61 24 02 04 2a"),
    ("baud_rate", 57600, "42 61 24 02 05 2b"),
    ("baud_rate", 115200, "42 61 24 02 06 2c"),
)
"""Every set that the table knows, with the value in its unit."""

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

CELL_VOLTAGES = {0xBE: 3.8, 0xC8: 4.0, 0xD2: 4.2}
BAUD_CODES = {1: 4800, 2: 9600, 3: 19200, 4: 38400, 5: 57600, 6: 115200}

YES = {
    "activation": 0x01,
    "deploy": 0x01,
    "serial_output": 0x01,
    "attitude_trigger": 0x00,  # enabled is 00
    "freefall_trigger": 0x00,
    "active": 0x01,
    "triggered": 0x01,
    "charging": 0x01,
}
"""The byte that means yes, on, enabled. For 30 and 31 anything else means no."""

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
