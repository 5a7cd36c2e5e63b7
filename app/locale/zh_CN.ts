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
        <source>&amp;File</source>
        <translation>文件(&amp;F)</translation>
    </message>
    <message>
        <source>&amp;Help</source>
        <translation>帮助(&amp;H)</translation>
    </message>
    <message>
        <source>&amp;Module</source>
        <translation>模块(&amp;M)</translation>
    </message>
    <message>
        <source>&amp;View</source>
        <translation>视图(&amp;V)</translation>
    </message>
    <message>
        <source>(!) no lithium cell has this voltage without external power; it is shown as it came.</source>
        <translation>（!）没有外接供电时，锂电芯不会有此电压；此处按收到的值显示。</translation>
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
        <translation>01</translation>
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
        <source>1 g at rest, near 0 g in free fall</source>
        <translation>静止时为 1 g，失重时接近 0 g</translation>
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
        <translation>115200（常用）</translation>
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
        <translation>{port} 上有模块以波特率 {rate} 应答。</translation>
    </message>
    <message>
        <source>A port that is not in the list</source>
        <translation>列表中没有的串口</translation>
    </message>
    <message>
        <source>A simulated module, written from the vendor's table. Prints the port to open as its first line and runs until it is stopped (Ctrl-C). The same options go into the query of sim://NAME?option=value.</source>
        <translation>按厂家协议表编写的模拟模块。第一行打印要打开的串口，一直运行到被停止（Ctrl-C）。同样的选项也可写入 sim://NAME?option=value 的查询部分。</translation>
    </message>
    <message>
        <source>ACTIVE</source>
        <translation>已激活</translation>
    </message>
    <message>
        <source>About</source>
        <translation>关于</translation>
    </message>
    <message>
        <source>Acceleration</source>
        <translation>加速度</translation>
    </message>
    <message>
        <source>Activate</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Activate / lock</source>
        <translation>激活/锁定</translation>
    </message>
    <message>
        <source>Activation</source>
        <translation>激活状态</translation>
    </message>
    <message>
        <source>Active</source>
        <translation>已激活</translation>
    </message>
    <message>
        <source>Active?</source>
        <translation>是否激活</translation>
    </message>
    <message>
        <source>After power-on</source>
        <translation>开机后时间</translation>
    </message>
    <message>
        <source>All frames</source>
        <translation>全部帧</translation>
    </message>
    <message>
        <source>An active module fires by its thresholds; a locked one is in standby and does not fire.</source>
        <translation>激活的模块按阈值触发开伞；锁定的模块处于待机状态，不会触发。</translation>
    </message>
    <message>
        <source>Angle between aircraft and horizontal plane</source>
        <translation>飞机与水平面的夹角</translation>
    </message>
    <message>
        <source>Angle between aircraft and horizontal plane at which it fires; it resets 10° below.</source>
        <translation>触发开伞时飞行器与水平面的夹角；低于该值 10° 时复位。</translation>
    </message>
    <message>
        <source>Angle of the aircraft against the horizontal plane. Active, it fires.</source>
        <translation>飞行器与水平面的夹角。激活时超过阈值会触发。</translation>
    </message>
    <message>
        <source>As the system</source>
        <translation>跟随系统</translation>
    </message>
    <message>
        <source>Ask the administrator of this computer for access to serial ports.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Asking …</source>
        <translation>正在询问……</translation>
    </message>
    <message>
        <source>Attitude</source>
        <translation>姿态</translation>
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
        <translation>开机次数</translation>
    </message>
    <message>
        <source>Boot count</source>
        <translation>开机次数</translation>
    </message>
    <message>
        <source>Bright</source>
        <translation>浅色</translation>
    </message>
    <message>
        <source>Bytes</source>
        <translation>字节</translation>
    </message>
    <message>
        <source>Cancel</source>
        <translation>取消</translation>
    </message>
    <message>
        <source>Cancel saving</source>
        <translation>取消保存</translation>
    </message>
    <message>
        <source>Cancelled, nothing was saved.</source>
        <translation>已取消，没有保存任何内容。</translation>
    </message>
    <message>
        <source>Cell</source>
        <translation>电芯</translation>
    </message>
    <message>
        <source>Cell voltage</source>
        <translation>电芯电压</translation>
    </message>
    <message>
        <source>Cell voltage and charge</source>
        <translation>电芯电压与充电</translation>
    </message>
    <message>
        <source>Change settings: {names} (true or false). What cannot be read back is only ever acknowledged, never verified. Exit code 1 where the module did not acknowledge.</source>
        <translation>修改设置：{names}（true 或 false）。无法回读的设置只能得到确认，无法验证。模块未确认时退出码为 1。</translation>
    </message>
    <message>
        <source>Change the baud rate</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Charger</source>
        <translation>外接供电</translation>
    </message>
    <message>
        <source>Charges the cell, and wakes a module that was shut down.</source>
        <translation>为电芯充电，并唤醒已关机的模块。</translation>
    </message>
    <message>
        <source>Charging</source>
        <translation>充电状态</translation>
    </message>
    <message>
        <source>Charging voltage</source>
        <translation>充电电压</translation>
    </message>
    <message>
        <source>Check its power and the cable; it is asked again every 2 s.</source>
        <translation>请检查模块供电和接线；每 2 秒重新询问一次。</translation>
    </message>
    <message>
        <source>Check that it is switched on and that TX and RX are crossed; if so, find the rate (dps-s find).</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Check that it is switched on, that TX and RX are crossed, and that ground is connected.</source>
        <translation>请检查模块已开机、TX 与 RX 已交叉连接、地线已接好。</translation>
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
        <translation>选择串口</translation>
    </message>
    <message>
        <source>Choose a port …</source>
        <translation>选择串口…</translation>
    </message>
    <message>
        <source>Choose a port, connect or disconnect (Ctrl+K)</source>
        <translation>选择串口、连接或断开（Ctrl+K）</translation>
    </message>
    <message>
        <source>Choose a row to see all of its bytes.</source>
        <translation>选择一行可查看全部字节。</translation>
    </message>
    <message>
        <source>Choose another port from the list (dps-s ports).</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Choose the port that the module is plugged into (Ctrl+K)</source>
        <translation>选择模块所接的串口（Ctrl+K）</translation>
    </message>
    <message>
        <source>Choose the port that the module is plugged into.</source>
        <translation>请选择模块所接的串口。</translation>
    </message>
    <message>
        <source>Clamps what is set</source>
        <translation>限制设置范围</translation>
    </message>
    <message>
        <source>Clear</source>
        <translation>清空</translation>
    </message>
    <message>
        <source>Clear the list</source>
        <translation>清空列表</translation>
    </message>
    <message>
        <source>Close</source>
        <translation>关闭</translation>
    </message>
    <message>
        <source>Close that program and connect again.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Close the port (Ctrl+D)</source>
        <translation>关闭串口（Ctrl+D）</translation>
    </message>
    <message>
        <source>Close this message</source>
        <translation>关闭此消息</translation>
    </message>
    <message>
        <source>Close this sheet (Esc)</source>
        <translation>关闭此面板（Esc）</translation>
    </message>
    <message>
        <source>Close {program} and connect again.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Close, leave it ACTIVE</source>
        <translation>关闭，保持激活</translation>
    </message>
    <message>
        <source>Closed</source>
        <translation>已关闭</translation>
    </message>
    <message>
        <source>Configure, test and watch a DPS-S drone parachute module over its serial port.</source>
        <translation>通过串口配置、测试和监视 DPS-S 无人机伞降模块。</translation>
    </message>
    <message>
        <source>Configures, tests and watches a DPS-S parachute module over its serial port.</source>
        <translation>通过串口配置、测试和监视 DPS-S 伞降模块。</translation>
    </message>
    <message>
        <source>Connect</source>
        <translation>连接</translation>
    </message>
    <message>
        <source>Connect again</source>
        <translation>重新连接</translation>
    </message>
    <message>
        <source>Connect again.</source>
        <translation>请重新连接。</translation>
    </message>
    <message>
        <source>Connect again; if it comes back, send us the log.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Connect to the simulated module</source>
        <translation>连接模拟模块</translation>
    </message>
    <message>
        <source>Connect …</source>
        <translation>连接……</translation>
    </message>
    <message>
        <source>Connected</source>
        <translation>已连接</translation>
    </message>
    <message>
        <source>Copy</source>
        <translation>复制</translation>
    </message>
    <message>
        <source>Copy the selected rows</source>
        <translation>复制所选行</translation>
    </message>
    <message>
        <source>Copy the selected rows, or all of them when none is selected (Ctrl+C)</source>
        <translation>复制所选行；未选择时复制全部（Ctrl+C）</translation>
    </message>
    <message>
        <source>DPS-S Configurator</source>
        <translation>DPS-S 上位机</translation>
    </message>
    <message>
        <source>DPS-S Configurator {version}</source>
        <translation>DPS-S 上位机 {version}</translation>
    </message>
    <message>
        <source>Dark</source>
        <translation>深色</translation>
    </message>
    <message>
        <source>Decides when the parachute counts as having left the bay.</source>
        <translation>用于判断降落伞是否已出仓。</translation>
    </message>
    <message>
        <source>Delay</source>
        <translation>延迟</translation>
    </message>
    <message>
        <source>Deploy</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Deploy over serial</source>
        <translation>串口触发开伞</translation>
    </message>
    <message>
        <source>Direction of faults</source>
        <translation>故障方向</translation>
    </message>
    <message>
        <source>Disconnect</source>
        <translation>断开</translation>
    </message>
    <message>
        <source>Disconnect, leave it ACTIVE</source>
        <translation>断开，保持激活</translation>
    </message>
    <message>
        <source>Do not change it.</source>
        <translation>不要更改。</translation>
    </message>
    <message>
        <source>Doubled answers</source>
        <translation>重复应答</translation>
    </message>
    <message>
        <source>Drag or arrow keys move, wheel or + and − zoom, Shift with arrow keys reads off, Space pauses</source>
        <translation>拖动或方向键平移，滚轮或 + / − 缩放，Shift 加方向键读数，空格键暂停</translation>
    </message>
    <message>
        <source>Drop {height} m</source>
        <translation>坠落 {height} m</translation>
    </message>
    <message>
        <source>E11: light the other way round</source>
        <translation>E11：光线读数反向</translation>
    </message>
    <message>
        <source>E11: more light reads lower</source>
        <translation>E11：光线越强读数越低</translation>
    </message>
    <message>
        <source>E12: records carry 4.70 V, as the worked example does</source>
        <translation>E12：记录中的电压为 4.70 V，与协议表示例相同</translation>
    </message>
    <message>
        <source>E12: records with 4.70 V</source>
        <translation>E12：记录电压为 4.70 V</translation>
    </message>
    <message>
        <source>E15: activation, trigger flags and serial output survive a restart</source>
        <translation>E15：激活状态、触发开关和串口输出在重启后保留</translation>
    </message>
    <message>
        <source>E15: remembers its state</source>
        <translation>E15：重启后保留状态</translation>
    </message>
    <message>
        <source>E2: a set of 21, 22 or 24 is acknowledged by the value or by 01</source>
        <translation>E2：设置 21、22 或 24 时，以设置值或以 01 应答</translation>
    </message>
    <message>
        <source>E2: acknowledges by</source>
        <translation>E2：应答内容</translation>
    </message>
    <message>
        <source>E3: code of the answer to the cell voltage, 34</source>
        <translation>E3：查询电芯电压（34）时应答所用的命令码</translation>
    </message>
    <message>
        <source>E3: voltage code</source>
        <translation>E3：电压命令码</translation>
    </message>
    <message>
        <source>E4: code for 17</source>
        <translation>E4：17 的应答码</translation>
    </message>
    <message>
        <source>E4: code of the acknowledgement of 17</source>
        <translation>E4：设置 17 时应答所用的命令码</translation>
    </message>
    <message>
        <source>E6: pause between records or pieces</source>
        <translation>E6：记录或片段之间的间隔</translation>
    </message>
    <message>
        <source>E6: records</source>
        <translation>E6：触发记录</translation>
    </message>
    <message>
        <source>E6: records come in one go, one by one, or cut into pieces of seven bytes</source>
        <translation>E6：触发记录一次发完、逐条发送，或拆成七字节的片段</translation>
    </message>
    <message>
        <source>E7: empty slots</source>
        <translation>E7：空记录位</translation>
    </message>
    <message>
        <source>E7: slots never used are left out, sent as 00, or sent as FF</source>
        <translation>E7：从未使用的记录位不发送、以 00 发送，或以 FF 发送</translation>
    </message>
    <message>
        <source>E9: a new rate is acknowledged at the old rate, at the new, or begins at a restart</source>
        <translation>E9：新波特率以旧速率应答、以新速率应答，或重启后才生效</translation>
    </message>
    <message>
        <source>E9: acknowledges</source>
        <translation>E9：波特率应答</translation>
    </message>
    <message>
        <source>Echo of the host's bytes</source>
        <translation>回送上位机字节</translation>
    </message>
    <message>
        <source>End all faults</source>
        <translation>结束所有故障</translation>
    </message>
    <message>
        <source>Examples:</source>
        <translation>示例：</translation>
    </message>
    <message>
        <source>Explain captured bytes. What was asked is taken from the host's frames in the capture, else from --asked; with neither, a whole trigger record of 16 bytes wins over a reply of six.</source>
        <translation>解释捕获的字节。所查询的内容取自捕获中上位机的帧，否则取自 --asked；两者皆无时，完整的 16 字节触发记录优先于 6 字节答复。</translation>
    </message>
    <message>
        <source>External power</source>
        <translation>外接供电</translation>
    </message>
    <message>
        <source>Fall</source>
        <translation>坠落</translation>
    </message>
    <message>
        <source>Faults of the line, and ways that the vendor's table leaves open.</source>
        <translation>线路故障，以及厂家协议表未明确的行为。</translation>
    </message>
    <message>
        <source>Figures of the link</source>
        <translation>链路数据</translation>
    </message>
    <message>
        <source>Find the baud rate at which a module answers. Sends nothing but heartbeats, first at the rate of --baud. Exit code 3 where none answers.</source>
        <translation>查找模块应答的波特率。只发送心跳，先用 --baud 指定的波特率。无应答时退出码为 3。</translation>
    </message>
    <message>
        <source>Find the rate</source>
        <translation>查找波特率</translation>
    </message>
    <message>
        <source>Fires the parachute. 00 forbids it; for how long, the vendor does not say.</source>
        <translation>触发开伞。00 为禁止触发；禁止多久，厂家未说明。</translation>
    </message>
    <message>
        <source>Forbid deploying</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Forget all rows (Ctrl+Shift+X)</source>
        <translation>清除所有行（Ctrl+Shift+X）</translation>
    </message>
    <message>
        <source>Frames a second, usual round trip, bytes that were no frame</source>
        <translation>每秒帧数、常见往返时间、无法识别的字节数</translation>
    </message>
    <message>
        <source>Frames sent and received</source>
        <translation>收发的帧</translation>
    </message>
    <message>
        <source>Free fall</source>
        <translation>失重</translation>
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
        <source>From 13 m on a fall lasts longer than 1.60 s.</source>
        <translation>从 13 m 起，坠落时间超过 1.60 秒。</translation>
    </message>
    <message>
        <source>Full screen</source>
        <translation>全屏</translation>
    </message>
    <message>
        <source>Garbage</source>
        <translation>杂乱字节</translation>
    </message>
    <message>
        <source>Go on</source>
        <translation>继续</translation>
    </message>
    <message>
        <source>Heartbeat</source>
        <translation>心跳</translation>
    </message>
    <message>
        <source>Height of the fall</source>
        <translation>坠落高度</translation>
    </message>
    <message>
        <source>Hold the list still; frames go on being recorded (Ctrl+P)</source>
        <translation>列表静止，帧继续记录（Ctrl+P）</translation>
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
        <translation>如未出现，请换一根线。</translation>
    </message>
    <message>
        <source>It has not been armed and held for two seconds.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>It has not been confirmed.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>It is not known whether the module has fired.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>It is not known whether the module is active.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>It is not known whether the module is locked.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>It is not known whether the module is locked: settings are not changed.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Jitter</source>
        <translation>抖动</translation>
    </message>
    <message>
        <source>Keeps what is set</source>
        <translation>保存设置</translation>
    </message>
    <message>
        <source>Kind</source>
        <translation>类别</translation>
    </message>
    <message>
        <source>LOCK</source>
        <translation>锁定</translation>
    </message>
    <message>
        <source>LOCK again</source>
        <translation>再次锁定</translation>
    </message>
    <message>
        <source>LOCK and close</source>
        <translation>锁定并关闭</translation>
    </message>
    <message>
        <source>LOCK and disconnect</source>
        <translation>锁定并断开</translation>
    </message>
    <message>
        <source>LOCK was sent, and the module still says ACTIVE.</source>
        <translation>锁定命令已发出，但模块仍报告激活。</translation>
    </message>
    <message>
        <source>LOCK was sent, but the module does not say that it is locked. Treat it as ACTIVE.</source>
        <translation>锁定命令已发出，但模块未确认已锁定。请按仍处于激活状态对待。</translation>
    </message>
    <message>
        <source>LOCK: put the module into standby</source>
        <translation>锁定：使模块进入待机</translation>
    </message>
    <message>
        <source>LOCKED</source>
        <translation>已锁定</translation>
    </message>
    <message>
        <source>LOCKED: the module says so.</source>
        <translation>已锁定：模块已确认。</translation>
    </message>
    <message>
        <source>Language</source>
        <translation>语言</translation>
    </message>
    <message>
        <source>Length of the time line: {length}</source>
        <translation>时间轴长度：{length}</translation>
    </message>
    <message>
        <source>Let it fall from this height. Active, it fires by free fall.</source>
        <translation>让模块从该高度坠落。激活时会因失重触发。</translation>
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
        <source>Line and dialect</source>
        <translation>线路与方言</translation>
    </message>
    <message>
        <source>Lines on standard input while it runs:</source>
        <translation>运行时可在标准输入中键入的命令：</translation>
    </message>
    <message>
        <source>List the serial ports, USB first. Opens none of them.</source>
        <translation>列出串口，USB 在前。不会打开任何串口。</translation>
    </message>
    <message>
        <source>Live</source>
        <translation>实时</translation>
    </message>
    <message>
        <source>Lock</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Locking …</source>
        <translation>正在锁定……</translation>
    </message>
    <message>
        <source>Looking for ports …</source>
        <translation>正在查找串口……</translation>
    </message>
    <message>
        <source>Looking for the baud rate at which a module answers.</source>
        <translation>正在查找模块能应答的波特率。</translation>
    </message>
    <message>
        <source>Lost answers</source>
        <translation>应答丢失</translation>
    </message>
    <message>
        <source>Lost bytes</source>
        <translation>字节丢失</translation>
    </message>
    <message>
        <source>Make the line perfect again; the dialect stays.</source>
        <translation>恢复线路正常；方言保持不变。</translation>
    </message>
    <message>
        <source>Maker</source>
        <translation>制造商</translation>
    </message>
    <message>
        <source>Meaning</source>
        <translation>含义</translation>
    </message>
    <message>
        <source>Measured values</source>
        <translation>测量值</translation>
    </message>
    <message>
        <source>Message</source>
        <translation>消息</translation>
    </message>
    <message>
        <source>Message: {text}</source>
        <translation>消息：{text}</translation>
    </message>
    <message>
        <source>Module on {port}, {rate} baud</source>
        <translation>{port} 上的模块，波特率 {rate}</translation>
    </message>
    <message>
        <source>Module on {port}, {rate} baud, answers in {milliseconds:.1f} ms</source>
        <translation>{port} 上的模块，波特率 {rate}，应答时间 {milliseconds:.1f} 毫秒</translation>
    </message>
    <message>
        <source>Most likely the module has another baud rate: find it (dps-s find, or --baud auto).</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Moves by a few degrees, as in the wind.</source>
        <translation>像在风中一样晃动几度。</translation>
    </message>
    <message>
        <source>Mute</source>
        <translation>静默</translation>
    </message>
    <message>
        <source>NOT TRIGGERED</source>
        <translation>未触发</translation>
    </message>
    <message>
        <source>Name</source>
        <translation>名称</translation>
    </message>
    <message>
        <source>No answer</source>
        <translation>无应答</translation>
    </message>
    <message>
        <source>No module</source>
        <translation>无模块</translation>
    </message>
    <message>
        <source>No module answers on {port} at any baud rate.</source>
        <translation>{port} 上没有模块以任何波特率应答。</translation>
    </message>
    <message>
        <source>No module answers on {port} at {rate} baud.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>No module connected</source>
        <translation>未连接模块</translation>
    </message>
    <message>
        <source>No port is open.</source>
        <translation>没有打开的串口。</translation>
    </message>
    <message>
        <source>No records came.</source>
        <translation>没有收到记录。</translation>
    </message>
    <message>
        <source>No rows yet</source>
        <translation>暂无记录</translation>
    </message>
    <message>
        <source>No serial port found. Plug the adapter in: it appears here by itself.</source>
        <translation>未找到串口。请插入转接器，它会自动出现在这里。</translation>
    </message>
    <message>
        <source>No simulated module is connected.</source>
        <translation>未连接模拟模块。</translation>
    </message>
    <message>
        <source>No two readings agreed: records may be missing. Read again.</source>
        <translation>没有两次读取一致：可能缺少记录。请重新读取。</translation>
    </message>
    <message>
        <source>Not connected</source>
        <translation>未连接</translation>
    </message>
    <message>
        <source>Not had: {names}. Read again; if it stays so, check the wiring.</source>
        <translation>未取得：{names}。请重新读取；若依然如此，请检查接线。</translation>
    </message>
    <message>
        <source>Not opened</source>
        <translation>未打开</translation>
    </message>
    <message>
        <source>Not saved to {path}: {why}. Choose another folder.</source>
        <translation>未能保存到 {path}：{why}。请选择其他文件夹。</translation>
    </message>
    <message>
        <source>Nothing to decode: give the bytes in hex, or - to read them from standard input.</source>
        <translation>没有可解码的内容：请给出十六进制字节，或用 - 从标准输入读取。</translation>
    </message>
    <message>
        <source>Nothing to plug in; behaves as the vendor's table says</source>
        <translation>无需接线；行为与厂商协议表一致</translation>
    </message>
    <message>
        <source>Now</source>
        <translation>当前</translation>
    </message>
    <message>
        <source>Off and on again: one more boot, two heartbeats, locked.</source>
        <translation>关机后再开机：开机次数加一，发送两次心跳，处于锁定状态。</translation>
    </message>
    <message>
        <source>Offline</source>
        <translation>离线</translation>
    </message>
    <message>
        <source>Offline for {time}</source>
        <translation>已离线 {time}</translation>
    </message>
    <message>
        <source>Only an echo</source>
        <translation>只有回显</translation>
    </message>
    <message>
        <source>Only our own bytes come back on {port}.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Only rejected bytes</source>
        <translation>仅拒收字节</translation>
    </message>
    <message>
        <source>Open the chosen port (Enter)</source>
        <translation>打开所选串口（回车）</translation>
    </message>
    <message>
        <source>Open the window.</source>
        <translation>打开窗口。</translation>
    </message>
    <message>
        <source>Open, the light sensor reads about 2.5 V; closed, about 0.3 V.</source>
        <translation>打开时光线读数约 2.5 V；关闭时约 0.3 V。</translation>
    </message>
    <message>
        <source>Opening …</source>
        <translation>正在打开……</translation>
    </message>
    <message>
        <source>Other port</source>
        <translation>其他串口</translation>
    </message>
    <message>
        <source>Pages</source>
        <translation>页面</translation>
    </message>
    <message>
        <source>Parachute bay open</source>
        <translation>伞仓打开</translation>
    </message>
    <message>
        <source>Pause</source>
        <translation>暂停</translation>
    </message>
    <message>
        <source>Pause the list</source>
        <translation>暂停列表</translation>
    </message>
    <message>
        <source>Picture (*.png)</source>
        <translation>图片 (*.png)</translation>
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
        <translation>插入</translation>
    </message>
    <message>
        <source>Plug the adapter in and choose it from the list (dps-s ports).</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Plug the same adapter in again: it is connected by itself.</source>
        <translation>请重新插入同一转接器，程序会自动连接。</translation>
    </message>
    <message>
        <source>Port</source>
        <translation>串口</translation>
    </message>
    <message>
        <source>Port lost</source>
        <translation>串口丢失</translation>
    </message>
    <message>
        <source>Port {port}: {state}</source>
        <translation>串口 {port}：{state}</translation>
    </message>
    <message>
        <source>Ports</source>
        <translation>串口</translation>
    </message>
    <message>
        <source>Press its switch</source>
        <translation>按下模块开关</translation>
    </message>
    <message>
        <source>Print the status as it streams, or polled where the module does not stream, until Ctrl-C. The stream is switched on where it was off, and off again at the end. Times count from the first status.</source>
        <translation>持续输出模块的状态，直到按下 Ctrl-C；模块不主动输出时改为轮询。串口输出若原为关闭则打开，结束时再关闭。时间从第一个状态算起。</translation>
    </message>
    <message>
        <source>Proves that the module is there. It sends two by itself, 50 ms apart, after power-up.</source>
        <translation>证明模块在线。模块上电后自行发送两次，间隔 50 ms。</translation>
    </message>
    <message>
        <source>Pull the serial adapter out.</source>
        <translation>拔出串口适配器。</translation>
    </message>
    <message>
        <source>Put the module into standby: it no longer fires by itself (Ctrl+L)</source>
        <translation>使模块进入待机：不再自动开伞（Ctrl+L）</translation>
    </message>
    <message>
        <source>Put the serial adapter back.</source>
        <translation>重新插入串口适配器。</translation>
    </message>
    <message>
        <source>Quit</source>
        <translation>退出</translation>
    </message>
    <message>
        <source>Read everything that can be read. What cannot be had is shown as unknown; exit code 4 then.</source>
        <translation>读取全部可读内容。无法取得的显示为未知，此时退出码为 4。</translation>
    </message>
    <message>
        <source>Read the trigger records, as often as it takes until two readings agree. Exit code 4 when they do not.</source>
        <translation>读取触发记录，直到两次读取一致为止。不一致时退出码为 4。</translation>
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
        <translation>拒绝设置</translation>
    </message>
    <message>
        <source>Reports</source>
        <translation>状态上报</translation>
    </message>
    <message>
        <source>Restart</source>
        <translation>重启</translation>
    </message>
    <message>
        <source>Save a picture as PNG</source>
        <translation>保存 PNG 图片</translation>
    </message>
    <message>
        <source>Save a picture of what is in sight, PNG (Ctrl+Shift+S)</source>
        <translation>将所见画面存为 PNG 图片（Ctrl+Shift+S）</translation>
    </message>
    <message>
        <source>Save every sample in sight as a table, CSV (Ctrl+S)</source>
        <translation>将所见的每个采样存为 CSV 表格（Ctrl+S）</translation>
    </message>
    <message>
        <source>Save picture</source>
        <translation>保存图片</translation>
    </message>
    <message>
        <source>Save picture …</source>
        <translation>保存图片…</translation>
    </message>
    <message>
        <source>Save the values in sight as CSV</source>
        <translation>将所见数据存为 CSV</translation>
    </message>
    <message>
        <source>Save values</source>
        <translation>保存数据</translation>
    </message>
    <message>
        <source>Save values …</source>
        <translation>保存数据…</translation>
    </message>
    <message>
        <source>Saved the picture to {path}</source>
        <translation>图片已保存到 {path}</translation>
    </message>
    <message>
        <source>Saved {rows} rows to {path}</source>
        <translation>已保存 {rows} 行到 {path}</translation>
    </message>
    <message>
        <source>Saved {rows} rows to {path}. What is older is no longer kept.</source>
        <translation>已保存 {rows} 行到 {path}。更早的数据已不再保留。</translation>
    </message>
    <message>
        <source>Saving … {percent} %</source>
        <translation>正在保存… {percent} %</translation>
    </message>
    <message>
        <source>Serial</source>
        <translation>串口</translation>
    </message>
    <message>
        <source>Serial number</source>
        <translation>序列号</translation>
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
        <translation>设置</translation>
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
        <translation>已关机。可通过开关或外接供电重新开机。</translation>
    </message>
    <message>
        <source>Simulated module</source>
        <translation>模拟模块</translation>
    </message>
    <message>
        <source>Simulated module panel</source>
        <translation>模拟模块面板</translation>
    </message>
    <message>
        <source>Something else is armed: {what}.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Something sends on {port}, but no frame can be read at {rate} baud.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Source</source>
        <translation>来源</translation>
    </message>
    <message>
        <source>Speed of the serial line. The vendor advises not to change it.</source>
        <translation>串口通讯速率。厂家建议不要更改。</translation>
    </message>
    <message>
        <source>Split, pause</source>
        <translation>分段间隔</translation>
    </message>
    <message>
        <source>Standard input is not text; decode reads bytes written in hex, such as 41 75 32.</source>
        <translation>标准输入不是文本；decode 读取以十六进制书写的字节，例如 41 75 32。</translation>
    </message>
    <message>
        <source>State of the simulated module</source>
        <translation>模拟模块的状态</translation>
    </message>
    <message>
        <source>Status</source>
        <translation>状态</translation>
    </message>
    <message>
        <source>Status reports a second: streamed by the module, or polled</source>
        <translation>每秒状态帧数：模块主动输出，或由上位机轮询</translation>
    </message>
    <message>
        <source>Stay</source>
        <translation>留下</translation>
    </message>
    <message>
        <source>Stop saving; no file is left</source>
        <translation>停止保存，不留下文件</translation>
    </message>
    <message>
        <source>Stream rate</source>
        <translation>输出速率</translation>
    </message>
    <message>
        <source>Streams</source>
        <translation>串口输出</translation>
    </message>
    <message>
        <source>Sunlight</source>
        <translation>阳光下</translation>
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
        <source>Switches the module on after it was shut down.</source>
        <translation>在关机后重新开机。</translation>
    </message>
    <message>
        <source>TRIGGERED</source>
        <translation>已触发！</translation>
    </message>
    <message>
        <source>Table (*.csv)</source>
        <translation>表格 (*.csv)</translation>
    </message>
    <message>
        <source>Takes today's mounting as level. For small mounting errors only.</source>
        <translation>将当前安装方式作为水平面。仅用于修正小角度安装误差。</translation>
    </message>
    <message>
        <source>The attitude threshold is not known: read the settings first.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>The audit log cannot be written, so nothing dangerous is sent.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>The confirmation is {seconds:.1f} s old: confirm again.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>The last nine triggers, each with the settings and readings of its moment.</source>
        <translation>最近九次触发，每条含触发时的设置和读数。</translation>
    </message>
    <message>
        <source>The last status is {seconds:.1f} s old.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>The module answers.</source>
        <translation>模块应答正常。</translation>
    </message>
    <message>
        <source>The module becomes ready: from then on it fires by itself when it tips over or falls.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>The module does not answer.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>The module fires the parachute.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>The module gets another value for this setting.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>The module goes into standby: it does not fire, also not when it tips over or falls.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>The module has not reported its status yet.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>The module is ACTIVE: it fires by its thresholds, with or without this program.</source>
        <translation>模块处于激活状态：无论本程序是否运行，达到阈值都会开伞。</translation>
    </message>
    <message>
        <source>The module is ACTIVE: lock it before changing settings, or unlock this one write.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>The module is ACTIVE: lock it first.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>The module is LOCKED: a locked module does not fire.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>The module is told not to fire over serial; for how long, the vendor does not say.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>The module keeps no trigger records.</source>
        <translation>模块中没有触发记录。</translation>
    </message>
    <message>
        <source>The module no longer answers.</source>
        <translation>模块不再应答。</translation>
    </message>
    <message>
        <source>The module on {port} answers, but reports no status.</source>
        <translation>{port} 上的模块有应答，但不报告状态。</translation>
    </message>
    <message>
        <source>The module on {port} sends, but does not answer.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>The module on {port} stopped answering. Check its power and the wiring, and read again.</source>
        <translation>{port} 上的模块不再应答。请检查供电和接线，然后重新读取。</translation>
    </message>
    <message>
        <source>The module on {port} stopped answering. Check its power and the wiring.</source>
        <translation>{port} 上的模块不再应答。请检查供电和接线。</translation>
    </message>
    <message>
        <source>The module reports that it has fired.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>The module restarted and has not reported its status since.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>The module switches off. It comes back by its switch, held for 2 s, or by external power.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>The module takes its present position as level. For small mounting errors only.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>The module was ACTIVE when it was last heard: treat it as ready to fire.</source>
        <translation>最后一次收到数据时模块处于激活状态：请按随时可能开伞对待。</translation>
    </message>
    <message>
        <source>The module's baud rate; 115200 unless somebody changed it</source>
        <translation>模块的波特率；未改动过时为 115200</translation>
    </message>
    <message>
        <source>The port closed while locking. Treat the module as ACTIVE.</source>
        <translation>锁定过程中串口关闭。请按模块仍处于激活状态对待。</translation>
    </message>
    <message>
        <source>The port is being opened.</source>
        <translation>正在打开串口。</translation>
    </message>
    <message>
        <source>The port is open, the module is being asked.</source>
        <translation>串口已打开，正在询问模块。</translation>
    </message>
    <message>
        <source>The port was closed by a fault of this program.</source>
        <translation>串口因本程序的错误而关闭。</translation>
    </message>
    <message>
        <source>The port went away.</source>
        <translation>串口已消失。</translation>
    </message>
    <message>
        <source>The program met an error that it did not expect: {error}.</source>
        <translation>程序遇到意外错误：{error}。</translation>
    </message>
    <message>
        <source>The selected row in full</source>
        <translation>所选行的完整内容</translation>
    </message>
    <message>
        <source>The serial line gets another speed. The vendor advises not to change it.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>The system did not list its serial ports in time. Switch Bluetooth off and try again.</source>
        <translation>系统未能及时列出串口。请关闭蓝牙后重试。</translation>
    </message>
    <message>
        <source>The tilt is not known.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>The tilt is {tilt:.0f}° and the module fires at {threshold:.0f}°: it would fire at once.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Theme</source>
        <translation>主题</translation>
    </message>
    <message>
        <source>There is no port {port}.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>There is no serial port. Plug the adapter in; if it stays away, try another cable or its driver.</source>
        <translation>没有串口。请插入适配器；若仍未出现，请更换数据线或安装驱动程序。</translation>
    </message>
    <message>
        <source>This confirmation has been used already: confirm again.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>This is a rehearsal: nothing is sent.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Tilt</source>
        <translation>倾角</translation>
    </message>
    <message>
        <source>Tilt, acceleration and cell voltage appear here as soon as a module answers.</source>
        <translation>模块应答后，这里会显示倾角、加速度和电芯电压。</translation>
    </message>
    <message>
        <source>Tilt, acceleration, trigger and activation in one report; also what is streamed.</source>
        <translation>一次报告倾角、加速度、触发状态和激活状态；实时输出的内容与此相同。</translation>
    </message>
    <message>
        <source>Time</source>
        <translation>时间</translation>
    </message>
    <message>
        <source>Time of day</source>
        <translation>时刻</translation>
    </message>
    <message>
        <source>Time since the last frame</source>
        <translation>距上一帧的时间</translation>
    </message>
    <message>
        <source>Traffic</source>
        <translation>通信记录</translation>
    </message>
    <message>
        <source>Trigger</source>
        <translation>触发状态</translation>
    </message>
    <message>
        <source>Trigger records</source>
        <translation>触发记录</translation>
    </message>
    <message>
        <source>Triggered</source>
        <translation>已触发</translation>
    </message>
    <message>
        <source>Triggered?</source>
        <translation>开伞状态</translation>
    </message>
    <message>
        <source>Try everything without a module</source>
        <translation>没有模块也能试用全部功能</translation>
    </message>
    <message>
        <source>Trying {rate} baud</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Trying {rate} baud …</source>
        <translation>正在尝试波特率 {rate}……</translation>
    </message>
    <message>
        <source>Turned bits</source>
        <translation>位翻转</translation>
    </message>
    <message>
        <source>Type: sudo usermod -aG dialout $USER — then log out and in again.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Unplug</source>
        <translation>拔出</translation>
    </message>
    <message>
        <source>Unplug the adapter, plug it in again and connect.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Unplug the adapter, plug it in again and try again.</source>
        <translation>请拔下适配器，重新插上后再试。</translation>
    </message>
    <message>
        <source>Unplugged</source>
        <translation>已拔出</translation>
    </message>
    <message>
        <source>Voltage of the module's cell. It drains slowly by itself.</source>
        <translation>模块的电芯电压，会自行缓慢下降。</translation>
    </message>
    <message>
        <source>Voltage of the module's cell; with external power connected it is the charging voltage.</source>
        <translation>模块的电芯电压；接有外接供电时为充电电压。</translation>
    </message>
    <message>
        <source>What is this?</source>
        <translation>这是什么？</translation>
    </message>
    <message>
        <source>What was read cannot be written: {error}.</source>
        <translation>读到的内容无法写出：{error}。</translation>
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
        <translation>显示哪些行</translation>
    </message>
    <message>
        <source>Windows has no pseudo-terminals: use --tcp 127.0.0.1:0</source>
        <translation>Windows 没有伪终端：请使用 --tcp 127.0.0.1:0</translation>
    </message>
    <message>
        <source>Without a command the window opens. Exit code: 0 done; 1 done and the answer is no; 2 used wrongly; 3 no link (no such port, busy, no permission, no answer); 4 some of it could not be had; 130 or 143 interrupted before there was a result.</source>
        <translation>不带命令时打开窗口。退出码：0 完成；1 完成，但结果为否；2 用法错误；3 无连接（无此串口、被占用、无权限、无应答）；4 部分内容未能取得；130 或 143 在得到结果之前被中断。</translation>
    </message>
    <message>
        <source>Without the stream</source>
        <translation>不含串口输出</translation>
    </message>
    <message>
        <source>Wobbles a little</source>
        <translation>轻微晃动</translation>
    </message>
    <message>
        <source>Write a setting</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>Wrong rate?</source>
        <translation>波特率不对？</translation>
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
        <translation>改用 TCP 套接字；端口 0 表示自动选择</translation>
    </message>
    <message>
        <source>a TCP socket, on every platform: prints socket://127.0.0.1:…</source>
        <translation>TCP 套接字，各平台可用：打印 socket://127.0.0.1:…</translation>
    </message>
    <message>
        <source>a bad line, the same each time</source>
        <translation>一条质量差的线路，每次都相同</translation>
    </message>
    <message>
        <source>a device name (see dps-s ports), a pseudo-terminal or a URL: socket://HOST:PORT, sim://</source>
        <translation>设备名（见 dps-s ports）、伪终端或 URL：socket://HOST:PORT、sim://</translation>
    </message>
    <message>
        <source>a heartbeat was not answered: offline</source>
        <translation>心跳无应答：离线</translation>
    </message>
    <message>
        <source>a height from 0 to 10000 m is needed</source>
        <translation>需要 0 到 10000 m 之间的高度</translation>
    </message>
    <message>
        <source>a number from {least} to {most} is needed</source>
        <translation>需要 {least} 到 {most} 之间的数</translation>
    </message>
    <message>
        <source>a simulated module; prints the port to open</source>
        <translation>模拟模块；打印要打开的串口</translation>
    </message>
    <message>
        <source>a whole number from {least} to {most} is needed</source>
        <translation>需要 {least} 到 {most} 之间的整数</translation>
    </message>
    <message>
        <source>acceleration, 0.1 g</source>
        <translation>加速度，0.1 g</translation>
    </message>
    <message>
        <source>acknowledged only</source>
        <translation>只应答</translation>
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
        <translation>不经协议直接激活或锁定</translation>
    </message>
    <message>
        <source>activate the module</source>
        <translation>激活模块</translation>
    </message>
    <message>
        <source>activated</source>
        <translation>已激活</translation>
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
        <translation>已激活：在标准输入中键入 tilt 70 即会触发</translation>
    </message>
    <message>
        <source>also as {path}</source>
        <translation>也可用路径 {path}</translation>
    </message>
    <message>
        <source>always the same path, and the quickest stream</source>
        <translation>路径固定不变，输出速率最快</translation>
    </message>
    <message>
        <source>angle against the horizontal plane, in degrees</source>
        <translation>与水平面的夹角，单位为度</translation>
    </message>
    <message>
        <source>answer</source>
        <translation>应答</translation>
    </message>
    <message>
        <source>answers come in up to three pieces with this pause between them</source>
        <translation>应答最多分成三段发送，段间间隔为此值</translation>
    </message>
    <message>
        <source>at a restart</source>
        <translation>重启后生效</translation>
    </message>
    <message>
        <source>at the new rate</source>
        <translation>以新速率应答</translation>
    </message>
    <message>
        <source>at the old rate</source>
        <translation>以旧速率应答</translation>
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
        <translation>模块的波特率</translation>
    </message>
    <message>
        <source>baud rate, default 115200</source>
        <translation>波特率，默认 115200</translation>
    </message>
    <message>
        <source>baud rate: {rates}, or auto to try them all; default 115200</source>
        <translation>波特率：{rates}，或用 auto 逐一尝试；默认 115200</translation>
    </message>
    <message>
        <source>begin active instead of locked: it fires by its own thresholds</source>
        <translation>启动时为激活而非锁定：模块会按自身阈值触发</translation>
    </message>
    <message>
        <source>boot count at the trigger</source>
        <translation>触发时的开机次数</translation>
    </message>
    <message>
        <source>boot count, 0 to 255</source>
        <translation>开机次数，0 到 255</translation>
    </message>
    <message>
        <source>boot {count}</source>
        <translation>开机次数 {count}</translation>
    </message>
    <message>
        <source>both ways</source>
        <translation>双向</translation>
    </message>
    <message>
        <source>built in, or without a description</source>
        <translation>内置串口或无描述</translation>
    </message>
    <message>
        <source>bytes in hex; - reads hex text from standard input</source>
        <translation>十六进制字节；- 表示从标准输入读取十六进制文本</translation>
    </message>
    <message>
        <source>cell voltage</source>
        <translation>电芯电压</translation>
    </message>
    <message>
        <source>cell voltage, 0.02 V</source>
        <translation>电芯电压，0.02 V</translation>
    </message>
    <message>
        <source>change a setting</source>
        <translation>修改设置</translation>
    </message>
    <message>
        <source>change the dialect or the rate</source>
        <translation>更改方言或输出速率</translation>
    </message>
    <message>
        <source>charger connected</source>
        <translation>已接外接供电</translation>
    </message>
    <message>
        <source>charger removed</source>
        <translation>已断外接供电</translation>
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
        <translation>需要十六进制命令码，例如 14,33</translation>
    </message>
    <message>
        <source>commands</source>
        <translation>命令</translation>
    </message>
    <message>
        <source>commands that it does not know, such as 14,33</source>
        <translation>模块不认识的命令，例如 14,33</translation>
    </message>
    <message>
        <source>connect to a built-in simulated module</source>
        <translation>连接内置的模拟模块</translation>
    </message>
    <message>
        <source>connect to this port at once</source>
        <translation>立即连接此串口</translation>
    </message>
    <message>
        <source>connected</source>
        <translation>已连接</translation>
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
        <translation>切断模块电源</translation>
    </message>
    <message>
        <source>delay of every answer</source>
        <translation>每条应答的延迟</translation>
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
        <translation>设备名、伪终端或 socket://主机:端口</translation>
    </message>
    <message>
        <source>dialect: where the vendor's table leaves it open</source>
        <translation>方言：厂家协议表未明确之处</translation>
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
        <translation>已执行：{line}</translation>
    </message>
    <message>
        <source>doubled</source>
        <translation>重复</translation>
    </message>
    <message>
        <source>dps-s COMMAND --help tells more.</source>
        <translation>详见 dps-s COMMAND --help。</translation>
    </message>
    <message>
        <source>echo</source>
        <translation>回显</translation>
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
        <translation>在第一个状态之后 S 秒结束</translation>
    </message>
    <message>
        <source>explain captured bytes</source>
        <translation>解释捕获的字节</translation>
    </message>
    <message>
        <source>external power is connected</source>
        <translation>外接供电已接通</translation>
    </message>
    <message>
        <source>faults of the line</source>
        <translation>线路故障</translation>
    </message>
    <message>
        <source>find the baud rate at which a module answers</source>
        <translation>查找模块应答的波特率</translation>
    </message>
    <message>
        <source>for example serial_output=false</source>
        <translation>例如 serial_output=false</translation>
    </message>
    <message>
        <source>forbid deploying over serial</source>
        <translation>禁止串口触发开伞</translation>
    </message>
    <message>
        <source>forces settings into the vendor's advice and acknowledges what it kept</source>
        <translation>将设置限制在厂家建议范围内，并以实际保存值应答</translation>
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
        <translation>按住模块开关 2 秒：若已关机则开机</translation>
    </message>
    <message>
        <source>host</source>
        <translation>上位机</translation>
    </message>
    <message>
        <source>how it is now</source>
        <translation>显示当前状态</translation>
    </message>
    <message>
        <source>how it is reached</source>
        <translation>连接方式</translation>
    </message>
    <message>
        <source>in one go</source>
        <translation>一次发完</translation>
    </message>
    <message>
        <source>in pieces</source>
        <translation>拆成片段</translation>
    </message>
    <message>
        <source>it does not fire: it is locked, forbidden or off</source>
        <translation>未触发：模块已锁定、被禁止触发或已关机</translation>
    </message>
    <message>
        <source>it wobbles a few degrees, as in the wind</source>
        <translation>像在风中一样晃动几度</translation>
    </message>
    <message>
        <source>keeps the old setting and acknowledges that</source>
        <translation>保留旧设置，并以旧值应答</translation>
    </message>
    <message>
        <source>language of the window: {names}</source>
        <translation>窗口语言：{names}</translation>
    </message>
    <message>
        <source>late</source>
        <translation>迟到</translation>
    </message>
    <message>
        <source>lay it at this angle</source>
        <translation>将模块倾斜到该角度</translation>
    </message>
    <message>
        <source>left out</source>
        <translation>不发送</translation>
    </message>
    <message>
        <source>let it fall, from 20 m unless told</source>
        <translation>让模块坠落，默认高度 20 m</translation>
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
        <translation>链路</translation>
    </message>
    <message>
        <source>list the serial ports</source>
        <translation>列出串口</translation>
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
        <translation>新</translation>
    </message>
    <message>
        <source>nine records, in awkward pieces</source>
        <translation>九条记录，拆成零碎的片段发送</translation>
    </message>
    <message>
        <source>no</source>
        <translation>否</translation>
    </message>
    <message>
        <source>no answer within {seconds:.2f} s, asked {n} times</source>
        <translation>{seconds:.2f} 秒内无应答，共询问 {n} 次</translation>
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
        <translation>模拟模块没有可用的端口：{reason}</translation>
    </message>
    <message>
        <source>no reply to the set, and the value is not what was sent</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>no reply within {seconds:.1f} s, asked once</source>
        <translation>{seconds:.1f} 秒内无应答，已询问 1 次</translation>
    </message>
    <message>
        <source>no reply within {seconds:.1f} s, asked {attempts} times</source>
        <translation>{seconds:.1f} 秒内无应答，已询问 {attempts} 次</translation>
    </message>
    <message>
        <source>no reply within {seconds:.1f} s; it may have been carried out</source>
        <translation>{seconds:.1f} 秒内无应答；命令可能已被执行</translation>
    </message>
    <message>
        <source>no reply; it may have been carried out</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>no serial number</source>
        <translation>无序列号</translation>
    </message>
    <message>
        <source>no stream</source>
        <translation>无数据流</translation>
    </message>
    <message>
        <source>no such command: {codes}</source>
        <translation>没有该命令：{codes}</translation>
    </message>
    <message>
        <source>no: acknowledges settings and does not keep them</source>
        <translation>no：应答设置但不保存</translation>
    </message>
    <message>
        <source>no: bytes take no time on the line</source>
        <translation>no：字节在线路上不占用时间</translation>
    </message>
    <message>
        <source>no: locked, in standby</source>
        <translation>否：已锁定，待机</translation>
    </message>
    <message>
        <source>noise of the sensors: 0 none, 1 usual</source>
        <translation>传感器噪声：0 无，1 正常</translation>
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
        <translation>不应答</translation>
    </message>
    <message>
        <source>not asked: the module stopped answering</source>
        <translation>未询问：模块不再应答</translation>
    </message>
    <message>
        <source>not charging</source>
        <translation>未充电</translation>
    </message>
    <message>
        <source>not connected</source>
        <translation>未连接</translation>
    </message>
    <message>
        <source>not read: the module restarted again and again</source>
        <translation>未读取：模块反复重启</translation>
    </message>
    <message>
        <source>not read: the port was lost</source>
        <translation>未读取：串口已断开</translation>
    </message>
    <message>
        <source>not sent: the module did not answer the heartbeat before it</source>
        <translation>未发送：模块未应答此前的心跳</translation>
    </message>
    <message>
        <source>not sent: the module stopped answering</source>
        <translation>未发送：模块不再应答</translation>
    </message>
    <message>
        <source>not triggered</source>
        <translation>未触发</translation>
    </message>
    <message>
        <source>nothing that the module sends comes through</source>
        <translation>模块发送的内容全部丢失</translation>
    </message>
    <message>
        <source>now</source>
        <translation>现在</translation>
    </message>
    <message>
        <source>off</source>
        <translation>关</translation>
    </message>
    <message>
        <source>offline</source>
        <translation>离线</translation>
    </message>
    <message>
        <source>on: it streams</source>
        <translation>开：正在持续输出</translation>
    </message>
    <message>
        <source>one bit each: 01 serial, 02 attitude, 04 PWM, 08 free fall</source>
        <translation>每位一个来源：01 串口，02 姿态，04 PWM，08 失重</translation>
    </message>
    <message>
        <source>one by one</source>
        <translation>逐条发送</translation>
    </message>
    <message>
        <source>one of {rates} is needed</source>
        <translation>需要以下值之一：{rates}</translation>
    </message>
    <message>
        <source>one of {values} is needed</source>
        <translation>需要以下值之一：{values}</translation>
    </message>
    <message>
        <source>only these can be changed: {names}</source>
        <translation>只能更改以下选项：{names}</translation>
    </message>
    <message>
        <source>open or close the parachute bay</source>
        <translation>打开或关闭伞仓</translation>
    </message>
    <message>
        <source>open the window</source>
        <translation>打开窗口</translation>
    </message>
    <message>
        <source>over {value}°</source>
        <translation>超过 {value}°</translation>
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
        <translation>物理环境</translation>
    </message>
    <message>
        <source>plug or unplug external power</source>
        <translation>接通或断开外接供电</translation>
    </message>
    <message>
        <source>plug the serial adapter in again</source>
        <translation>重新插入串口适配器</translation>
    </message>
    <message>
        <source>plugged in again: {address}</source>
        <translation>已重新插入：{address}</translation>
    </message>
    <message>
        <source>polled</source>
        <translation>轮询</translation>
    </message>
    <message>
        <source>port lost</source>
        <translation>串口丢失</translation>
    </message>
    <message>
        <source>print JSON and nothing else on standard output</source>
        <translation>标准输出只输出 JSON</translation>
    </message>
    <message>
        <source>print the status as it comes</source>
        <translation>持续输出状态</translation>
    </message>
    <message>
        <source>print the version</source>
        <translation>显示版本</translation>
    </message>
    <message>
        <source>prints the port to open, for example /dev/pts/5</source>
        <translation>打印要打开的串口，例如 /dev/pts/5</translation>
    </message>
    <message>
        <source>pull the serial adapter, for good or for some seconds</source>
        <translation>拔出串口适配器，一直拔出或只拔出若干秒</translation>
    </message>
    <message>
        <source>query: {name}</source>
        <translation>查询：{name}</translation>
    </message>
    <message>
        <source>read everything that can be read</source>
        <translation>读取全部可读内容</translation>
    </message>
    <message>
        <source>read the trigger records</source>
        <translation>读取触发记录</translation>
    </message>
    <message>
        <source>reconnected</source>
        <translation>已重新连接</translation>
    </message>
    <message>
        <source>records: {count}</source>
        <translation>记录：{count}</translation>
    </message>
    <message>
        <source>rejected</source>
        <translation>拒收</translation>
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
        <source>restarted</source>
        <translation>已重启</translation>
    </message>
    <message>
        <source>run a simulated module</source>
        <translation>运行模拟模块</translation>
    </message>
    <message>
        <source>run the window for S seconds, then end it</source>
        <translation>窗口运行 S 秒后结束</translation>
    </message>
    <message>
        <source>seconds since it was switched on; 0 lets the two heartbeats be seen</source>
        <translation>已开机的秒数；0 可看到两次开机心跳</translation>
    </message>
    <message>
        <source>seconds since power-on, high byte first</source>
        <translation>开机后的秒数，高位在前</translation>
    </message>
    <message>
        <source>seed of faults, noise and history: the same seed, the same run</source>
        <translation>故障、噪声和记录的随机种子：种子相同，过程相同</translation>
    </message>
    <message>
        <source>sensor zeroed</source>
        <translation>传感器已置零</translation>
    </message>
    <message>
        <source>sent</source>
        <translation>发送</translation>
    </message>
    <message>
        <source>sent as 00</source>
        <translation>以 00 发送</translation>
    </message>
    <message>
        <source>sent as FF</source>
        <translation>以 FF 发送</translation>
    </message>
    <message>
        <source>sent, not confirmed within {seconds:.2f} s: it may have been carried out</source>
        <translation>已发送，{seconds:.2f} 秒内未确认：可能已执行</translation>
    </message>
    <message>
        <source>sent, {n}.</source>
        <translation>发送，第 {n} 次</translation>
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
        <translation>序列号 {number}</translation>
    </message>
    <message>
        <source>serial output is on after every start</source>
        <translation>每次开机后串口输出即开启</translation>
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
        <translation>串口输出：正常输出、只应答不输出，或不应答</translation>
    </message>
    <message>
        <source>set the cell voltage</source>
        <translation>设置电芯电压</translation>
    </message>
    <message>
        <source>set {name} to {value}</source>
        <translation>将{name}设置为 {value}</translation>
    </message>
    <message>
        <source>share of answers that come twice</source>
        <translation>重复发送的应答比例</translation>
    </message>
    <message>
        <source>share of answers with random bytes before them</source>
        <translation>前面带有随机字节的应答比例</translation>
    </message>
    <message>
        <source>share of bytes with one bit turned</source>
        <translation>有一位翻转的字节比例</translation>
    </message>
    <message>
        <source>share of single bytes that vanish</source>
        <translation>单个字节丢失的比例</translation>
    </message>
    <message>
        <source>share of whole requests and answers that vanish, 0 to 1</source>
        <translation>整条请求和应答丢失的比例，0 到 1</translation>
    </message>
    <message>
        <source>shut the module down</source>
        <translation>模块关机</translation>
    </message>
    <message>
        <source>status frames a second while serial output is on, 1 to 1440</source>
        <translation>串口输出开启时每秒的状态帧数，1 到 1440</translation>
    </message>
    <message>
        <source>status: tilt {tilt}°, {acceleration:.1f} g, {triggered}, {active}</source>
        <translation>状态：倾角 {tilt}°，{acceleration:.1f} g，{triggered}，{active}</translation>
    </message>
    <message>
        <source>stream</source>
        <translation>串口输出</translation>
    </message>
    <message>
        <source>streamed</source>
        <translation>主动输出</translation>
    </message>
    <message>
        <source>switch a fault on; none ends all</source>
        <translation>打开一种故障；none 结束所有故障</translation>
    </message>
    <message>
        <source>switch it off and on</source>
        <translation>关机后再开机</translation>
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
        <translation>指向伪终端的符号链接</translation>
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
        <translation>上位机发送的字节被回送</translation>
    </message>
    <message>
        <source>the module acknowledged it and did not keep it</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>the module answered {raw} instead</source>
        <translation>模块的应答却是 {raw}</translation>
    </message>
    <message>
        <source>the module answers: online</source>
        <translation>模块应答：在线</translation>
    </message>
    <message>
        <source>the module gives different answers to the same question</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>the module keeps another value than the one that was sent</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>the module probably restarted</source>
        <translation>模块可能已重新启动</translation>
    </message>
    <message>
        <source>the module refused it and keeps the old value</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>the module restarted</source>
        <translation>模块已重新启动</translation>
    </message>
    <message>
        <source>the module restarted in the middle; what stands is not known</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>the name of the port is empty</source>
        <translation>串口名为空</translation>
    </message>
    <message>
        <source>the parachute bay is open</source>
        <translation>伞仓已打开</translation>
    </message>
    <message>
        <source>the port was lost; it may have been carried out</source>
        <translation>串口已断开；命令可能已被执行</translation>
    </message>
    <message>
        <source>the simulated module has no option {name}</source>
        <translation>模拟模块没有选项 {name}</translation>
    </message>
    <message>
        <source>the value</source>
        <translation>设置值</translation>
    </message>
    <message>
        <source>the value could not be read back</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>then leave a screenshot and the values seen in this folder</source>
        <translation>然后在此文件夹中留下截图和所见数值</translation>
    </message>
    <message>
        <source>tilt, 1°</source>
        <translation>倾角，1°</translation>
    </message>
    <message>
        <source>to the host</source>
        <translation>发往上位机</translation>
    </message>
    <message>
        <source>to the module</source>
        <translation>发往模块</translation>
    </message>
    <message>
        <source>trigger by its PWM input</source>
        <translation>通过 PWM 输入触发</translation>
    </message>
    <message>
        <source>trigger ended</source>
        <translation>触发结束</translation>
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
        <translation>已有的触发记录条数，0 到 9</translation>
    </message>
    <message>
        <source>triggered</source>
        <translation>已触发</translation>
    </message>
    <message>
        <source>unasked</source>
        <translation>主动</translation>
    </message>
    <message>
        <source>unknown</source>
        <translation>未知</translation>
    </message>
    <message>
        <source>unknown (cannot be read)</source>
        <translation>未知（无法读取）</translation>
    </message>
    <message>
        <source>unknown ({why})</source>
        <translation>未知（{why}）</translation>
    </message>
    <message>
        <source>unknown command code {code}</source>
        <translation>未知命令码 {code}</translation>
    </message>
    <message>
        <source>up to this much more delay, at random</source>
        <translation>随机增加的延迟上限</translation>
    </message>
    <message>
        <source>usage: {usage}</source>
        <translation>用法：{usage}</translation>
    </message>
    <message>
        <source>used last</source>
        <translation>上次使用</translation>
    </message>
    <message>
        <source>value {value} is not one that the table allows for {code}</source>
        <translation>数值 {value} 不是协议表允许命令 {code} 使用的值</translation>
    </message>
    <message>
        <source>volts that the cell loses in an hour</source>
        <translation>电芯每小时下降的电压（V）</translation>
    </message>
    <message>
        <source>which way the five above apply</source>
        <translation>以上五项作用的方向</translation>
    </message>
    <message>
        <source>without a screen</source>
        <translation>没有屏幕时</translation>
    </message>
    <message>
        <source>wobble a few degrees, or lie still</source>
        <translation>晃动几度，或静止不动</translation>
    </message>
    <message>
        <source>write a CSV file; - prints it</source>
        <translation>写入 CSV 文件；- 表示直接输出</translation>
    </message>
    <message>
        <source>yes</source>
        <translation>是</translation>
    </message>
    <message>
        <source>yes or no is needed</source>
        <translation>需要 yes 或 no</translation>
    </message>
    <message>
        <source>yes: it fires by its thresholds</source>
        <translation>是：达到阈值即开伞</translation>
    </message>
    <message>
        <source>yes: it has fired</source>
        <translation>是：已开伞</translation>
    </message>
    <message>
        <source>zero the sensor</source>
        <translation>传感器置零</translation>
    </message>
    <message>
        <source>{address} is not HOST:PORT, such as 127.0.0.1:5000</source>
        <translation>{address} 不是 HOST:PORT 的形式，例如 127.0.0.1:5000</translation>
    </message>
    <message>
        <source>{count} slots are empty.</source>
        <translation>{count} 个存储位为空。</translation>
    </message>
    <message>
        <source>{count} trigger records written to {file}.</source>
        <translation>已将 {count} 条触发记录写入 {file}。</translation>
    </message>
    <message>
        <source>{file} cannot be written: {why}.</source>
        <translation>无法写入 {file}：{why}。</translation>
    </message>
    <message>
        <source>{ms} ms</source>
        <translation>{ms} 毫秒</translation>
    </message>
    <message>
        <source>{name} is given twice.</source>
        <translation>{name} 给了两次。</translation>
    </message>
    <message>
        <source>{name} {value}</source>
        <translation>{name} {value}</translation>
    </message>
    <message>
        <source>{name}: {why}.</source>
        <translation>{name}：{why}。</translation>
    </message>
    <message>
        <source>{n} bytes rejected</source>
        <translation>拒收 {n} 字节</translation>
    </message>
    <message>
        <source>{n} rows are selected.</source>
        <translation>已选 {n} 行。</translation>
    </message>
    <message>
        <source>{option}={value}: {reason}</source>
        <translation>{option}={value}：{reason}</translation>
    </message>
    <message>
        <source>{page} ({key})</source>
        <translation>{page}（{key}）</translation>
    </message>
    <message>
        <source>{path} exists and is no symbolic link; it is left alone</source>
        <translation>{path} 已存在且不是符号链接；未作改动</translation>
    </message>
    <message>
        <source>{port} cannot be used as a serial port.</source>
        <translation type="unfinished"></translation>
    </message>
    <message>
        <source>{port} does not open within {seconds:.0f} s.</source>
        <translation>{port} 在 {seconds:.0f} 秒内未能打开。</translation>
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
        <translation>每秒 {rate:.0f} 次</translation>
    </message>
    <message>
        <source>{rate} baud</source>
        <translation>波特率 {rate}</translation>
    </message>
    <message>
        <source>{rate} frames/s</source>
        <translation>{rate} 帧/秒</translation>
    </message>
    <message>
        <source>{rows} rows</source>
        <translation>{rows} 行</translation>
    </message>
    <message>
        <source>{rows} rows, held still; {more} more came</source>
        <translation>{rows} 行，已静止；又收到 {more} 行</translation>
    </message>
    <message>
        <source>{seconds:8.1f} s   tilt {tilt:3}°   {acceleration:4.1f} g   {triggered}   {active}</source>
        <translation>{seconds:8.1f} s   倾角 {tilt:3}°   {acceleration:4.1f} g   {triggered}   {active}</translation>
    </message>
    <message>
        <source>{text} (default: {default})</source>
        <translation>{text}（默认：{default}）</translation>
    </message>
    <message>
        <source>{text} (implausible)</source>
        <translation>{text}（不合理）</translation>
    </message>
    <message>
        <source>{text} is no number</source>
        <translation>{text} 不是数字</translation>
    </message>
    <message>
        <source>{time} ago</source>
        <translation>{time}前</translation>
    </message>
    <message>
        <source>{value:.0f} h</source>
        <translation>{value:.0f} 小时</translation>
    </message>
    <message>
        <source>{value:.0f} min</source>
        <translation>{value:.0f} 分钟</translation>
    </message>
    <message>
        <source>{value:.0f} s</source>
        <translation>{value:.0f} 秒</translation>
    </message>
    <message>
        <source>{value:.1f} s</source>
        <translation>{value:.1f} 秒</translation>
    </message>
    <message>
        <source>{value} g free fall</source>
        <translation>{value} g 失重</translation>
    </message>
    <message>
        <source>{value}: acknowledged (cannot be read back)</source>
        <translation>{value}：已确认（无法回读）</translation>
    </message>
    <message>
        <source>{value}: not acknowledged ({why})</source>
        <translation>{value}：未确认（{why}）</translation>
    </message>
    <message>
        <source>{value}° fires</source>
        <translation>{value}° 开伞</translation>
    </message>
    <message>
        <source>{value}° rearms</source>
        <translation>{value}° 复位</translation>
    </message>
    <message>
        <source>{volts:.2f} V</source>
        <translation>{volts:.2f} V</translation>
    </message>
    <message>
        <source>{volts:.2f} V, charge unknown</source>
        <translation>{volts:.2f} V，充电未知</translation>
    </message>
    <message>
        <source>{volts:.2f} V, charging</source>
        <translation>{volts:.2f} V，充电中</translation>
    </message>
    <message>
        <source>{word} is unknown; try: help</source>
        <translation>未知命令 {word}；请键入 help</translation>
    </message>
    <message>
        <source>“{name}” cannot be set; what can: {names}.</source>
        <translation>“{name}”无法设置；可以设置的有：{names}。</translation>
    </message>
    <message>
        <source>“{text}” is neither true nor false</source>
        <translation>“{text}”既不是 true 也不是 false</translation>
    </message>
    <message>
        <source>“{text}” is no number</source>
        <translation>“{text}”不是数字</translation>
    </message>
    <message>
        <source>“{text}” is no number of seconds above 0</source>
        <translation>“{text}”不是大于 0 的秒数</translation>
    </message>
    <message>
        <source>“{text}” is none of {rates} or auto</source>
        <translation>“{text}”不是 {rates} 之一，也不是 auto</translation>
    </message>
    <message>
        <source>“{word}” is no pair of hex digits; bytes look like 41 75 32, 417532 or 0x41,0x75.</source>
        <translation>“{word}”不是成对的十六进制数字；字节的写法如 41 75 32、417532 或 0x41,0x75。</translation>
    </message>
    <message>
        <source>“{word}” is not of the form NAME=VALUE.</source>
        <translation>“{word}”不是 NAME=VALUE 的形式。</translation>
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
