<?xml version="1.0" encoding="utf-8"?>
<!DOCTYPE TS>
<TS version="2.1" language="zh_CN" sourcelanguage="en">
<context>
    <name>dps-s</name>
    <message>
        <source> or </source>
        <translation>或</translation>
    </message>
    <message>
        <source>(!) no lithium cell has this voltage without external power; it is shown as it came.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>00 external power, charging; 01 not</source>
        <translation>00 外接供电，充电中；01 未充电</translation>
    </message>
    <message>
        <source>00 serial link connected, 01 not</source>
        <translation>00 串口已连接，01 未连接</translation>
    </message>
    <message>
        <source>01</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>01 active, 00 not</source>
        <translation>01 已激活，00 未激活</translation>
    </message>
    <message>
        <source>01 is active; anything else is not.</source>
        <translation>01 为已激活；其他值为未激活。</translation>
    </message>
    <message>
        <source>01 is triggered; anything else is not.</source>
        <translation>01 为已触发；其他值为未触发。</translation>
    </message>
    <message>
        <source>01 triggered, 00 not</source>
        <translation>01 已触发，00 未触发</translation>
    </message>
    <message>
        <source>10 min</source>
        <translation>10 分</translation>
    </message>
    <message>
        <source>10 s</source>
        <translation>10 秒</translation>
    </message>
    <message>
        <source>115200 (usual)</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>55° or more.</source>
        <translation>55° 或以上。</translation>
    </message>
    <message>
        <source>60 s</source>
        <translation>60 秒</translation>
    </message>
    <message>
        <source>A module answers on {port} at {rate} baud.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>A port that is not in the list</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>A simulated module, written from the vendor's table. Prints the port to open as its first line and runs until it is stopped (Ctrl-C). The same options go into the query of sim://NAME?option=value.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>ACTIVE</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>About</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Acceleration</source>
        <translation>加速度</translation>
    </message>
    <message>
        <source>Activate / lock</source>
        <translation>激活/锁定</translation>
    </message>
    <message>
        <source>Activation</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Active</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Active?</source>
        <translation>是否激活</translation>
    </message>
    <message>
        <source>After power-on</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>All frames</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>An active module fires by its thresholds; a locked one is in standby and does not fire.</source>
        <translation>激活的模块按阈值触发开伞；锁定的模块处于待机状态，不会触发。</translation>
    </message>
    <message>
        <source>Angle between aircraft and horizontal plane at which it fires; it resets 10° below.</source>
        <translation>触发开伞时飞行器与水平面的夹角；低于该值 10° 时复位。</translation>
    </message>
    <message>
        <source>As the system</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Ask the administrator of this computer for access to serial ports.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Asking …</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Attitude</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Attitude threshold</source>
        <translation>姿态开伞阈值</translation>
    </message>
    <message>
        <source>Attitude trigger</source>
        <translation>姿态触发</translation>
    </message>
    <message>
        <source>Back to live</source>
        <translation>回到实时</translation>
    </message>
    <message>
        <source>Baud rate</source>
        <translation>波特率</translation>
    </message>
    <message>
        <source>Below 0.7 g.</source>
        <translation>低于 0.7 g。</translation>
    </message>
    <message>
        <source>Below this acceleration the module counts itself as falling.</source>
        <translation>加速度低于此值时，模块认为处于失重状态。</translation>
    </message>
    <message>
        <source>Boot</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Boot count</source>
        <translation>开机次数</translation>
    </message>
    <message>
        <source>Bytes</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Cell</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Cell voltage</source>
        <translation>电芯电压</translation>
    </message>
    <message>
        <source>Cell voltage and charge</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Change settings: {names} (true or false). What cannot be read back is only ever acknowledged, never verified. Exit code 1 where the module did not acknowledge.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Charging</source>
        <translation>充电状态</translation>
    </message>
    <message>
        <source>Check its power and the cable; it is asked again every 2 s.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Check that it is switched on and that TX and RX are crossed; if so, find the rate (dps-s find).</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Check that it is switched on, that TX and RX are crossed, and that ground is connected.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Check the cable, plug the adapter in again and connect.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Check the wire from the adapter's TX to the module's RX.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Check the wiring: TX and RX touch each other, or the module is not connected.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Choose a port</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Choose a port, connect or disconnect (Ctrl+K)</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Choose a row to see all of its bytes.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Choose another port from the list (dps-s ports).</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Choose the port that the module is plugged into.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Clamps what is set</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Clear</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Clear the list</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Close</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Close that program and connect again.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Close the port (Ctrl+D)</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Close this message</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Close this sheet (Esc)</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Close {program} and connect again.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Close, leave it ACTIVE</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Closed</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Configure, test and watch a DPS-S drone parachute module over its serial port.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Configures, tests and watches a DPS-S parachute module over its serial port.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Connect</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Connect again</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Connect again.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Connect again; if it comes back, send us the log.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Connected</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Copy</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Copy the selected rows</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Copy the selected rows, or all of them when none is selected (Ctrl+C)</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>DPS-S Configurator</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>DPS-S Configurator {version}</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Dark</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Decides when the parachute counts as having left the bay.</source>
        <translation>用于判断降落伞是否已出仓。</translation>
    </message>
    <message>
        <source>Delay</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Deploy over serial</source>
        <translation>串口触发开伞</translation>
    </message>
    <message>
        <source>Direction of faults</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Disconnect</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Disconnect, leave it ACTIVE</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Do not change it.</source>
        <translation>不要更改。</translation>
    </message>
    <message>
        <source>Doubled answers</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Drag or arrow keys move, wheel or + and − zoom, Shift with arrow keys reads off, Space pauses</source>
        <translation>拖动或方向键平移，滚轮或 + / − 缩放，Shift 加方向键读数，空格键暂停</translation>
    </message>
    <message>
        <source>Drop {height} m</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>E11: light the other way round</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>E11: more light reads lower</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>E12: records carry 4.70 V, as the worked example does</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>E12: records with 4.70 V</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>E15: activation, trigger flags and serial output survive a restart</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>E15: remembers its state</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>E2: a set of 21, 22 or 24 is acknowledged by the value or by 01</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>E2: acknowledges by</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>E3: code of the answer to the cell voltage, 34</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>E3: voltage code</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>E4: code for 17</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>E4: code of the acknowledgement of 17</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>E6: pause between records or pieces</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>E6: records</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>E6: records come in one go, one by one, or cut into pieces of seven bytes</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>E7: empty slots</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>E7: slots never used are left out, sent as 00, or sent as FF</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>E9: a new rate is acknowledged at the old rate, at the new, or begins at a restart</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>E9: new baud rate</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Echo of the host's bytes</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>End all faults</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Examples:</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Explain captured bytes. What was asked is taken from the host's frames in the capture, else from --asked; with neither, a whole trigger record of 16 bytes wins over a reply of six.</source>
        <translation>解释捕获的字节。所查询的内容取自捕获中上位机的帧，否则取自 --asked；两者皆无时，完整的 16 字节触发记录优先于 6 字节答复。</translation>
    </message>
    <message>
        <source>Figures of the link</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Find the baud rate at which a module answers. Sends nothing but heartbeats, first at the rate of --baud. Exit code 3 where none answers.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Find the rate</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Fires the parachute. 00 forbids it; for how long, the vendor does not say.</source>
        <translation>触发开伞。00 为禁止触发；禁止多久，厂家未说明。</translation>
    </message>
    <message>
        <source>Forget all rows (Ctrl+Shift+X)</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Frames a second, usual round trip, bytes that were no frame</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Frames sent and received</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Free fall</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Free-fall acceleration threshold</source>
        <translation>失重加速度阈值</translation>
    </message>
    <message>
        <source>Free-fall time</source>
        <translation>失重时间</translation>
    </message>
    <message>
        <source>Free-fall trigger</source>
        <translation>失重触发</translation>
    </message>
    <message>
        <source>Garbage</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Go on</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Heartbeat</source>
        <translation>心跳</translation>
    </message>
    <message>
        <source>Hold the list still; frames go on being recorded (Ctrl+P)</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Hold the picture still; recording goes on (Space)</source>
        <translation>画面静止，记录继续（空格键）</translation>
    </message>
    <message>
        <source>How long a fall must last before it fires. Longer avoids false triggers, costs height.</source>
        <translation>失重持续多久才触发开伞。时间越长越能防止误触发，但会损失开伞高度。</translation>
    </message>
    <message>
        <source>How often the module was switched on; 0 follows 255.</source>
        <translation>模块的开机次数；255 之后归零。</translation>
    </message>
    <message>
        <source>If it does not, try another cable.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Jitter</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Keeps what is set</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Kind</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>LOCK</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>LOCK again</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>LOCK and close</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>LOCK and disconnect</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>LOCK was sent, and the module still says ACTIVE.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>LOCK was sent, but the module does not say that it is locked. Treat it as ACTIVE.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>LOCK: put the module into standby</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>LOCKED</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>LOCKED: the module says so.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Length of the time line: {length}</source>
        <translation>时间轴长度：{length}</translation>
    </message>
    <message>
        <source>Let it fall from this height. Active, it fires by free fall.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Light</source>
        <translation>光线</translation>
    </message>
    <message>
        <source>Light threshold</source>
        <translation>光线阈值</translation>
    </message>
    <message>
        <source>Lines on standard input while it runs:</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>List the serial ports, USB first. Opens none of them.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Live</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Locking …</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Looking for ports …</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Looking for the baud rate at which a module answers.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Lost answers</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Lost bytes</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Maker</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Meaning</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Message</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Message: {text}</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Module on {port}, {rate} baud</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Module on {port}, {rate} baud, answers in {milliseconds:.1f} ms</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Most likely the module has another baud rate: find it (dps-s find, or --baud auto).</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Mute</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>NOT TRIGGERED</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Name</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>No answer</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>No module</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>No module answers on {port} at any baud rate.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>No module answers on {port} at {rate} baud.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>No port is open.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>No records came.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>No rows yet</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>No serial port found. Plug the adapter in: it appears here by itself.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>No simulated module is connected.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>No two readings agreed: records may be missing. Read again.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Not connected</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Not had: {names}. Read again; if it stays so, check the wiring.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Not opened</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Nothing to decode: give the bytes in hex, or - to read them from standard input.</source>
        <translation>没有可解码的内容：请给出十六进制字节，或用 - 从标准输入读取。</translation>
    </message>
    <message>
        <source>Nothing to plug in; behaves as the vendor's table says</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Now</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Offline</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Offline for {time}</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Only an echo</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Only our own bytes come back on {port}.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Only rejected bytes</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Open the chosen port (Enter)</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Open the window.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Opening …</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Other port</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Pages</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Pause</source>
        <translation>暂停</translation>
    </message>
    <message>
        <source>Pause the list</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Plots</source>
        <translation>曲线</translation>
    </message>
    <message>
        <source>Plots over time</source>
        <translation>随时间变化的曲线</translation>
    </message>
    <message>
        <source>Plug in</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Plug the adapter in and choose it from the list (dps-s ports).</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Plug the same adapter in again: it is connected by itself.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Port</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Port lost</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Port {port}: {state}</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Ports</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Print the status as it streams, or polled where the module does not stream, until Ctrl-C. The stream is switched on where it was off, and off again at the end. Times count from the first status.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Proves that the module is there. It sends two by itself, 50 ms apart, after power-up.</source>
        <translation>证明模块在线。模块上电后自行发送两次，间隔 50 ms。</translation>
    </message>
    <message>
        <source>Put the module into standby: it no longer fires by itself (Ctrl+L)</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Read everything that can be read. What cannot be had is shown as unknown; exit code 4 then.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Read the trigger records, as often as it takes until two readings agree. Exit code 4 when they do not.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Reading of the light sensor in the parachute bay: tells whether the bay is open.</source>
        <translation>伞仓内光线传感器的读数：用于判断伞仓是否打开。</translation>
    </message>
    <message>
        <source>Reading the trigger records</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Reading: {what}</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Refuses what is set</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Serial</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Serial number</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Serial output</source>
        <translation>串口输出</translation>
    </message>
    <message>
        <source>Set it to the reading with the bay fully open.</source>
        <translation>设置为伞仓完全打开时的读数。</translation>
    </message>
    <message>
        <source>Settings</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Show the newest samples again (End, or a double click on the plots)</source>
        <translation>重新显示最新数据（End 键，或双击曲线）</translation>
    </message>
    <message>
        <source>Show the time of day instead of seconds before now</source>
        <translation>显示时刻，而不是距现在的秒数</translation>
    </message>
    <message>
        <source>Shut down</source>
        <translation>关机</translation>
    </message>
    <message>
        <source>Shut down. It comes back by its switch or by external power.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Simulated module</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Something sends on {port}, but no frame can be read at {rate} baud.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Source</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Speed of the serial line. The vendor advises not to change it.</source>
        <translation>串口通讯速率。厂家建议不要更改。</translation>
    </message>
    <message>
        <source>Split, pause</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Standard input is not text; decode reads bytes written in hex, such as 41 75 32.</source>
        <translation>标准输入不是文本；decode 读取以十六进制书写的字节，例如 41 75 32。</translation>
    </message>
    <message>
        <source>State of the simulated module</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Status</source>
        <translation>状态</translation>
    </message>
    <message>
        <source>Stay</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Stream rate</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Streams</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Sunlight</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Switched on, the module streams its status unasked. Its state cannot be read.</source>
        <translation>开启后模块主动实时输出状态。此开关的状态无法读取。</translation>
    </message>
    <message>
        <source>Switches the module off. It comes back by its switch, held 2 s, or by external power.</source>
        <translation>模块关机。长按开关 2 秒或接通外接供电即可再次开机。</translation>
    </message>
    <message>
        <source>TRIGGERED</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Takes today's mounting as level. For small mounting errors only.</source>
        <translation>将当前安装方式作为水平面。仅用于修正小角度安装误差。</translation>
    </message>
    <message>
        <source>The last nine triggers, each with the settings and readings of its moment.</source>
        <translation>最近九次触发，每条含触发时的设置和读数。</translation>
    </message>
    <message>
        <source>The module answers.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>The module is ACTIVE: it fires by its thresholds, with or without this program.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>The module keeps no trigger records.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>The module no longer answers.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>The module on {port} answers, but reports no status.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>The module on {port} sends, but does not answer.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>The module on {port} stopped answering. Check its power and the wiring, and read again.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>The module on {port} stopped answering. Check its power and the wiring.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>The module was ACTIVE when it was last heard: treat it as ready to fire.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>The module's baud rate; 115200 unless somebody changed it</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>The port closed while locking. Treat the module as ACTIVE.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>The port is being opened.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>The port is open, the module is being asked.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>The port was closed by a fault of this program.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>The port went away.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>The program met an error that it did not expect: {error}.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>The selected row in full</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>The system did not list its serial ports in time. Switch Bluetooth off and try again.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>There is no port {port}.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>There is no serial port. Plug the adapter in; if it stays away, try another cable or its driver.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Tilt</source>
        <translation>倾角</translation>
    </message>
    <message>
        <source>Tilt, acceleration, trigger and activation in one report; also what is streamed.</source>
        <translation>一次报告倾角、加速度、触发状态和激活状态；实时输出的内容与此相同。</translation>
    </message>
    <message>
        <source>Time</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Time of day</source>
        <translation>时刻</translation>
    </message>
    <message>
        <source>Time since the last frame</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Traffic</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Trigger</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Trigger records</source>
        <translation>触发记录</translation>
    </message>
    <message>
        <source>Triggered</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Triggered?</source>
        <translation>开伞状态</translation>
    </message>
    <message>
        <source>Trying {rate} baud</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Trying {rate} baud …</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Turned bits</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Type: sudo usermod -aG dialout $USER — then log out and in again.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Unplug</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Unplug the adapter, plug it in again and connect.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Unplug the adapter, plug it in again and try again.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Unplugged</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Voltage of the module's cell; with external power connected it is the charging voltage.</source>
        <translation>模块的电芯电压；接有外接供电时为充电电压。</translation>
    </message>
    <message>
        <source>What was read cannot be written: {error}.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Whether external power is charging the module.</source>
        <translation>外接供电是否正在为模块充电。</translation>
    </message>
    <message>
        <source>Whether the module fires by itself in free fall. Its state cannot be read.</source>
        <translation>模块失重时是否自动触发开伞。此开关的状态无法读取。</translation>
    </message>
    <message>
        <source>Whether the module fires by itself when it tips over. Its state cannot be read.</source>
        <translation>模块倾翻时是否自动触发开伞。此开关的状态无法读取。</translation>
    </message>
    <message>
        <source>Which rows to show</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Windows has no pseudo-terminals: use --tcp 127.0.0.1:0</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Without a command the window opens. Exit code: 0 done; 1 done and the answer is no; 2 used wrongly; 3 no link (no such port, busy, no permission, no answer); 4 some of it could not be had; 130 or 143 interrupted before there was a result.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Without the stream</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Wrong rate?</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>You may not open {port}.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Zero the sensor</source>
        <translation>传感器置零</translation>
    </message>
    <message>
        <source>a TCP socket instead; port 0 picks one</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>a TCP socket, on every platform: prints socket://127.0.0.1:…</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>a bad line, the same each time</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>a device name (see dps-s ports), a pseudo-terminal or a URL: socket://HOST:PORT, sim://</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>a heartbeat was not answered: offline</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>a height from 0 to 10000 m is needed</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>a number from {least} to {most} is needed</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>a simulated module; prints the port to open</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>a whole number from {least} to {most} is needed</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>acceleration, 0.1 g</source>
        <translation>加速度，0.1 g</translation>
    </message>
    <message>
        <source>acknowledged at the new rate</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>acknowledged at the old rate</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>acknowledged only</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>acknowledged: {name}, value not repeated</source>
        <translation>已确认：{name}，未回显数值</translation>
    </message>
    <message>
        <source>acknowledged: {what}</source>
        <translation>已确认：{what}</translation>
    </message>
    <message>
        <source>activate or lock it without the protocol</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>activate the module</source>
        <translation>激活模块</translation>
    </message>
    <message>
        <source>activation flag {value}, expected 00 or 01</source>
        <translation>激活标志为 {value}，应为 00 或 01</translation>
    </message>
    <message>
        <source>active</source>
        <translation>已激活</translation>
    </message>
    <message>
        <source>active: tilt 70 on standard input makes it fire</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>also as {path}</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>always the same path, and the quickest stream</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>angle against the horizontal plane, in degrees</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>answer</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>answers come in up to three pieces with this pause between them</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>attitude</source>
        <translation>姿态</translation>
    </message>
    <message>
        <source>attitude threshold then, 1°</source>
        <translation>触发时的姿态开伞阈值，1°</translation>
    </message>
    <message>
        <source>attitude trigger disabled</source>
        <translation>姿态触发已禁用</translation>
    </message>
    <message>
        <source>attitude trigger enabled</source>
        <translation>姿态触发已启用</translation>
    </message>
    <message>
        <source>baud rate of the module</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>baud rate, default 115200</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>baud rate: {rates}, or auto to try them all; default 115200</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>begin active instead of locked: it fires by its own thresholds</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>begins at a restart</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>boot count at the trigger</source>
        <translation>触发时的开机次数</translation>
    </message>
    <message>
        <source>boot count, 0 to 255</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>boot {count}</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>both ways</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>built in, or without a description</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>bytes in hex; - reads hex text from standard input</source>
        <translation>十六进制字节；- 表示从标准输入读取十六进制文本</translation>
    </message>
    <message>
        <source>cell voltage</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>cell voltage, 0.02 V</source>
        <translation>电芯电压，0.02 V</translation>
    </message>
    <message>
        <source>change a setting</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>change the dialect or the rate</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>charging</source>
        <translation>充电中</translation>
    </message>
    <message>
        <source>charging flag {value}, expected 00 or 01</source>
        <translation>充电状态标志为 {value}，应为 00 或 01</translation>
    </message>
    <message>
        <source>checksum {found}, the sum is {expected}</source>
        <translation>校验为 {found}，累加和应为 {expected}</translation>
    </message>
    <message>
        <source>codes in hexadecimal are needed, such as 14,33</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>commands</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>commands that it does not know, such as 14,33</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>connect to a built-in simulated module</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>connect to this port at once</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>connected</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>control byte {control} does not go with command {code}</source>
        <translation>控制字符 {control} 不适用于命令 {code}</translation>
    </message>
    <message>
        <source>control byte {control}, expected 01</source>
        <translation>控制字符为 {control}，应为 01</translation>
    </message>
    <message>
        <source>cut its power</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>delay of every answer</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>deploy the parachute</source>
        <translation>触发开伞</translation>
    </message>
    <message>
        <source>deploying over serial forbidden</source>
        <translation>已禁止串口触发开伞</translation>
    </message>
    <message>
        <source>device, pseudo-terminal or socket://host:port</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>dialect: where the vendor's table leaves it open</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>disable the attitude trigger</source>
        <translation>禁用姿态触发</translation>
    </message>
    <message>
        <source>disable the free-fall trigger</source>
        <translation>禁用失重触发</translation>
    </message>
    <message>
        <source>done</source>
        <translation>已完成</translation>
    </message>
    <message>
        <source>done: {line}</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>doubled</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>dps-s COMMAND --help tells more.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>echo</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>enable the attitude trigger</source>
        <translation>启用姿态触发</translation>
    </message>
    <message>
        <source>enable the free-fall trigger</source>
        <translation>启用失重触发</translation>
    </message>
    <message>
        <source>end S seconds after the first status</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>explain captured bytes</source>
        <translation>解释捕获的字节</translation>
    </message>
    <message>
        <source>external power is connected</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>faults of the line</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>find the baud rate at which a module answers</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>for example serial_output=false</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>forbid deploying over serial</source>
        <translation>禁止串口触发开伞</translation>
    </message>
    <message>
        <source>forces settings into the vendor's advice and acknowledges what it kept</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>free fall</source>
        <translation>失重</translation>
    </message>
    <message>
        <source>free-fall acceleration threshold then, 0.1 g</source>
        <translation>触发时的失重加速度阈值，0.1 g</translation>
    </message>
    <message>
        <source>free-fall time then, 0.01 s</source>
        <translation>触发时的失重时间，0.01 s</translation>
    </message>
    <message>
        <source>free-fall trigger disabled</source>
        <translation>失重触发已禁用</translation>
    </message>
    <message>
        <source>free-fall trigger enabled</source>
        <translation>失重触发已启用</translation>
    </message>
    <message>
        <source>heartbeat</source>
        <translation>心跳</translation>
    </message>
    <message>
        <source>heartbeat carries {found}, expected A5 5A</source>
        <translation>心跳内容为 {found}，应为 A5 5A</translation>
    </message>
    <message>
        <source>hold its switch for 2 s: on, if it was off</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>host</source>
        <translation>上位机</translation>
    </message>
    <message>
        <source>how it is now</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>how it is reached</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>in one go</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>in pieces</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>it does not fire: it is locked, forbidden or off</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>it wobbles a few degrees, as in the wind</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>keeps the old setting and acknowledges that</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>language of the window: {names}</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>late</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>lay it at this angle</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>left out</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>let it fall, from 20 m unless told</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>light at the trigger, 0.1 V</source>
        <translation>触发时的光线，0.1 V</translation>
    </message>
    <message>
        <source>limit {value}</source>
        <translation>限值 {value}</translation>
    </message>
    <message>
        <source>link</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>list the serial ports</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>live</source>
        <translation>实时</translation>
    </message>
    <message>
        <source>lock the module</source>
        <translation>锁定模块</translation>
    </message>
    <message>
        <source>locked</source>
        <translation>已锁定</translation>
    </message>
    <message>
        <source>module</source>
        <translation>模块</translation>
    </message>
    <message>
        <source>module active</source>
        <translation>模块已激活</translation>
    </message>
    <message>
        <source>module locked</source>
        <translation>模块已锁定</translation>
    </message>
    <message>
        <source>module shuts down</source>
        <translation>模块即将关机</translation>
    </message>
    <message>
        <source>new</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>nine records, in awkward pieces</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>no</source>
        <translation>否</translation>
    </message>
    <message>
        <source>no answer within {seconds:.2f} s, asked {n} times</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>no data</source>
        <translation>无数据</translation>
    </message>
    <message>
        <source>no frame header</source>
        <translation>没有帧头</translation>
    </message>
    <message>
        <source>no frame: {why}</source>
        <translation>不是有效帧：{why}</translation>
    </message>
    <message>
        <source>no port for the simulated module: {reason}</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>no reply within {seconds:.1f} s, asked once</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>no reply within {seconds:.1f} s, asked {attempts} times</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>no reply within {seconds:.1f} s; it may have been carried out</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>no serial number</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>no such command: {codes}</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>no: acknowledges settings and does not keep them</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>no: bytes take no time on the line</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>no: locked, in standby</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>noise of the sensors: 0 none, 1 usual</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>not acknowledged: {name}, the answer is {raw:02X}</source>
        <translation>未确认：{name}，答复为 {raw:02X}</translation>
    </message>
    <message>
        <source>not active</source>
        <translation>未激活</translation>
    </message>
    <message>
        <source>not answered</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>not asked: the module stopped answering</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>not charging</source>
        <translation>未充电</translation>
    </message>
    <message>
        <source>not connected</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>not read: the module restarted again and again</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>not read: the port was lost</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>not sent: the module did not answer the heartbeat before it</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>not sent: the module stopped answering</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>not triggered</source>
        <translation>未触发</translation>
    </message>
    <message>
        <source>nothing that the module sends comes through</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>now</source>
        <translation>现在</translation>
    </message>
    <message>
        <source>off</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>on: it streams</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>one bit each: 01 serial, 02 attitude, 04 PWM, 08 free fall</source>
        <translation>每位一个来源：01 串口，02 姿态，04 PWM，08 失重</translation>
    </message>
    <message>
        <source>one by one</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>one of {rates} is needed</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>one of {values} is needed</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>only these can be changed: {names}</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>open or close the parachute bay</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>open the window</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>parachute deployed</source>
        <translation>已开伞</translation>
    </message>
    <message>
        <source>paused, {seconds} s behind</source>
        <translation>已暂停，落后 {seconds} 秒</translation>
    </message>
    <message>
        <source>physical side</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>plug or unplug external power</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>plug the serial adapter in again</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>plugged in again: {address}</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>polled</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>print JSON and nothing else on standard output</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>print the status as it comes</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>print the version</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>prints the port to open, for example /dev/pts/5</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>pull the serial adapter, for good or for some seconds</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>query: {name}</source>
        <translation>查询：{name}</translation>
    </message>
    <message>
        <source>read everything that can be read</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>read the trigger records</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>records: {count}</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>rejected</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>reply: {name}, a value or only “received”</source>
        <translation>答复：{name}，是数值或仅表示“已收到”</translation>
    </message>
    <message>
        <source>reply: {what}</source>
        <translation>答复：{what}</translation>
    </message>
    <message>
        <source>run a simulated module</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>run the window for S seconds, then end it</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>seconds since it was switched on; 0 lets the two heartbeats be seen</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>seconds since power-on, high byte first</source>
        <translation>开机后的秒数，高位在前</translation>
    </message>
    <message>
        <source>seed of faults, noise and history: the same seed, the same run</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>sensor zeroed</source>
        <translation>传感器已置零</translation>
    </message>
    <message>
        <source>sent</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>sent as 00</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>sent as FF</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>sent, not confirmed within {seconds:.2f} s: it may have been carried out</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>sent, {n}.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>serial</source>
        <translation>串口</translation>
    </message>
    <message>
        <source>serial link flag {value}, expected 00 or 01</source>
        <translation>串口状态标志为 {value}，应为 00 或 01</translation>
    </message>
    <message>
        <source>serial number {number}</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>serial output is on after every start</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>serial output off</source>
        <translation>串口输出已关闭</translation>
    </message>
    <message>
        <source>serial output on</source>
        <translation>串口输出已开启</translation>
    </message>
    <message>
        <source>serial output streams, is acknowledged without streaming, or is not answered</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>set the cell voltage</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>set {name} to {value}</source>
        <translation>将{name}设置为 {value}</translation>
    </message>
    <message>
        <source>share of answers that come twice</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>share of answers with random bytes before them</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>share of bytes with one bit turned</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>share of single bytes that vanish</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>share of whole requests and answers that vanish, 0 to 1</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>shut the module down</source>
        <translation>模块关机</translation>
    </message>
    <message>
        <source>status frames a second while serial output is on, 1 to 1440</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>status: tilt {tilt}°, {acceleration:.1f} g, {triggered}, {active}</source>
        <translation>状态：倾角 {tilt}°，{acceleration:.1f} g，{triggered}，{active}</translation>
    </message>
    <message>
        <source>stream</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>switch a fault on; none ends all</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>switch it off and on</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>switch the serial output off</source>
        <translation>关闭串口输出</translation>
    </message>
    <message>
        <source>switch the serial output on</source>
        <translation>开启串口输出</translation>
    </message>
    <message>
        <source>symbolic link to the pseudo-terminal</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>the command that the module's frames answer: {names}</source>
        <translation>模块的帧所答复的命令：{names}</translation>
    </message>
    <message>
        <source>the frame broke off</source>
        <translation>帧不完整</translation>
    </message>
    <message>
        <source>the host's own bytes come back</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>the module answered {raw} instead</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>the module answers: online</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>the module probably restarted</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>the module restarted</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>the parachute bay is open</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>the port was lost; it may have been carried out</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>the simulated module has no option {name}</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>the value</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>then leave a screenshot and the values seen in this folder</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>tilt, 1°</source>
        <translation>倾角，1°</translation>
    </message>
    <message>
        <source>to the host</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>to the module</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>trigger by its PWM input</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>trigger flag {value}, expected 00 or 01</source>
        <translation>触发标志为 {value}，应为 00 或 01</translation>
    </message>
    <message>
        <source>trigger record: boot {boot}, {minutes} min {seconds} s after power-on, source {sources}; cell {cell:.2f} V</source>
        <translation>触发记录：第 {boot} 次开机，开机后 {minutes} 分 {seconds} 秒，触发来源 {sources}；电芯 {cell:.2f} V</translation>
    </message>
    <message>
        <source>trigger record: slot never used</source>
        <translation>触发记录：此位置从未使用</translation>
    </message>
    <message>
        <source>trigger records of earlier days, 0 to 9</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>triggered</source>
        <translation>已触发</translation>
    </message>
    <message>
        <source>unasked</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>unknown</source>
        <translation>未知</translation>
    </message>
    <message>
        <source>unknown (cannot be read)</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>unknown ({why})</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>unknown command code {code}</source>
        <translation>未知命令码 {code}</translation>
    </message>
    <message>
        <source>up to this much more delay, at random</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>usage: {usage}</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>used last</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>value {value} is not one that the table allows for {code}</source>
        <translation>数值 {value} 不是协议表允许命令 {code} 使用的值</translation>
    </message>
    <message>
        <source>volts that the cell loses in an hour</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>which way the five above apply</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>without a screen</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>wobble a few degrees, or lie still</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>write a CSV file; - prints it</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>yes</source>
        <translation>是</translation>
    </message>
    <message>
        <source>yes or no is needed</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>yes: it fires by its thresholds</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>yes: it has fired</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>zero the sensor</source>
        <translation>传感器置零</translation>
    </message>
    <message>
        <source>{address} is not HOST:PORT, such as 127.0.0.1:5000</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>{count} slots are empty.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>{count} trigger records written to {file}.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>{file} cannot be written: {why}.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>{ms} ms</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>{name} is given twice.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>{name} {value}</source>
        <translation>{name} {value}</translation>
    </message>
    <message>
        <source>{name}: {why}.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>{n} bytes rejected</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>{n} rows are selected.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>{option}={value}: {reason}</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>{page} ({key})</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>{path} exists and is no symbolic link; it is left alone</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>{port} cannot be used as a serial port.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>{port} does not open within {seconds:.0f} s.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>{port} is in use by another program.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>{port} is in use by {program} (process {pid}).</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>{port} takes no bytes.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>{port} was unplugged or its driver failed.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>{rate:.0f} a second</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>{rate} baud</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>{rate} frames/s</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>{rows} rows</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>{rows} rows, held still; {more} more came</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>{seconds:8.1f} s   tilt {tilt:3}°   {acceleration:4.1f} g   {triggered}   {active}</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>{text} (default: {default})</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>{text} (implausible)</source>
        <translation>{text}（不合理）</translation>
    </message>
    <message>
        <source>{text} is no number</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>{time} ago</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>{value:.0f} h</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>{value:.0f} min</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>{value:.0f} s</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>{value:.1f} s</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>{value}: acknowledged (cannot be read back)</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>{value}: not acknowledged ({why})</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>{value}° fires</source>
        <translation>{value}° 开伞</translation>
    </message>
    <message>
        <source>{volts:.2f} V</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>{volts:.2f} V, charge unknown</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>{volts:.2f} V, charging</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>{word} is unknown; try: help</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>“{name}” cannot be set; what can: {names}.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>“{text}” is neither true nor false</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>“{text}” is no number</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>“{text}” is no number of seconds above 0</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>“{text}” is none of {rates} or auto</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>“{word}” is no pair of hex digits; bytes look like 41 75 32, 417532 or 0x41,0x75.</source>
        <translation>“{word}”不是成对的十六进制数字；字节的写法如 41 75 32、417532 或 0x41,0x75。</translation>
    </message>
    <message>
        <source>“{word}” is not of the form NAME=VALUE.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>… {count} bytes: {words}</source>
        <translation>… 共 {count} 字节：{words}</translation>
    </message>
    <message>
        <source>−{minutes} min</source>
        <translation>−{minutes} 分</translation>
    </message>
    <message>
        <source>−{seconds} s</source>
        <translation>−{seconds} 秒</translation>
    </message>
</context>
</TS>
