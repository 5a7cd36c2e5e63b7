<?xml version="1.0" encoding="utf-8"?>
<!DOCTYPE TS>
<TS version="2.1" language="zh_CN" sourcelanguage="en">
<context>
    <name>dps-s</name>
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
        <source>115200 (usual)</source>
        <translation>115200（常用）</translation>
    </message>
    <message>
        <source>55° or more.</source>
        <translation>55° 或以上。</translation>
    </message>
    <message>
        <source>95th percentile</source>
        <translation>第 95 百分位</translation>
    </message>
    <message>
        <source>A bad line loses or falsifies values.</source>
        <translation>线路不良会使数值缺失或错误。</translation>
    </message>
    <message>
        <source>A drifting sensor is loose or failing.</source>
        <translation>读数漂移说明传感器松动或失效。</translation>
    </message>
    <message>
        <source>A jolt may fire it.</source>
        <translation>颠簸即可能触发。</translation>
    </message>
    <message>
        <source>A module answers: leave it plugged in.</source>
        <translation>模块已应答：请勿拔下。</translation>
    </message>
    <message>
        <source>A parachute, its ejector and its cell age.</source>
        <translation>降落伞、弹射装置和电芯会老化。</translation>
    </message>
    <message>
        <source>A pause of the acceleration may hide a fall.</source>
        <translation>加速度中断期间可能坠落过。</translation>
    </message>
    <message>
        <source>A pause of the attitude of more than 0.2 s may hide a tilt.</source>
        <translation>姿态中断超过 0.2 s，其间可能倾斜过。</translation>
    </message>
    <message>
        <source>A weak cell may not deploy the parachute.</source>
        <translation>电芯电压过低可能无法开伞。</translation>
    </message>
    <message>
        <source>A wrong zero fires too early or too late.</source>
        <translation>零位错误会使触发过早或过晚。</translation>
    </message>
    <message>
        <source>ACTIVE during the test</source>
        <translation>测试期间变为激活</translation>
    </message>
    <message>
        <source>ACTIVE, not checked</source>
        <translation>已激活，未检查</translation>
    </message>
    <message>
        <source>ACTIVE, not locked.</source>
        <translation>已激活，未锁定。</translation>
    </message>
    <message>
        <source>ACTIVE; the check said READY</source>
        <translation>已激活；检查结论为“待激活”</translation>
    </message>
    <message>
        <source>ALTERED: this is not what was signed.</source>
        <translation>已被改动：内容与签名不符。</translation>
    </message>
    <message>
        <source>ARMED: {seconds:.0f} s.</source>
        <translation>已预备：{seconds:.0f} 秒。</translation>
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
        <source>Acceleration sensor {number} never rests at 1 g (median {median:.2f} g); not judged.</source>
        <translation>加速度传感器 {number} 静止时不为 1 g（中位数 {median:.2f} g），不判断。</translation>
    </message>
    <message>
        <source>Acceleration sensor {number} stuck for {seconds:.0f} s from {start:.1f} s; not judged.</source>
        <translation>加速度传感器 {number} 从 {start:.1f} s 起数值不变，持续 {seconds:.0f} s，不判断。</translation>
    </message>
    <message>
        <source>Acceleration sensors differ by over {limit:.1f} g for {seconds:.2f} s; not judged.</source>
        <translation>加速度传感器相差超过 {limit:.1f} g，持续 {seconds:.2f} s，不判断。</translation>
    </message>
    <message>
        <source>Acceleration: 1 g</source>
        <translation>加速度：1 g</translation>
    </message>
    <message>
        <source>Acceleration: steady</source>
        <translation>加速度：稳定</translation>
    </message>
    <message>
        <source>Acknowledged, cannot be read: {count}.</source>
        <translation>已应答，无法读取：{count} 项。</translation>
    </message>
    <message>
        <source>Acknowledged; for how long is unknown.</source>
        <translation>模块已应答；有效时长未知。</translation>
    </message>
    <message>
        <source>Acknowledged; the module is silent.</source>
        <translation>模块已应答，现无响应。</translation>
    </message>
    <message>
        <source>Activate</source>
        <translation>激活</translation>
    </message>
    <message>
        <source>Activate / lock</source>
        <translation>激活/锁定</translation>
    </message>
    <message>
        <source>Activated by</source>
        <translation>由谁激活</translation>
    </message>
    <message>
        <source>Activation</source>
        <translation>激活状态</translation>
    </message>
    <message>
        <source>Active?</source>
        <translation>是否激活</translation>
    </message>
    <message>
        <source>Adapter</source>
        <translation>适配器</translation>
    </message>
    <message>
        <source>Add port</source>
        <translation>添加串口</translation>
    </message>
    <message>
        <source>Add the port of each module.</source>
        <translation>添加每个模块的串口。</translation>
    </message>
    <message>
        <source>Address for readers</source>
        <translation>读取方的地址</translation>
    </message>
    <message>
        <source>After a real trigger the parachute is open.</source>
        <translation>真实触发后的数据是开伞后的数据。</translation>
    </message>
    <message>
        <source>After power-on</source>
        <translation>开机后时间</translation>
    </message>
    <message>
        <source>Against it: {what}.</source>
        <translation>不符之处：{what}。</translation>
    </message>
    <message>
        <source>Aircraft</source>
        <translation>飞行器</translation>
    </message>
    <message>
        <source>Airframe</source>
        <translation>机型</translation>
    </message>
    <message>
        <source>All</source>
        <translation>全部</translation>
    </message>
    <message>
        <source>All logs</source>
        <translation>全部日志</translation>
    </message>
    <message>
        <source>All modules</source>
        <translation>所有模块</translation>
    </message>
    <message>
        <source>Already armed: {what}.</source>
        <translation>已预备：{what}。</translation>
    </message>
    <message>
        <source>Altitude</source>
        <translation>高度</translation>
    </message>
    <message>
        <source>An active module fires when it tips over or falls.</source>
        <translation>激活的模块在倾覆或坠落时会开伞。</translation>
    </message>
    <message>
        <source>An address is HOST:PORT, such as 127.0.0.1:7001.</source>
        <translation>地址格式为 HOST:PORT，例如 127.0.0.1:7001。</translation>
    </message>
    <message>
        <source>An ordinary flight: it must not fire.</source>
        <translation>普通飞行：不得触发。</translation>
    </message>
    <message>
        <source>An unexplained trigger can happen again.</source>
        <translation>原因不明的触发可能再次发生。</translation>
    </message>
    <message>
        <source>Another module may answer from now on.</source>
        <translation>此后应答的可能是另一个模块。</translation>
    </message>
    <message>
        <source>Another module was said to be connected.</source>
        <translation>已说明连接了另一个模块。</translation>
    </message>
    <message>
        <source>Apply {count} ticked</source>
        <translation>应用 {count} 项</translation>
    </message>
    <message>
        <source>Approve these settings</source>
        <translation>认可这些参数</translation>
    </message>
    <message>
        <source>Archive of all stations…</source>
        <translation>所有站点的归档…</translation>
    </message>
    <message>
        <source>Arm</source>
        <translation>预备</translation>
    </message>
    <message>
        <source>Arm for 10 s</source>
        <translation>预备 10 秒</translation>
    </message>
    <message>
        <source>Arm, then hold for two seconds. Letting go, Esc or leaving the page sends nothing.</source>
        <translation>先预备，再按住两秒。松开、按 Esc 或离开本页则不发送。</translation>
    </message>
    <message>
        <source>Ask the administrator for access to serial ports.</source>
        <translation>请管理员授予串口访问权限。</translation>
    </message>
    <message>
        <source>Asking the module…</source>
        <translation>正在询问模块…</translation>
    </message>
    <message>
        <source>Assumed: LOCK, a restart or a 0.5 s pause ends a fall.</source>
        <translation>假定：锁定、重启或 0.5 s 无数据会中止坠落判断。</translation>
    </message>
    <message>
        <source>Assumed: activated while tilted, it fires at once.</source>
        <translation>假定：倾斜时激活会立即开伞。</translation>
    </message>
    <message>
        <source>Assumed: the threshold tilt fires, the threshold acceleration does not.</source>
        <translation>假定：倾角等于阈值触发，加速度等于阈值不触发。</translation>
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
        <source>Attitude trigger enabled</source>
        <translation>姿态触发已启用</translation>
    </message>
    <message>
        <source>Attitude: fires at its threshold, rearms 10° below.</source>
        <translation>姿态触发：达到阈值即触发，低于阈值 10° 复位。</translation>
    </message>
    <message>
        <source>Back</source>
        <translation>返回</translation>
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
        <source>Below it the module counts as falling.</source>
        <translation>低于此值时，模块判定为失重。</translation>
    </message>
    <message>
        <source>Below the threshold</source>
        <translation>低于阈值的时间</translation>
    </message>
    <message>
        <source>Beyond it the parachute counts as ejected.</source>
        <translation>越过此值即视为降落伞已出仓。</translation>
    </message>
    <message>
        <source>Bit errors</source>
        <translation>位翻转</translation>
    </message>
    <message>
        <source>Boot count</source>
        <translation>开机次数</translation>
    </message>
    <message>
        <source>Bytes</source>
        <translation>字节</translation>
    </message>
    <message>
        <source>Bytes (41 75) or words</source>
        <translation>字节（41 75）或文字</translation>
    </message>
    <message>
        <source>CHECKING</source>
        <translation>检查中</translation>
    </message>
    <message>
        <source>CONTRADICTS ITSELF: {parts}.</source>
        <translation>自相矛盾：{parts}。</translation>
    </message>
    <message>
        <source>Cancel</source>
        <translation>取消</translation>
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
        <source>Cell: last charge about {weeks} weeks before the last check.</source>
        <translation>电芯：最近一次充电约在上次检查前 {weeks} 周。</translation>
    </message>
    <message>
        <source>Cells that are no numbers: {count}, the first in line {line}: “{cell}”.</source>
        <translation>不是数字的单元格：{count} 个，第一个在第 {line} 行：“{cell}”。</translation>
    </message>
    <message>
        <source>Change now</source>
        <translation>立即更改</translation>
    </message>
    <message>
        <source>Change the baud rate</source>
        <translation>修改波特率</translation>
    </message>
    <message>
        <source>Changed: {what}.</source>
        <translation>已变化：{what}。</translation>
    </message>
    <message>
        <source>Changing the baud rate…</source>
        <translation>正在更改波特率…</translation>
    </message>
    <message>
        <source>Charge it, unplug it, wait a minute.</source>
        <translation>充电，断开外接供电，等一分钟。</translation>
    </message>
    <message>
        <source>Charger</source>
        <translation>外接供电</translation>
    </message>
    <message>
        <source>Charger disconnected</source>
        <translation>充电器已断开</translation>
    </message>
    <message>
        <source>Charging</source>
        <translation>充电状态</translation>
    </message>
    <message>
        <source>Check</source>
        <translation>检查项目</translation>
    </message>
    <message>
        <source>Check again</source>
        <translation>重新检查</translation>
    </message>
    <message>
        <source>Check again: {why}</source>
        <translation>请重新检查：{why}</translation>
    </message>
    <message>
        <source>Check cable and power.</source>
        <translation>检查线缆和电源。</translation>
    </message>
    <message>
        <source>Check its power and cable, then do it again.</source>
        <translation>请检查其供电和线缆，然后重试。</translation>
    </message>
    <message>
        <source>Check its power and cable; hold its switch for 2 s.</source>
        <translation>请检查供电和线缆，并长按开关 2 s。</translation>
    </message>
    <message>
        <source>Check only</source>
        <translation>仅检查</translation>
    </message>
    <message>
        <source>Check plugs, ground and cable length.</source>
        <translation>检查插头、地线和线缆长度。</translation>
    </message>
    <message>
        <source>Check power, ground and crossed TX and RX, or find the baud rate.</source>
        <translation>请检查供电、地线和 TX/RX 是否交叉，或查找波特率。</translation>
    </message>
    <message>
        <source>Check power, ground and crossed TX and RX.</source>
        <translation>请检查供电、地线和 TX/RX 是否交叉。</translation>
    </message>
    <message>
        <source>Check selected</source>
        <translation>检查所选模块</translation>
    </message>
    <message>
        <source>Check the address, and the baud rate in the program that offers the port.</source>
        <translation>请检查地址，以及提供该串口的程序中的波特率。</translation>
    </message>
    <message>
        <source>Check the address, the baud rate at the other end, and the module's power and wires.</source>
        <translation>请检查地址、对端的波特率，以及模块的供电和接线。</translation>
    </message>
    <message>
        <source>Check the network and the program that offers the port, then connect again.</source>
        <translation>请检查网络和提供该串口的程序，然后重新连接。</translation>
    </message>
    <message>
        <source>Check the wire to the module's RX.</source>
        <translation>请检查连到模块 RX 的线。</translation>
    </message>
    <message>
        <source>Check the wiring: TX and RX touch, or no module is connected.</source>
        <translation>请检查接线：TX 与 RX 短接，或未连接模块。</translation>
    </message>
    <message>
        <source>Checked by</source>
        <translation>检查人</translation>
    </message>
    <message>
        <source>Checks</source>
        <translation>检查项目</translation>
    </message>
    <message>
        <source>Choose a port</source>
        <translation>选择串口</translation>
    </message>
    <message>
        <source>Choose a port.</source>
        <translation>请选择串口。</translation>
    </message>
    <message>
        <source>Choose an entry for its settings, or two with Ctrl to compare them.</source>
        <translation>选择一条记录查看其参数，按住 Ctrl 选择两条进行比较。</translation>
    </message>
    <message>
        <source>Choose logs, then press N or M.</source>
        <translation>选中日志，按 N 或 M。</translation>
    </message>
    <message>
        <source>Choose one column for “{quantity}”.</source>
        <translation>请为“{quantity}”选择一列。</translation>
    </message>
    <message>
        <source>Clear</source>
        <translation>清空</translation>
    </message>
    <message>
        <source>Close</source>
        <translation>关闭</translation>
    </message>
    <message>
        <source>Close it and connect again.</source>
        <translation>请关闭该程序后重新连接。</translation>
    </message>
    <message>
        <source>Close it, or type: {command} — then plug the adapter in again.</source>
        <translation>请关闭该程序，或输入：{command}，然后重新插入适配器。</translation>
    </message>
    <message>
        <source>Close the bay</source>
        <translation>关闭伞仓</translation>
    </message>
    <message>
        <source>Close the bay, or measure the light threshold.</source>
        <translation>关闭伞仓，或测量光线阈值。</translation>
    </message>
    <message>
        <source>Closed and open bay read too much alike: check the sensor.</source>
        <translation>伞仓关闭与打开的读数过于接近：请检查传感器。</translation>
    </message>
    <message>
        <source>Columns</source>
        <translation>列</translation>
    </message>
    <message>
        <source>Commands</source>
        <translation>命令</translation>
    </message>
    <message>
        <source>Confirm again.</source>
        <translation>请重新确认。</translation>
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
        <source>Connect again. If it fails, save a support bundle (Diagnosis).</source>
        <translation>请重新连接。如仍失败，请在“诊断”页保存诊断包。</translation>
    </message>
    <message>
        <source>Connect all ports</source>
        <translation>连接所有串口</translation>
    </message>
    <message>
        <source>Connect or choose a module.</source>
        <translation>请连接或选择模块。</translation>
    </message>
    <message>
        <source>Connecting reads the module; Live also switches its serial output on.</source>
        <translation>连接时读取模块数据；“实时”页面还会打开其串口输出。</translation>
    </message>
    <message>
        <source>Connection</source>
        <translation>连接</translation>
    </message>
    <message>
        <source>Contents</source>
        <translation>内容</translation>
    </message>
    <message>
        <source>Contradictory answers. Two modules on this line?</source>
        <translation>应答互相矛盾。此线路上有两个模块吗？</translation>
    </message>
    <message>
        <source>Copied.</source>
        <translation>已复制。</translation>
    </message>
    <message>
        <source>Copy</source>
        <translation>复制</translation>
    </message>
    <message>
        <source>Could not read the tilt: check it.</source>
        <translation>无法读取倾角：请检查。</translation>
    </message>
    <message>
        <source>Could not read: {names}. Read again or check the wiring.</source>
        <translation>无法读取：{names}。请重新读取或检查接线。</translation>
    </message>
    <message>
        <source>Fires at rest (1 g), after the free-fall time.</source>
        <translation>静止（1 g）时，失重时间一到也会开伞。</translation>
    </message>
    <message>
        <source>Free fall: below {limit:.1f} g; at rest 1 g.</source>
        <translation>低于 {limit:.1f} g 判定为失重；静止时为 1 g。</translation>
    </message>
    <message>
        <source>DPS-S Configurator</source>
        <translation>DPS-S 上位机</translation>
    </message>
    <message>
        <source>Damaged frames: {rejected} of {bytes} bytes are invalid.</source>
        <translation>帧受损：{bytes} 字节中有 {rejected} 字节无效。</translation>
    </message>
    <message>
        <source>Damaged or altered; left out from {time} on.</source>
        <translation>已损坏或被改动；从 {time} 起略去。</translation>
    </message>
    <message>
        <source>Damaged; bytes left out: {count}.</source>
        <translation>已损坏；略去字节数：{count}。</translation>
    </message>
    <message>
        <source>Dark mode</source>
        <translation>深色</translation>
    </message>
    <message>
        <source>Default</source>
        <translation>默认</translation>
    </message>
    <message>
        <source>Default {value}</source>
        <translation>默认 {value}</translation>
    </message>
    <message>
        <source>Delete for good</source>
        <translation>永久删除</translation>
    </message>
    <message>
        <source>Delete for good? {what}</source>
        <translation>永久删除？{what}</translation>
    </message>
    <message>
        <source>Delete…</source>
        <translation>删除…</translation>
    </message>
    <message>
        <source>Deleting…</source>
        <translation>正在删除…</translation>
    </message>
    <message>
        <source>Deploy</source>
        <translation>触发开伞</translation>
    </message>
    <message>
        <source>Deploy over serial</source>
        <translation>串口触发开伞</translation>
    </message>
    <message>
        <source>Diagnosis</source>
        <translation>诊断</translation>
    </message>
    <message>
        <source>Disabled</source>
        <translation>已禁用</translation>
    </message>
    <message>
        <source>Disarmed: {why}. Nothing was sent.</source>
        <translation>已解除：{why}。未发送任何内容。</translation>
    </message>
    <message>
        <source>Disarms in</source>
        <translation>剩余时间</translation>
    </message>
    <message>
        <source>Discard all</source>
        <translation>全部放弃</translation>
    </message>
    <message>
        <source>Discard edits</source>
        <translation>放弃修改</translation>
    </message>
    <message>
        <source>Discard this edit</source>
        <translation>放弃此项修改</translation>
    </message>
    <message>
        <source>Disconnect</source>
        <translation>断开</translation>
    </message>
    <message>
        <source>Do it again.</source>
        <translation>请重试。</translation>
    </message>
    <message>
        <source>Do it, and keep it in the archive: Service…</source>
        <translation>请执行维护，并在归档的“维护…”中记录。</translation>
    </message>
    <message>
        <source>Do not change it.</source>
        <translation>不要更改。</translation>
    </message>
    <message>
        <source>Do not touch the aircraft.</source>
        <translation>请勿触碰飞行器。</translation>
    </message>
    <message>
        <source>Do not touch the aircraft; check the mounting.</source>
        <translation>不要触碰飞行器；检查模块的固定。</translation>
    </message>
    <message>
        <source>Done by</source>
        <translation>执行人</translation>
    </message>
    <message>
        <source>Done on</source>
        <translation>日期</translation>
    </message>
    <message>
        <source>Dropped: it does not read.</source>
        <translation>已断开：不读取数据。</translation>
    </message>
    <message>
        <source>Dropped: too many readers.</source>
        <translation>已断开：读取者过多。</translation>
    </message>
    <message>
        <source>Due</source>
        <translation>到期</translation>
    </message>
    <message>
        <source>Due again on</source>
        <translation>下次日期</translation>
    </message>
    <message>
        <source>Duration</source>
        <translation>时长</translation>
    </message>
    <message>
        <source>Earlier values no longer count.</source>
        <translation>之前的数据不再有效。</translation>
    </message>
    <message>
        <source>Echoed frames</source>
        <translation>回显帧</translation>
    </message>
    <message>
        <source>Edit profile…</source>
        <translation>编辑配置文件…</translation>
    </message>
    <message>
        <source>Ejector</source>
        <translation>弹射装置</translation>
    </message>
    <message>
        <source>Ejector and rotors are off</source>
        <translation>弹射装置和桨叶均已拆下</translation>
    </message>
    <message>
        <source>Empty slots: {count}.</source>
        <translation>空位：{count} 个。</translation>
    </message>
    <message>
        <source>Enable now</source>
        <translation>立即启用</translation>
    </message>
    <message>
        <source>Enable the attitude trigger.</source>
        <translation>启用姿态触发。</translation>
    </message>
    <message>
        <source>Enable triggers and check</source>
        <translation>启用触发并检查</translation>
    </message>
    <message>
        <source>Ended after {seconds:.0f} s.</source>
        <translation>{seconds:.0f} 秒后结束。</translation>
    </message>
    <message>
        <source>Even locked, keep clear of its opening. Secure the loaded spring under the lid.</source>
        <translation>即使已锁定，也请远离伞仓开口。固定仓盖下的压缩弹簧。</translation>
    </message>
    <message>
        <source>Even locked, keep clear of its opening. Take the rotors off.</source>
        <translation>即使已锁定，也请远离伞仓开口。拆下桨叶。</translation>
    </message>
    <message>
        <source>Every session is recorded. Open or drop logs of PX4, ArduPilot, or CSV.</source>
        <translation>每次会话都自动记录。也可打开或拖入 PX4、ArduPilot 或 CSV 日志。</translation>
    </message>
    <message>
        <source>Exchange with a file…</source>
        <translation>与文件交换…</translation>
    </message>
    <message>
        <source>Exchanging…</source>
        <translation>正在同步…</translation>
    </message>
    <message>
        <source>Export report…</source>
        <translation>导出报告…</translation>
    </message>
    <message>
        <source>Exporting {name}</source>
        <translation>正在导出 {name}</translation>
    </message>
    <message>
        <source>Export…</source>
        <translation>导出…</translation>
    </message>
    <message>
        <source>External power</source>
        <translation>外接供电</translation>
    </message>
    <message>
        <source>FAILED</source>
        <translation>不通过</translation>
    </message>
    <message>
        <source>Failed: {why}.</source>
        <translation>操作失败：{why}。</translation>
    </message>
    <message>
        <source>Fall</source>
        <translation>坠落</translation>
    </message>
    <message>
        <source>File of {time}</source>
        <translation>文件时间 {time}</translation>
    </message>
    <message>
        <source>Files</source>
        <translation>文件</translation>
    </message>
    <message>
        <source>Filter</source>
        <translation>筛选</translation>
    </message>
    <message>
        <source>Find out why (Triggers), repack, lock and restart.</source>
        <translation>查明原因（触发记录），重新叠伞装仓，锁定并重启。</translation>
    </message>
    <message>
        <source>Find the baud rate</source>
        <translation>查找波特率</translation>
    </message>
    <message>
        <source>Fired. Find out why (Triggers), repack, restart.</source>
        <translation>已开伞。查明原因（触发记录），重新叠伞装仓后重启。</translation>
    </message>
    <message>
        <source>Fired. Treat it as ready to fire until it reports LOCKED.</source>
        <translation>已开伞。在其上报“已锁定”之前，请视为随时可能开伞。</translation>
    </message>
    <message>
        <source>Fires as soon as it is activated.</source>
        <translation>一激活就会开伞。</translation>
    </message>
    <message>
        <source>Fires at {fires:.0f}° and never rearms.</source>
        <translation>在 {fires:.0f}° 开伞，且不会复位。</translation>
    </message>
    <message>
        <source>Fires at {fires:.0f}°, rearms at {rearms:.0f}°.</source>
        <translation>在 {fires:.0f}° 开伞，在 {rearms:.0f}° 复位。</translation>
    </message>
    <message>
        <source>Fires at {time}: {why}</source>
        <translation>{time} 触发：{why}</translation>
    </message>
    <message>
        <source>Fires by itself in free fall.</source>
        <translation>失重时自动开伞。</translation>
    </message>
    <message>
        <source>Fires by itself when it tips over.</source>
        <translation>翻倒时自动开伞。</translation>
    </message>
    <message>
        <source>Fires only upside down, at {fires:.0f}°; rearms at {rearms:.0f}°.</source>
        <translation>仅在倒扣时开伞（{fires:.0f}°）；在 {rearms:.0f}° 复位。</translation>
    </message>
    <message>
        <source>Fires the parachute.</source>
        <translation>降落伞将弹出。</translation>
    </message>
    <message>
        <source>Fires the parachute; 00 forbids it, for an unknown time.</source>
        <translation>触发开伞；00 为禁止触发，时长未知。</translation>
    </message>
    <message>
        <source>Fires, {direction}</source>
        <translation>触发角度，{direction}</translation>
    </message>
    <message>
        <source>Firmware</source>
        <translation>固件</translation>
    </message>
    <message>
        <source>First say that it is {module}.</source>
        <translation>请先确认它是 {module}。</translation>
    </message>
    <message>
        <source>First seen {time}</source>
        <translation>首次读取于 {time}</translation>
    </message>
    <message>
        <source>Fleet</source>
        <translation>多模块</translation>
    </message>
    <message>
        <source>Folder</source>
        <translation>文件夹</translation>
    </message>
    <message>
        <source>Forbid serial trigger</source>
        <translation>禁止串口触发</translation>
    </message>
    <message>
        <source>Frames</source>
        <translation>帧</translation>
    </message>
    <message>
        <source>Free fall below</source>
        <translation>失重加速度</translation>
    </message>
    <message>
        <source>Free fall: fires after the free-fall time below its threshold.</source>
        <translation>失重触发：低于阈值的时间达到失重时间即触发。</translation>
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
        <source>Free-fall trigger enabled</source>
        <translation>失重触发已启用</translation>
    </message>
    <message>
        <source>GO</source>
        <translation>可以飞行</translation>
    </message>
    <message>
        <source>Guided test {test}: {verdict}.</source>
        <translation>引导测试“{test}”：{verdict}。</translation>
    </message>
    <message>
        <source>Guided tests</source>
        <translation>引导测试</translation>
    </message>
    <message>
        <source>Heartbeat</source>
        <translation>心跳</translation>
    </message>
    <message>
        <source>Help: {command}</source>
        <translation>帮助：{command}</translation>
    </message>
    <message>
        <source>Hold for 2 s</source>
        <translation>按住 2 秒</translation>
    </message>
    <message>
        <source>Hold it level, 50 cm above a cushion</source>
        <translation>水平握住，距软垫 50 cm</translation>
    </message>
    <message>
        <source>Hold it level.</source>
        <translation>保持水平。</translation>
    </message>
    <message>
        <source>Hold its switch for 2 s, or connect external power.</source>
        <translation>请长按开关 2 s，或接通外接供电。</translation>
    </message>
    <message>
        <source>Hold to DEPLOY</source>
        <translation>按住开伞</translation>
    </message>
    <message>
        <source>How long it falls before it fires.</source>
        <translation>失重持续多久才开伞。</translation>
    </message>
    <message>
        <source>How this is judged</source>
        <translation>如何判断</translation>
    </message>
    <message>
        <source>INTACT: {verdict}.</source>
        <translation>完整：{verdict}。</translation>
    </message>
    <message>
        <source>If it is new, say so.</source>
        <translation>若为新模块，请确认。</translation>
    </message>
    <message>
        <source>If it is not 1 g at rest, free fall is misjudged.</source>
        <translation>静止时若偏离 1 g，会误判失重。</translation>
    </message>
    <message>
        <source>If it is this module, add {option}.</source>
        <translation>如果就是这个模块，请加上 {option}。</translation>
    </message>
    <message>
        <source>Install a Chinese font (fonts-noto-cjk), then restart.</source>
        <translation>请安装中文字体（fonts-noto-cjk），然后重启本程序。</translation>
    </message>
    <message>
        <source>Interrupted at {time}: {why}</source>
        <translation>{time} 通信中断：{why}</translation>
    </message>
    <message>
        <source>Interrupted {count} times since {time}, last: {why}</source>
        <translation>自 {time} 起通信中断 {count} 次，最近一次：{why}</translation>
    </message>
    <message>
        <source>Interrupted: maybe at {rate} baud now.</source>
        <translation>已中断：可能已为 {rate} 波特。</translation>
    </message>
    <message>
        <source>Interrupted; may have been carried out.</source>
        <translation>已中断；命令可能已执行。</translation>
    </message>
    <message>
        <source>Interruption</source>
        <translation>通信中断</translation>
    </message>
    <message>
        <source>Invalid bytes</source>
        <translation>无效字节</translation>
    </message>
    <message>
        <source>Invalid samples left out: {count}.</source>
        <translation>略去无效采样：{count} 个。</translation>
    </message>
    <message>
        <source>Is it {module}?</source>
        <translation>是 {module} 吗？</translation>
    </message>
    <message>
        <source>It answered before: read its label, restart it and check again.</source>
        <translation>该模块此前有应答：核对标签，重启后再检查。</translation>
    </message>
    <message>
        <source>It cannot be printed: {why}.</source>
        <translation>无法打印：{why}。</translation>
    </message>
    <message>
        <source>It cannot be told which adapter is the same: choose the port.</source>
        <translation>无法判断哪个是原来的适配器：请选择串口。</translation>
    </message>
    <message>
        <source>It crashed: it must fire.</source>
        <translation>已坠机：必须触发。</translation>
    </message>
    <message>
        <source>It did not come to its end.</source>
        <translation>检查未完成。</translation>
    </message>
    <message>
        <source>It did not rearm: other directions not tested.</source>
        <translation>未复位：其他方向未测试。</translation>
    </message>
    <message>
        <source>It fired, or was told to, on {date}; no repack was entered since.</source>
        <translation>{date} 已触发或收到开伞指令；此后没有重新叠伞记录。</translation>
    </message>
    <message>
        <source>It fired. Level it slowly.</source>
        <translation>已触发。缓慢倾斜回水平。</translation>
    </message>
    <message>
        <source>It has never fired, or its memory was cleared.</source>
        <translation>从未触发，或记录已被清除。</translation>
    </message>
    <message>
        <source>It is being written: not deleted.</source>
        <translation>正在写入，未删除。</translation>
    </message>
    <message>
        <source>It is connected again as soon as the same adapter is back.</source>
        <translation>同一适配器恢复后将自动连接。</translation>
    </message>
    <message>
        <source>It is kept as recording {name}.</source>
        <translation>已保存为数据记录 {name}。</translation>
    </message>
    <message>
        <source>It is older than 15 minutes.</source>
        <translation>检查已超过 15 分钟。</translation>
    </message>
    <message>
        <source>It is safe</source>
        <translation>已确认安全</translation>
    </message>
    <message>
        <source>It is this module</source>
        <translation>是该模块</translation>
    </message>
    <message>
        <source>It is {module}</source>
        <translation>是 {module}</translation>
    </message>
    <message>
        <source>It is {module} all the same</source>
        <translation>仍确认是 {module}</translation>
    </message>
    <message>
        <source>It may be {module}: boot count and settings fit.</source>
        <translation>可能是 {module}：开机次数和参数相符。</translation>
    </message>
    <message>
        <source>It moves: {low:.0f}–{high:.0f}°, {weak:.1f}–{strong:.1f} g in 2 s.</source>
        <translation>模块未静止：2 秒内 {low:.0f}–{high:.0f}°，{weak:.1f}–{strong:.1f} g。</translation>
    </message>
    <message>
        <source>It must be due on a later day.</source>
        <translation>下次日期须晚于完成日期。</translation>
    </message>
    <message>
        <source>It reported TRIGGERED, or was told to fire before it had this name.</source>
        <translation>模块曾报告已触发，或在命名之前收到过开伞指令。</translation>
    </message>
    <message>
        <source>It was cancelled.</source>
        <translation>检查已取消。</translation>
    </message>
    <message>
        <source>It was checked again.</source>
        <translation>已重新检查。</translation>
    </message>
    <message>
        <source>It will FIRE four times: take off the ejector (pyro or spring) and the rotors.</source>
        <translation>模块将触发四次：请先拆下弹射装置（火工品或弹簧）和桨叶。</translation>
    </message>
    <message>
        <source>It would send {frame}.</source>
        <translation>正式执行时将发送 {frame}。</translation>
    </message>
    <message>
        <source>Judge it on the Triggers page.</source>
        <translation>在“触发记录”页面复核。</translation>
    </message>
    <message>
        <source>Judge its records, then close the notice.</source>
        <translation>请判定其记录，然后关闭提示。</translation>
    </message>
    <message>
        <source>Judged with: {values}</source>
        <translation>判定所用参数：{values}</translation>
    </message>
    <message>
        <source>Judged: {judgement}.</source>
        <translation>复核结果：{judgement}。</translation>
    </message>
    <message>
        <source>Keep away, LOCK again, restore the link; only then switch it off.</source>
        <translation>请远离模块，再次锁定并恢复通信，之后才可关机。</translation>
    </message>
    <message>
        <source>Kind</source>
        <translation>类别</translation>
    </message>
    <message>
        <source>LOCK ALL</source>
        <translation>全部锁定</translation>
    </message>
    <message>
        <source>LOCK again</source>
        <translation>再次锁定</translation>
    </message>
    <message>
        <source>LOCK first</source>
        <translation>先锁定</translation>
    </message>
    <message>
        <source>LOCK not confirmed: treat the module as ACTIVE. Sent when it answers.</source>
        <translation>锁定未确认：请按已激活对待该模块。模块应答后立即发送锁定。</translation>
    </message>
    <message>
        <source>LOCK sent {count}×, not confirmed: treat the module as ACTIVE.</source>
        <translation>锁定已发送 {count} 次，未确认：请视模块为已激活。</translation>
    </message>
    <message>
        <source>LOCK sent {count}×, not yet reported</source>
        <translation>锁定已发送 {count} 次，尚未上报</translation>
    </message>
    <message>
        <source>LOCK sent {count}×; the module still reports ACTIVE.</source>
        <translation>锁定已发送 {count} 次，模块仍上报已激活。</translation>
    </message>
    <message>
        <source>LOCK was not sent: treat the module as ACTIVE.</source>
        <translation>锁定命令未发送：请将模块视为已激活。</translation>
    </message>
    <message>
        <source>LOCK was sent after the interruption.</source>
        <translation>中断后已发送锁定。</translation>
    </message>
    <message>
        <source>LOCK {module}</source>
        <translation>锁定 {module}</translation>
    </message>
    <message>
        <source>Lag</source>
        <translation>链路延迟</translation>
    </message>
    <message>
        <source>Language</source>
        <translation>语言</translation>
    </message>
    <message>
        <source>Language and text size take effect at the next start.</source>
        <translation>语言和文字大小在下次启动时生效。</translation>
    </message>
    <message>
        <source>Largest tilt</source>
        <translation>最大倾角</translation>
    </message>
    <message>
        <source>Last check</source>
        <translation>上次检查</translation>
    </message>
    <message>
        <source>Last heard ACTIVE: treat it as ready to fire.</source>
        <translation>最后状态为已激活：请视为随时可能开伞。</translation>
    </message>
    <message>
        <source>Last invalid bytes</source>
        <translation>最近的无效字节</translation>
    </message>
    <message>
        <source>Late replies</source>
        <translation>延迟的应答</translation>
    </message>
    <message>
        <source>Leave it ACTIVE</source>
        <translation>保持激活</translation>
    </message>
    <message>
        <source>Leave it there</source>
        <translation>请勿移动</translation>
    </message>
    <message>
        <source>Leave only one module on this line, then do it again.</source>
        <translation>请在此线路上只留一个模块，然后重试。</translation>
    </message>
    <message>
        <source>Left out, unreadable or altered: {count}.</source>
        <translation>已略去（无法读取或被改动）：{count}。</translation>
    </message>
    <message>
        <source>Length of the time line</source>
        <translation>时间轴长度</translation>
    </message>
    <message>
        <source>Let it fall</source>
        <translation>松手落下</translation>
    </message>
    <message>
        <source>Light</source>
        <translation>光线</translation>
    </message>
    <message>
        <source>Light in the parachute bay: tells whether it is open.</source>
        <translation>伞仓内的光线：用于判断伞仓是否打开。</translation>
    </message>
    <message>
        <source>Light mode</source>
        <translation>浅色</translation>
    </message>
    <message>
        <source>Light threshold</source>
        <translation>光线阈值</translation>
    </message>
    <message>
        <source>Limit</source>
        <translation>要求</translation>
    </message>
    <message>
        <source>Limits</source>
        <translation>限值</translation>
    </message>
    <message>
        <source>Limits of this program: {least_tilt}° to {most_tilt}°, {least_force} g to {most_force} g, {least_fall:.2f} s to {most_fall:.2f} s.</source>
        <translation>本程序的范围：{least_tilt}° 至 {most_tilt}°、{least_force} g 至 {most_force} g、{least_fall:.2f} s 至 {most_fall:.2f} s。</translation>
    </message>
    <message>
        <source>Line {line} has {cells} cells, the head {names}: perhaps there are commas in its numbers.</source>
        <translation>第 {line} 行有 {cells} 个单元格，表头有 {names} 个：数字中可能含有逗号。</translation>
    </message>
    <message>
        <source>Line {number} is left out: no time, direction and bytes.</source>
        <translation>第 {number} 行已略过：没有时间、方向和字节。</translation>
    </message>
    <message>
        <source>Link</source>
        <translation>串口</translation>
    </message>
    <message>
        <source>Link lost. Nothing was sent.</source>
        <translation>通信中断。未发送任何内容。</translation>
    </message>
    <message>
        <source>Link: loss</source>
        <translation>链路：丢失</translation>
    </message>
    <message>
        <source>Link: response time</source>
        <translation>链路：响应时间</translation>
    </message>
    <message>
        <source>Live</source>
        <translation>实时</translation>
    </message>
    <message>
        <source>Load defaults</source>
        <translation>载入默认值</translation>
    </message>
    <message>
        <source>Lock</source>
        <translation>锁定</translation>
    </message>
    <message>
        <source>Lock it, enable the triggers, activate it again.</source>
        <translation>先锁定，启用触发，再重新激活。</translation>
    </message>
    <message>
        <source>Locking…</source>
        <translation>正在锁定…</translation>
    </message>
    <message>
        <source>Locks an activated module</source>
        <translation>锁定已激活的模块</translation>
    </message>
    <message>
        <source>Log</source>
        <translation>日志</translation>
    </message>
    <message>
        <source>Logs</source>
        <translation>日志</translation>
    </message>
    <message>
        <source>Longest fall</source>
        <translation>最长坠落</translation>
    </message>
    <message>
        <source>Look at the records</source>
        <translation>查看触发记录</translation>
    </message>
    <message>
        <source>Looking for ports…</source>
        <translation>正在查找串口…</translation>
    </message>
    <message>
        <source>Looking for thresholds…</source>
        <translation>正在计算阈值…</translation>
    </message>
    <message>
        <source>Looser than advised: {checks}.</source>
        <translation>限值比建议宽松：{checks}。</translation>
    </message>
    <message>
        <source>Lost replies</source>
        <translation>丢失的应答</translation>
    </message>
    <message>
        <source>MIT licence. Made with:</source>
        <translation>MIT 许可证。所用组件：</translation>
    </message>
    <message>
        <source>Made in the batch {batch}.</source>
        <translation>在批次 {batch} 中完成。</translation>
    </message>
    <message>
        <source>Maintenance</source>
        <translation>维护</translation>
    </message>
    <message>
        <source>Make sure that one module only is on this line; else do not fly.</source>
        <translation>请确认此线路上只有一个模块；否则不要飞行。</translation>
    </message>
    <message>
        <source>Make sure which module this is.</source>
        <translation>确认是哪个模块。</translation>
    </message>
    <message>
        <source>Manual checks</source>
        <translation>人工检查</translation>
    </message>
    <message>
        <source>Manufacturer</source>
        <translation>制造商</translation>
    </message>
    <message>
        <source>Mark as reviewed</source>
        <translation>标为已复核</translation>
    </message>
    <message>
        <source>Meaning</source>
        <translation>含义</translation>
    </message>
    <message>
        <source>Measure</source>
        <translation>测量</translation>
    </message>
    <message>
        <source>Measure in the light of the flight day, with no hand over the sensor.</source>
        <translation>请在飞行当天的光线下测量，手不要遮挡传感器。</translation>
    </message>
    <message>
        <source>Measure the light threshold</source>
        <translation>测量光线阈值</translation>
    </message>
    <message>
        <source>Measure which side of {limit:.1f} V means open.</source>
        <translation>请测量确认 {limit:.1f} V 的哪一侧表示打开。</translation>
    </message>
    <message>
        <source>Measured</source>
        <translation>实测</translation>
    </message>
    <message>
        <source>Measured values</source>
        <translation>测量值</translation>
    </message>
    <message>
        <source>Measuring the light</source>
        <translation>正在测量光线</translation>
    </message>
    <message>
        <source>Menu</source>
        <translation>菜单</translation>
    </message>
    <message>
        <source>Message</source>
        <translation>消息</translation>
    </message>
    <message>
        <source>Missing system libraries: {names}.</source>
        <translation>缺少系统库：{names}。</translation>
    </message>
    <message>
        <source>Module</source>
        <translation>模块</translation>
    </message>
    <message>
        <source>Modules</source>
        <translation>模块</translation>
    </message>
    <message>
        <source>More</source>
        <translation>更多</translation>
    </message>
    <message>
        <source>More light reading higher is assumed until it was measured with the bay closed and open.</source>
        <translation>在伞仓关闭和打开时测量之前，假定光线越强读数越高。</translation>
    </message>
    <message>
        <source>More light reads higher.</source>
        <translation>光线越强，读数越高。</translation>
    </message>
    <message>
        <source>More light reads lower.</source>
        <translation>光线越强，读数越低。</translation>
    </message>
    <message>
        <source>More messages</source>
        <translation>更多消息</translation>
    </message>
    <message>
        <source>More than a tenth of the acceleration is missing.</source>
        <translation>缺少超过十分之一的加速度。</translation>
    </message>
    <message>
        <source>More than a tenth of the samples was left out.</source>
        <translation>略去了超过十分之一的采样。</translation>
    </message>
    <message>
        <source>Mouse or space bar</source>
        <translation>鼠标或空格键</translation>
    </message>
    <message>
        <source>NO-GO</source>
        <translation>禁止飞行</translation>
    </message>
    <message>
        <source>NOT reported, treat as ACTIVE: {names}</source>
        <translation>未上报锁定，请按已激活对待：{names}</translation>
    </message>
    <message>
        <source>NOT verified ({why})</source>
        <translation>未验证（{why}）</translation>
    </message>
    <message>
        <source>Name</source>
        <translation>名称</translation>
    </message>
    <message>
        <source>Name it</source>
        <translation>命名</translation>
    </message>
    <message>
        <source>Name of the new folder</source>
        <translation>新文件夹的名称</translation>
    </message>
    <message>
        <source>Name the module to keep these records.</source>
        <translation>请给模块命名，以保存这些记录。</translation>
    </message>
    <message>
        <source>Name the module, then do the guided tests.</source>
        <translation>请给模块命名，然后做引导测试。</translation>
    </message>
    <message>
        <source>Name the module.</source>
        <translation>请给模块命名。</translation>
    </message>
    <message>
        <source>Name, date</source>
        <translation>姓名、日期</translation>
    </message>
    <message>
        <source>Never counts as falling: nothing is below 0 g.</source>
        <translation>永远不会判定为失重：加速度不可能低于 0 g。</translation>
    </message>
    <message>
        <source>Never tells an open bay from a closed one.</source>
        <translation>无法区分伞仓打开与关闭。</translation>
    </message>
    <message>
        <source>Never written: baud rate, serial output, an active module.</source>
        <translation>不写入：波特率、串口输出、已激活的模块。</translation>
    </message>
    <message>
        <source>New folder…</source>
        <translation>新建文件夹…</translation>
    </message>
    <message>
        <source>New profile…</source>
        <translation>新建配置文件…</translation>
    </message>
    <message>
        <source>New records are started.</source>
        <translation>将重新开始记录。</translation>
    </message>
    <message>
        <source>New value</source>
        <translation>目标值</translation>
    </message>
    <message>
        <source>New, no records</source>
        <translation>新模块，无记录</translation>
    </message>
    <message>
        <source>Next</source>
        <translation>下一步</translation>
    </message>
    <message>
        <source>Next step</source>
        <translation>下一步</translation>
    </message>
    <message>
        <source>Next: Settings, then Pre-flight.</source>
        <translation>接下来：“参数设置”，然后“飞行前检查”。</translation>
    </message>
    <message>
        <source>No acceleration: free-fall trigger not judged.</source>
        <translation>没有加速度数据：不判断失重触发。</translation>
    </message>
    <message>
        <source>No answer: the records are unknown.</source>
        <translation>无应答：记录未知。</translation>
    </message>
    <message>
        <source>No attitude: attitude trigger not judged.</source>
        <translation>没有姿态数据：不判断姿态触发。</translation>
    </message>
    <message>
        <source>No changes</source>
        <translation>无更改</translation>
    </message>
    <message>
        <source>No column is known to hold attitude or acceleration.</source>
        <translation>不知道哪一列是姿态或加速度。</translation>
    </message>
    <message>
        <source>No column is known to hold the time.</source>
        <translation>不知道哪一列是时间。</translation>
    </message>
    <message>
        <source>No current status.</source>
        <translation>没有有效的状态数据。</translation>
    </message>
    <message>
        <source>No flight has the length of this log.</source>
        <translation>没有飞行会是此日志的时长。</translation>
    </message>
    <message>
        <source>No flight log.</source>
        <translation>没有飞行日志。</translation>
    </message>
    <message>
        <source>No logs found.</source>
        <translation>未找到日志。</translation>
    </message>
    <message>
        <source>No logs yet</source>
        <translation>还没有日志</translation>
    </message>
    <message>
        <source>No longer on the module</source>
        <translation>模块中已不存在</translation>
    </message>
    <message>
        <source>No manual item {number} in the profile.</source>
        <translation>配置文件中没有第 {number} 个人工检查项。</translation>
    </message>
    <message>
        <source>No matches</source>
        <translation>没有匹配项</translation>
    </message>
    <message>
        <source>No module answers on {port} at any baud rate.</source>
        <translation>{port} 上没有模块以任何波特率应答。</translation>
    </message>
    <message>
        <source>No module answers on {port} at {rate} baud.</source>
        <translation>{port} 在 {rate} 波特率下没有模块应答。</translation>
    </message>
    <message>
        <source>No module answers on {port}, a flight controller's port.</source>
        <translation>{port} 是飞控的串口，没有模块应答。</translation>
    </message>
    <message>
        <source>No module answers on {port}.</source>
        <translation>{port} 上没有模块应答。</translation>
    </message>
    <message>
        <source>No new trigger record</source>
        <translation>没有新的触发记录</translation>
    </message>
    <message>
        <source>No permission for {port}.</source>
        <translation>没有 {port} 的访问权限。</translation>
    </message>
    <message>
        <source>No pre-flight record: {why}.</source>
        <translation>没有飞行前检查记录：{why}。</translation>
    </message>
    <message>
        <source>No proposal yet</source>
        <translation>暂无建议</translation>
    </message>
    <message>
        <source>No proposal: no log is on the side “{side}”.</source>
        <translation>无建议：“{side}”一侧没有日志。</translation>
    </message>
    <message>
        <source>No proposal: {count} of {total} not read</source>
        <translation>没有建议：{total} 个中有 {count} 个未读取</translation>
    </message>
    <message>
        <source>No protection in free fall.</source>
        <translation>失重时没有保护。</translation>
    </message>
    <message>
        <source>No protection when it tips over.</source>
        <translation>翻倒时没有保护。</translation>
    </message>
    <message>
        <source>No protection: no aircraft tilts by {fires:.0f}°.</source>
        <translation>没有保护：没有飞行器会倾斜到 {fires:.0f}°。</translation>
    </message>
    <message>
        <source>No readable frames on {port} at {rate} baud.</source>
        <translation>{port} 上以 {rate} 波特收不到有效帧。</translation>
    </message>
    <message>
        <source>No readable frames on {port}.</source>
        <translation>{port} 上收不到有效帧。</translation>
    </message>
    <message>
        <source>No recording is named “{name}”.</source>
        <translation>没有名为“{name}”的数据记录。</translation>
    </message>
    <message>
        <source>No recordings yet</source>
        <translation>还没有数据记录</translation>
    </message>
    <message>
        <source>No result: {why}.</source>
        <translation>无结果：{why}。</translation>
    </message>
    <message>
        <source>No screen: neither DISPLAY nor WAYLAND_DISPLAY is set.</source>
        <translation>没有屏幕：DISPLAY 和 WAYLAND_DISPLAY 均未设置。</translation>
    </message>
    <message>
        <source>No serial port. Plug the adapter in; try another cable or its driver.</source>
        <translation>没有串口。请插入适配器；或更换线缆、安装驱动。</translation>
    </message>
    <message>
        <source>No server is set.</source>
        <translation>未设置服务器。</translation>
    </message>
    <message>
        <source>No server is set: give {example}.</source>
        <translation>未设置服务器：请给出 {example}。</translation>
    </message>
    <message>
        <source>No settings known: read them first.</source>
        <translation>参数未知：请先读取。</translation>
    </message>
    <message>
        <source>No simulated module</source>
        <translation>没有模拟模块</translation>
    </message>
    <message>
        <source>No step within {seconds:.0f} s.</source>
        <translation>{seconds:.0f} 秒内没有完成下一步。</translation>
    </message>
    <message>
        <source>No thresholds separate the sides</source>
        <translation>没有阈值能区分两侧</translation>
    </message>
    <message>
        <source>No valid check within the last {days} days.</source>
        <translation>最近 {days} 天内没有有效的检查。</translation>
    </message>
    <message>
        <source>Noise can end or fake a free fall.</source>
        <translation>噪声可能中断或误报失重。</translation>
    </message>
    <message>
        <source>Not OK</source>
        <translation>不正常</translation>
    </message>
    <message>
        <source>Not accepted: {what}</source>
        <translation>未确认风险：{what}</translation>
    </message>
    <message>
        <source>Not armed and held for 2 s.</source>
        <translation>尚未预备并按住 2 秒。</translation>
    </message>
    <message>
        <source>Not confirmed that it is off: check it.</source>
        <translation>未确认已关机：请现场检查。</translation>
    </message>
    <message>
        <source>Not connected</source>
        <translation>未连接</translation>
    </message>
    <message>
        <source>Not everything could be read again.</source>
        <translation>未能重新读取全部数据。</translation>
    </message>
    <message>
        <source>Not judged: {names}</source>
        <translation>未判断：{names}</translation>
    </message>
    <message>
        <source>Not judged: {total:.1f} s on the ground.</source>
        <translation>不判断：地面时段 {total:.1f} s。</translation>
    </message>
    <message>
        <source>Not kept so far.</source>
        <translation>尚未保存。</translation>
    </message>
    <message>
        <source>Not kept.</source>
        <translation>未保存。</translation>
    </message>
    <message>
        <source>Not met: {names}</source>
        <translation>不通过：{names}</translation>
    </message>
    <message>
        <source>Not read back: {names}.</source>
        <translation>未回读：{names}。</translation>
    </message>
    <message>
        <source>Not recorded</source>
        <translation>未记录</translation>
    </message>
    <message>
        <source>Not recorded any more: the disk is too slow.</source>
        <translation>已停止记录：磁盘太慢。</translation>
    </message>
    <message>
        <source>Not recording to {folder}: {why}.</source>
        <translation>无法记录到 {folder}：{why}。</translation>
    </message>
    <message>
        <source>Not shared: {count}. Last: {time}.</source>
        <translation>未共享：{count} 条。上次：{time}。</translation>
    </message>
    <message>
        <source>Not testable at {threshold:.1f} g: rest and fall cannot be told apart.</source>
        <translation>{threshold:.1f} g 时无法测试：静止与坠落无法区分。</translation>
    </message>
    <message>
        <source>Not verified: {names}.</source>
        <translation>未验证：{names}。</translation>
    </message>
    <message>
        <source>Not watched for 2 s yet.</source>
        <translation>尚未观察满 2 秒。</translation>
    </message>
    <message>
        <source>Note</source>
        <translation>备注</translation>
    </message>
    <message>
        <source>Nothing can be written until this is corrected: {names}.</source>
        <translation>更正之前无法写入：{names}。</translation>
    </message>
    <message>
        <source>Nothing is sent.</source>
        <translation>不发送任何内容。</translation>
    </message>
    <message>
        <source>Nothing was done. Add {option} to do it.</source>
        <translation>未执行任何操作。如需执行，请加 {option}。</translation>
    </message>
    <message>
        <source>Nothing was recorded.</source>
        <translation>未记录任何内容。</translation>
    </message>
    <message>
        <source>Nothing was sent.</source>
        <translation>没有发送任何内容。</translation>
    </message>
    <message>
        <source>Nothing was written.</source>
        <translation>未写入任何内容。</translation>
    </message>
    <message>
        <source>OK</source>
        <translation>正常</translation>
    </message>
    <message>
        <source>Off until its switch (2 s) or external power.</source>
        <translation>关机，直至长按开关 2 秒或接通外接供电。</translation>
    </message>
    <message>
        <source>Offline for {time}</source>
        <translation>已离线 {time}</translation>
    </message>
    <message>
        <source>On neither side</source>
        <translation>不属于任何一侧</translation>
    </message>
    <message>
        <source>On the first visit continue; otherwise compare the count by hand.</source>
        <translation>首次连接可继续，否则请人工核对次数。</translation>
    </message>
    <message>
        <source>On the module</source>
        <translation>模块上</translation>
    </message>
    <message>
        <source>On the module: {value}</source>
        <translation>模块中的值：{value}</translation>
    </message>
    <message>
        <source>One code for all readable settings.</source>
        <translation>一个代码代表所有可读参数。</translation>
    </message>
    <message>
        <source>Only a test by hand proves the sensors.</source>
        <translation>只有手动测试能证明传感器有效。</translation>
    </message>
    <message>
        <source>Only an echo on {port}.</source>
        <translation>{port} 上只有回显。</translation>
    </message>
    <message>
        <source>Only the record in the report is signed.</source>
        <translation>报告中只有记录带签名。</translation>
    </message>
    <message>
        <source>Open</source>
        <translation>打开</translation>
    </message>
    <message>
        <source>Open folder…</source>
        <translation>打开文件夹…</translation>
    </message>
    <message>
        <source>Open profile…</source>
        <translation>打开配置文件…</translation>
    </message>
    <message>
        <source>Open the bay fully</source>
        <translation>完全打开伞仓</translation>
    </message>
    <message>
        <source>Opening…</source>
        <translation>正在打开…</translation>
    </message>
    <message>
        <source>Operation</source>
        <translation>运行</translation>
    </message>
    <message>
        <source>Other port</source>
        <translation>其他串口</translation>
    </message>
    <message>
        <source>Other port or baud rate</source>
        <translation>其他串口或波特率</translation>
    </message>
    <message>
        <source>Other programs on this computer may ask, and may send LOCK. TCP has no authentication.</source>
        <translation>本机的其他程序可以查询，也可以发送锁定。TCP 没有身份验证。</translation>
    </message>
    <message>
        <source>Over serial only: it still fires by itself.</source>
        <translation>只禁止串口触发：模块仍会自动开伞。</translation>
    </message>
    <message>
        <source>Over the restart: {what}.</source>
        <translation>重启前后：{what}。</translation>
    </message>
    <message>
        <source>Over {seconds:.2f} s: active, it would have fired.</source>
        <translation>超过 {seconds:.2f} s：激活时会开伞。</translation>
    </message>
    <message>
        <source>Overdue service is NO-GO</source>
        <translation>维护逾期即禁止飞行</translation>
    </message>
    <message>
        <source>PLUG IN: {module}</source>
        <translation>请接入：{module}</translation>
    </message>
    <message>
        <source>PWM trigger</source>
        <translation>PWM 触发</translation>
    </message>
    <message>
        <source>Pages</source>
        <translation>页面</translation>
    </message>
    <message>
        <source>Parachute bay</source>
        <translation>伞仓</translation>
    </message>
    <message>
        <source>Parameter</source>
        <translation>参数</translation>
    </message>
    <message>
        <source>Passed: {count} of {all}; warnings: {looks}.</source>
        <translation>通过：{count}/{all} 项；警告：{looks} 项。</translation>
    </message>
    <message>
        <source>Passed: {count}; warnings: {looks}.</source>
        <translation>通过：{count} 项；警告：{looks} 项。</translation>
    </message>
    <message>
        <source>Past checks</source>
        <translation>历次检查</translation>
    </message>
    <message>
        <source>Pause</source>
        <translation>暂停</translation>
    </message>
    <message>
        <source>Pause; recording continues</source>
        <translation>暂停显示；记录继续</translation>
    </message>
    <message>
        <source>Plots</source>
        <translation>曲线</translation>
    </message>
    <message>
        <source>Plug and cable</source>
        <translation>插头与线缆</translation>
    </message>
    <message>
        <source>Plug the adapter in again, or check the address.</source>
        <translation>请重新插入适配器，或检查地址。</translation>
    </message>
    <message>
        <source>Plug the adapter in, then do it again.</source>
        <translation>请插入适配器，然后重试。</translation>
    </message>
    <message>
        <source>Plug the adapter in. On Linux brltty may take it: remove that. If no port comes, install its driver.</source>
        <translation>请插入适配器。在 Linux 上可能被 brltty 占用：请卸载它。如未出现串口，请安装驱动。</translation>
    </message>
    <message>
        <source>Port</source>
        <translation>串口</translation>
    </message>
    <message>
        <source>Port {port} ({name})</source>
        <translation>串口 {port}（{name}）</translation>
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
        <source>Power off</source>
        <translation>断电</translation>
    </message>
    <message>
        <source>Power-ups so far; 0 follows 255.</source>
        <translation>累计上电次数；255 之后归零。</translation>
    </message>
    <message>
        <source>Pre-flight</source>
        <translation>飞行前检查</translation>
    </message>
    <message>
        <source>Pre-flight check of a parachute module</source>
        <translation>伞降模块飞行前检查</translation>
    </message>
    <message>
        <source>Pre-flight check: {verdict}, checked by: {who}.</source>
        <translation>飞行前检查：{verdict}，检查人：{who}。</translation>
    </message>
    <message>
        <source>Preferences</source>
        <translation>偏好设置</translation>
    </message>
    <message>
        <source>Print…</source>
        <translation>打印…</translation>
    </message>
    <message>
        <source>Profile</source>
        <translation>配置文件</translation>
    </message>
    <message>
        <source>Program</source>
        <translation>程序</translation>
    </message>
    <message>
        <source>Proposal</source>
        <translation>建议</translation>
    </message>
    <message>
        <source>Proposal: {limits}</source>
        <translation>建议：{limits}</translation>
    </message>
    <message>
        <source>Proves that the module is there; two come after power-up.</source>
        <translation>证明模块在线；上电后自行发送两次。</translation>
    </message>
    <message>
        <source>Quantity</source>
        <translation>项目</translation>
    </message>
    <message>
        <source>Questions are answered twice. Two modules on this line?</source>
        <translation>查询得到两次应答。此线路上有两个模块吗？</translation>
    </message>
    <message>
        <source>Quit</source>
        <translation>退出</translation>
    </message>
    <message>
        <source>READY</source>
        <translation>待激活</translation>
    </message>
    <message>
        <source>REC</source>
        <translation>记录</translation>
    </message>
    <message>
        <source>REC off</source>
        <translation>未记录</translation>
    </message>
    <message>
        <source>Raw bytes</source>
        <translation>原始字节</translation>
    </message>
    <message>
        <source>Read</source>
        <translation>读取</translation>
    </message>
    <message>
        <source>Read all</source>
        <translation>全部读取</translation>
    </message>
    <message>
        <source>Read are PX4 .ulg, ArduPilot .bin and .log, telemetry .tlog, tables .csv and .txt, each of them also in .gz or .zip, and recordings .mcap.</source>
        <translation>可读取：PX4 .ulg，ArduPilot .bin 和 .log，遥测 .tlog，表格 .csv 和 .txt，以上文件也可以装在 .gz 或 .zip 中；以及数据记录 .mcap。</translation>
    </message>
    <message>
        <source>Read as soon as the module answers.</source>
        <translation>模块应答后立即读取。</translation>
    </message>
    <message>
        <source>Read back as written: {count}.</source>
        <translation>回读与写入一致：{count} 项。</translation>
    </message>
    <message>
        <source>Read or remove: {names}</source>
        <translation>请读取或移除：{names}</translation>
    </message>
    <message>
        <source>Read since: {what}.</source>
        <translation>之后读取：{what}。</translation>
    </message>
    <message>
        <source>Read the record</source>
        <translation>读取记录</translation>
    </message>
    <message>
        <source>Reading again…</source>
        <translation>正在重新读取…</translation>
    </message>
    <message>
        <source>Reading logs…</source>
        <translation>正在读取日志…</translation>
    </message>
    <message>
        <source>Reading the trigger records</source>
        <translation>正在读取触发记录</translation>
    </message>
    <message>
        <source>Reading: {what}</source>
        <translation>正在读取：{what}</translation>
    </message>
    <message>
        <source>Ready to fire: lock it before you touch it.</source>
        <translation>随时可能开伞：触碰前请先锁定。</translation>
    </message>
    <message>
        <source>Rearms, {direction}</source>
        <translation>复位角度，{direction}</translation>
    </message>
    <message>
        <source>Record</source>
        <translation>记录</translation>
    </message>
    <message>
        <source>Recorded since {time}</source>
        <translation>自 {time} 起记录</translation>
    </message>
    <message>
        <source>Recording of {time}</source>
        <translation>{time} 的数据记录</translation>
    </message>
    <message>
        <source>Recordings</source>
        <translation>数据记录</translation>
    </message>
    <message>
        <source>Recordings deleted: {count}.</source>
        <translation>已删除数据记录：{count} 条。</translation>
    </message>
    <message>
        <source>Records</source>
        <translation>记录</translation>
    </message>
    <message>
        <source>Records restored from the copy of {when}; later ones are missing.</source>
        <translation>记录已从 {when} 的备份恢复；此后的记录缺失。</translation>
    </message>
    <message>
        <source>Remove</source>
        <translation>移除</translation>
    </message>
    <message>
        <source>Repack</source>
        <translation>重新叠伞装仓</translation>
    </message>
    <message>
        <source>Requests</source>
        <translation>请求</translation>
    </message>
    <message>
        <source>Restart</source>
        <translation>重启</translation>
    </message>
    <message>
        <source>Restarts</source>
        <translation>重启</translation>
    </message>
    <message>
        <source>Restore initial</source>
        <translation>恢复初始值</translation>
    </message>
    <message>
        <source>Result</source>
        <translation>结果</translation>
    </message>
    <message>
        <source>Round trip</source>
        <translation>往返时间</translation>
    </message>
    <message>
        <source>SET ASIDE</source>
        <translation>搁置</translation>
    </message>
    <message>
        <source>SIMULATED MODULE: no evidence.</source>
        <translation>模拟模块：不能作为依据。</translation>
    </message>
    <message>
        <source>Same settings, same code</source>
        <translation>参数相同则校验码相同</translation>
    </message>
    <message>
        <source>Same when read twice</source>
        <translation>两次读取一致</translation>
    </message>
    <message>
        <source>Save</source>
        <translation>保存</translation>
    </message>
    <message>
        <source>Save as profile…</source>
        <translation>另存为配置文件…</translation>
    </message>
    <message>
        <source>Save as…</source>
        <translation>另存为…</translation>
    </message>
    <message>
        <source>Save picture…</source>
        <translation>保存图片…</translation>
    </message>
    <message>
        <source>Save support bundle…</source>
        <translation>保存诊断包…</translation>
    </message>
    <message>
        <source>Save values…</source>
        <translation>保存数据…</translation>
    </message>
    <message>
        <source>Saved to {path}.</source>
        <translation>已保存到 {path}。</translation>
    </message>
    <message>
        <source>Saved to {path}. Rows: {rows}.</source>
        <translation>已保存到 {path}。行数：{rows}。</translation>
    </message>
    <message>
        <source>Saved to {path}. Rows: {rows}; older ones are gone.</source>
        <translation>已保存到 {path}。行数：{rows}；更早的已不再保留。</translation>
    </message>
    <message>
        <source>Saving…</source>
        <translation>正在保存…</translation>
    </message>
    <message>
        <source>Search</source>
        <translation>搜索</translation>
    </message>
    <message>
        <source>Seen in one reading only. Read again.</source>
        <translation>仅在一次读取中出现。请重新读取。</translation>
    </message>
    <message>
        <source>Select a row.</source>
        <translation>请选择一行。</translation>
    </message>
    <message>
        <source>Send no commands during the check.</source>
        <translation>检查期间不要发送命令。</translation>
    </message>
    <message>
        <source>Sends only when asked.</source>
        <translation>仅在查询时应答。</translation>
    </message>
    <message>
        <source>Sent, not confirmed.</source>
        <translation>已发送，未确认。</translation>
    </message>
    <message>
        <source>Sent, not confirmed: treat it as fired.</source>
        <translation>已发送，未得到确认：请视为已触发开伞。</translation>
    </message>
    <message>
        <source>Sent, not confirmed: treat the module as ACTIVE.</source>
        <translation>已发送，未确认：请视模块为已激活。</translation>
    </message>
    <message>
        <source>Sent: {sent}. Received: {received}.</source>
        <translation>已发送：{sent} 条。已接收：{received} 条。</translation>
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
        <source>Server</source>
        <translation>服务器</translation>
    </message>
    <message>
        <source>Service due</source>
        <translation>到期维护</translation>
    </message>
    <message>
        <source>Service of {module}</source>
        <translation>{module} 的维护</translation>
    </message>
    <message>
        <source>Service…</source>
        <translation>维护…</translation>
    </message>
    <message>
        <source>Set it to the reading with the bay fully open.</source>
        <translation>设置为伞仓完全打开时的读数。</translation>
    </message>
    <message>
        <source>Set the aircraft down; if the value stays, do not fly.</source>
        <translation>放稳飞行器；若数值仍不正常，禁止飞行。</translation>
    </message>
    <message>
        <source>Set the aircraft level and do not touch it.</source>
        <translation>把飞行器放平，不要触碰。</translation>
    </message>
    <message>
        <source>Set the aircraft level, or zero the sensor.</source>
        <translation>放平飞行器，或将传感器置零。</translation>
    </message>
    <message>
        <source>Settings</source>
        <translation>参数设置</translation>
    </message>
    <message>
        <source>Settings as approved</source>
        <translation>参数与批准的一致</translation>
    </message>
    <message>
        <source>Settings code</source>
        <translation>参数校验码</translation>
    </message>
    <message>
        <source>Settings not written: {count}.</source>
        <translation>尚未写入的参数：{count} 项。</translation>
    </message>
    <message>
        <source>Settings: {settings}.</source>
        <translation>参数：{settings}。</translation>
    </message>
    <message>
        <source>Settings: {what}.</source>
        <translation>设置：{what}。</translation>
    </message>
    <message>
        <source>Shake plug and cable gently</source>
        <translation>轻轻摇动插头和线缆</translation>
    </message>
    <message>
        <source>Shaken for 15 s</source>
        <translation>已晃动 15 秒</translation>
    </message>
    <message>
        <source>Share this port, read-only</source>
        <translation>共享此串口（只读）</translation>
    </message>
    <message>
        <source>Shared, read-only</source>
        <translation>共享，只读</translation>
    </message>
    <message>
        <source>Shared, read-only: only questions and LOCK are sent.</source>
        <translation>共享，只读：只发送查询和锁定。</translation>
    </message>
    <message>
        <source>Show in folder</source>
        <translation>在文件夹中显示</translation>
    </message>
    <message>
        <source>Show on all pages</source>
        <translation>在所有页面显示</translation>
    </message>
    <message>
        <source>Shown</source>
        <translation>当前显示</translation>
    </message>
    <message>
        <source>Shut down</source>
        <translation>关机</translation>
    </message>
    <message>
        <source>Side</source>
        <translation>归类</translation>
    </message>
    <message>
        <source>Signature</source>
        <translation>签名</translation>
    </message>
    <message>
        <source>Signed by a station known in the archive as {names} ({fingerprint}).</source>
        <translation>由归档中名为 {names} 的站点签名（{fingerprint}）。</translation>
    </message>
    <message>
        <source>Signed by an unknown key ({fingerprint}).</source>
        <translation>由未知密钥签名（{fingerprint}）。</translation>
    </message>
    <message>
        <source>Signed by this station ({fingerprint}).</source>
        <translation>由本站点签名（{fingerprint}）。</translation>
    </message>
    <message>
        <source>Silent</source>
        <translation>不应答</translation>
    </message>
    <message>
        <source>Simulated module</source>
        <translation>模拟模块</translation>
    </message>
    <message>
        <source>Skipped: {count}.</source>
        <translation>跳过：{count}。</translation>
    </message>
    <message>
        <source>Slow replies point to a bad adapter or a busy computer.</source>
        <translation>响应慢说明适配器不良或电脑繁忙。</translation>
    </message>
    <message>
        <source>Slowest answer</source>
        <translation>最慢应答</translation>
    </message>
    <message>
        <source>Somebody marked this module as new.</source>
        <translation>有人将此模块标记为新模块。</translation>
    </message>
    <message>
        <source>Sound: TRIGGERED, ACTIVE, link lost while ACTIVE</source>
        <translation>提示音：已触发、已激活、激活时通信中断</translation>
    </message>
    <message>
        <source>Speed of the serial line.</source>
        <translation>串口通讯速率。</translation>
    </message>
    <message>
        <source>Start</source>
        <translation>开始</translation>
    </message>
    <message>
        <source>Start the check.</source>
        <translation>开始检查。</translation>
    </message>
    <message>
        <source>Started</source>
        <translation>开始时间</translation>
    </message>
    <message>
        <source>State</source>
        <translation>状态</translation>
    </message>
    <message>
        <source>Station</source>
        <translation>站点</translation>
    </message>
    <message>
        <source>Stations</source>
        <translation>站点</translation>
    </message>
    <message>
        <source>Statistics</source>
        <translation>统计</translation>
    </message>
    <message>
        <source>Status</source>
        <translation>状态</translation>
    </message>
    <message>
        <source>Step {number}: {name}</source>
        <translation>第 {number} 步：{name}</translation>
    </message>
    <message>
        <source>Stop motors and fans.</source>
        <translation>停止电机和风扇。</translation>
    </message>
    <message>
        <source>Streams the status unasked.</source>
        <translation>主动实时输出状态。</translation>
    </message>
    <message>
        <source>Sunlight</source>
        <translation>阳光下</translation>
    </message>
    <message>
        <source>Support</source>
        <translation>支持</translation>
    </message>
    <message>
        <source>Switch its passthrough on: guide or docs/adapters.md, “Through the flight controller”. Its restart ends that.</source>
        <translation>请开启串口直通，见用户指南或适配器文档（docs/adapters.zh_CN.md）的“通过飞控连接”。重启飞控即结束直通。</translation>
    </message>
    <message>
        <source>Switched off at {time}</source>
        <translation>{time} 已关机</translation>
    </message>
    <message>
        <source>Sync now</source>
        <translation>立即同步</translation>
    </message>
    <message>
        <source>System</source>
        <translation>跟随系统</translation>
    </message>
    <message>
        <source>TCP has no authentication: whoever reaches {address} reads, and may LOCK.</source>
        <translation>TCP 没有身份验证：能访问 {address} 的人都可以读取，也可以锁定。</translation>
    </message>
    <message>
        <source>TRIGGERED: lock it, read its records.</source>
        <translation>已触发：锁定并读取触发记录。</translation>
    </message>
    <message>
        <source>Take over</source>
        <translation>采用</translation>
    </message>
    <message>
        <source>Takes this position as level; for small mounting errors only.</source>
        <translation>以当前姿态为水平；仅用于修正小角度安装误差。</translation>
    </message>
    <message>
        <source>Test again</source>
        <translation>重新测试</translation>
    </message>
    <message>
        <source>Text size</source>
        <translation>文字大小</translation>
    </message>
    <message>
        <source>The Python package {package} is missing. Install the program again.</source>
        <translation>缺少 Python 包 {package}。请重新安装本程序。</translation>
    </message>
    <message>
        <source>The archive server {server} cannot be used: {why}</source>
        <translation>无法使用归档服务器 {server}：{why}</translation>
    </message>
    <message>
        <source>The audit log cannot be written.</source>
        <translation>无法写入操作记录。</translation>
    </message>
    <message>
        <source>The audit log is incomplete.</source>
        <translation>操作记录不完整。</translation>
    </message>
    <message>
        <source>The baud rate is never applied with a profile.</source>
        <translation>波特率不随配置文件应用。</translation>
    </message>
    <message>
        <source>The baud rate of a plain socket is set at its other end.</source>
        <translation>普通套接字的波特率在对端设置。</translation>
    </message>
    <message>
        <source>The baud rate of the port was changed.</source>
        <translation>串口波特率已更改。</translation>
    </message>
    <message>
        <source>The charger hides the cell's voltage.</source>
        <translation>充电时读到的不是电芯电压。</translation>
    </message>
    <message>
        <source>The clock jumps back; samples left out: {count}.</source>
        <translation>时钟回跳；略去采样：{count} 个。</translation>
    </message>
    <message>
        <source>The computer slept.</source>
        <translation>电脑曾休眠。</translation>
    </message>
    <message>
        <source>The conversation in which it was checked is over.</source>
        <translation>检查时的通信已结束。</translation>
    </message>
    <message>
        <source>The database of the archive has to be made with the encoding UTF8.</source>
        <translation>档案数据库必须以 UTF8 编码创建。</translation>
    </message>
    <message>
        <source>The disk is too slow.</source>
        <translation>磁盘写入过慢。</translation>
    </message>
    <message>
        <source>The disk is too slow: the end of the recording is not written yet.</source>
        <translation>磁盘太慢：记录的末尾尚未写入。</translation>
    </message>
    <message>
        <source>The flight controller must then use {rate} baud, too.</source>
        <translation>此后飞控也必须使用 {rate} 波特率。</translation>
    </message>
    <message>
        <source>The key of this station cannot be used: {why}.</source>
        <translation>本站点的密钥无法使用：{why}。</translation>
    </message>
    <message>
        <source>The last nine triggers with settings and readings.</source>
        <translation>最近九次触发及当时的参数和读数。</translation>
    </message>
    <message>
        <source>The log lasts {seconds:.6g} s, too short or too long for a flight: not judged.</source>
        <translation>日志时长 {seconds:.6g} s，对一次飞行来说过短或过长：未判断。</translation>
    </message>
    <message>
        <source>The module at {port}</source>
        <translation>{port} 上的模块</translation>
    </message>
    <message>
        <source>The module cannot say whether it is enabled.</source>
        <translation>模块无法上报其是否启用。</translation>
    </message>
    <message>
        <source>The module counts its starts; a lower count than before is another module's.</source>
        <translation>模块累计开机次数；比以前少则是另一个模块。</translation>
    </message>
    <message>
        <source>The module does not answer.</source>
        <translation>模块无应答。</translation>
    </message>
    <message>
        <source>The module has triggered: LOCK, read the record, pack, check again.</source>
        <translation>模块已触发：请锁定、读取记录、重新叠伞装仓并检查。</translation>
    </message>
    <message>
        <source>The module is ACTIVE: it fires also without this program.</source>
        <translation>模块处于激活状态：没有本程序也会开伞。</translation>
    </message>
    <message>
        <source>The module is ACTIVE: lock it first.</source>
        <translation>模块已激活：请先锁定。</translation>
    </message>
    <message>
        <source>The module is LOCKED.</source>
        <translation>模块已锁定。</translation>
    </message>
    <message>
        <source>The module is LOCKED: activate it first.</source>
        <translation>模块已锁定：请先激活。</translation>
    </message>
    <message>
        <source>The module may have fired before the restart: read the trigger records.</source>
        <translation>模块可能在重启前已触发：请读取触发记录。</translation>
    </message>
    <message>
        <source>The module on {port} answers later than a second.</source>
        <translation>{port} 上的模块应答慢于一秒。</translation>
    </message>
    <message>
        <source>The module on {port} sends, but does not answer.</source>
        <translation>{port} 上的模块在发送，但不应答。</translation>
    </message>
    <message>
        <source>The module refused and reports no trigger.</source>
        <translation>模块拒绝执行，且未上报触发。</translation>
    </message>
    <message>
        <source>The module refused.</source>
        <translation>模块拒绝执行。</translation>
    </message>
    <message>
        <source>The module reports ACTIVE.</source>
        <translation>模块上报：已激活。</translation>
    </message>
    <message>
        <source>The module reports LOCKED.</source>
        <translation>模块上报：已锁定。</translation>
    </message>
    <message>
        <source>The module reports that it has fired.</source>
        <translation>模块上报已触发开伞。</translation>
    </message>
    <message>
        <source>The module restarted.</source>
        <translation>模块已重启。</translation>
    </message>
    <message>
        <source>The module still answers: not switched off.</source>
        <translation>模块仍有应答：未关机。</translation>
    </message>
    <message>
        <source>The module still reports LOCKED.</source>
        <translation>模块仍上报：已锁定。</translation>
    </message>
    <message>
        <source>The module that answers now reports LOCKED.</source>
        <translation>当前应答的模块上报：已锁定。</translation>
    </message>
    <message>
        <source>The module was locked.</source>
        <translation>模块已被锁定。</translation>
    </message>
    <message>
        <source>The module was silent for a moment.</source>
        <translation>模块曾短暂无应答。</translation>
    </message>
    <message>
        <source>The module was told to fire, or reports TRIGGERED.</source>
        <translation>已向模块发出开伞命令，或模块上报已触发。</translation>
    </message>
    <message>
        <source>The names of the user and the computer are replaced. Names of modules, files and ports, serial numbers and addresses stay: read everything before you pass it on. Nothing is sent.</source>
        <translation>用户名和电脑名已替换。模块、文件和串口的名称、序列号以及地址会保留：转交他人前请通读全部内容。不会发送任何内容。</translation>
    </message>
    <message>
        <source>The parachute is spent.</source>
        <translation>降落伞已用完。</translation>
    </message>
    <message>
        <source>The port was closed.</source>
        <translation>串口已关闭。</translation>
    </message>
    <message>
        <source>The port was lost.</source>
        <translation>串口断开。</translation>
    </message>
    <message>
        <source>The profile demands manual checks or guided tests, which a batch does not have.</source>
        <translation>配置文件要求人工检查或引导测试，批量配置无法完成。</translation>
    </message>
    <message>
        <source>The profile's {rate} baud is left out: a batch does not change it.</source>
        <translation>配置文件中的 {rate} 波特已略去：批量设置不更改波特率。</translation>
    </message>
    <message>
        <source>The readings differ: records may be missing. Read again.</source>
        <translation>多次读取结果不一致，记录可能缺失。请重新读取。</translation>
    </message>
    <message>
        <source>The record is not signed.</source>
        <translation>记录未签名。</translation>
    </message>
    <message>
        <source>The records cannot be used and are kept as {file}.</source>
        <translation>记录无法使用，已另存为 {file}。</translation>
    </message>
    <message>
        <source>The records of other stations are damaged, and kept as {file}: they come with the next exchange.</source>
        <translation>其他站点的记录已损坏，已另存为 {file}；下次交换时会重新获取。</translation>
    </message>
    <message>
        <source>The result is that of {module}.</source>
        <translation>此结果属于模块 {module}。</translation>
    </message>
    <message>
        <source>The results below are void. Check again.</source>
        <translation>以下结果已作废。请重新检查。</translation>
    </message>
    <message>
        <source>The settings are equal.</source>
        <translation>参数一致。</translation>
    </message>
    <message>
        <source>The settings are the same.</source>
        <translation>参数相同。</translation>
    </message>
    <message>
        <source>The system lists no serial ports. Switch Bluetooth off and try again.</source>
        <translation>系统未能列出串口。请关闭蓝牙后重试。</translation>
    </message>
    <message>
        <source>The unit of “{name}” is not certain.</source>
        <translation>“{name}”的单位不确定。</translation>
    </message>
    <message>
        <source>The user guide is not installed.</source>
        <translation>未安装用户指南。</translation>
    </message>
    <message>
        <source>The vendor advises not to change it.</source>
        <translation>厂家建议不要更改。</translation>
    </message>
    <message>
        <source>The vendor says: 55° or more, below 0.7 g; defaults 60°, 0.5 g, 1.60 s.</source>
        <translation>厂家规定：55° 以上，低于 0.7 g；默认值 60°、0.5 g、1.60 s。</translation>
    </message>
    <message>
        <source>The vendor's defaults fire in {count} of {total}</source>
        <translation>厂家默认值在 {total} 个中的 {count} 个触发</translation>
    </message>
    <message>
        <source>The vendor's defaults miss {count} of {total}</source>
        <translation>厂家默认值漏掉 {total} 个中的 {count} 个</translation>
    </message>
    <message>
        <source>Theme</source>
        <translation>主题</translation>
    </message>
    <message>
        <source>There are several adapters: {names}. Give --port.</source>
        <translation>有多个适配器：{names}。请用 --port 指定。</translation>
    </message>
    <message>
        <source>There is no USB adapter. Plug it in, or give --port.</source>
        <translation>没有 USB 适配器。请插入，或用 --port 指定。</translation>
    </message>
    <message>
        <source>There is no command {name}.</source>
        <translation>没有命令 {name}。</translation>
    </message>
    <message>
        <source>There is no folder {folder}.</source>
        <translation>没有文件夹 {folder}。</translation>
    </message>
    <message>
        <source>There is no port {port}.</source>
        <translation>没有串口 {port}。</translation>
    </message>
    <message>
        <source>There is no {file} here.</source>
        <translation>此处没有 {file}。</translation>
    </message>
    <message>
        <source>This file is empty.</source>
        <translation>该文件为空。</translation>
    </message>
    <message>
        <source>This is a Betaflight or INAV blackbox log: convert it to CSV with “blackbox_decode --simulate-imu”.</source>
        <translation>这是 Betaflight 或 INAV 黑匣子日志：请用“blackbox_decode --simulate-imu”转换成 CSV。</translation>
    </message>
    <message>
        <source>This is a DJI log: convert it to CSV, for example with DatCon.</source>
        <translation>这是 DJI 日志：请转换成 CSV，例如用 DatCon。</translation>
    </message>
    <message>
        <source>This is a Git LFS pointer, not the log: fetch the log with “git lfs pull”.</source>
        <translation>这是 Git LFS 指针，不是日志：请用“git lfs pull”取得日志。</translation>
    </message>
    <message>
        <source>This is a packed recording: unpack it.</source>
        <translation>这是压缩的数据记录：请先解压。</translation>
    </message>
    <message>
        <source>This is a spreadsheet: save it as CSV.</source>
        <translation>这是电子表格：请另存为 CSV。</translation>
    </message>
    <message>
        <source>This is a web page, not a log: download the file itself.</source>
        <translation>这是网页，不是日志：请下载文件本身。</translation>
    </message>
    <message>
        <source>This line is too slow for commands; use the cable.</source>
        <translation>此线路太慢，无法发送命令；请使用线缆。</translation>
    </message>
    <message>
        <source>This may be another module: {differences}.</source>
        <translation>这可能是另一个模块：{differences}。</translation>
    </message>
    <message>
        <source>This program was never tried on a real module.</source>
        <translation>本程序从未在真实模块上试用过。</translation>
    </message>
    <message>
        <source>This role may not make the table of the archive. As the server's administrator, once:
{sql}</source>
        <translation>此角色无权创建档案表。请服务器管理员执行一次：
{sql}</translation>
    </message>
    <message>
        <source>This station: {fingerprint}</source>
        <translation>本站点：{fingerprint}</translation>
    </message>
    <message>
        <source>Tilt</source>
        <translation>倾角</translation>
    </message>
    <message>
        <source>Tilt and acceleration</source>
        <translation>倾角和加速度</translation>
    </message>
    <message>
        <source>Tilt at which it fires; rearms 10° below.</source>
        <translation>达到此倾角即开伞；低 10° 复位。</translation>
    </message>
    <message>
        <source>Tilt it slowly {direction} until it fires</source>
        <translation>{direction}缓慢倾斜，直到触发</translation>
    </message>
    <message>
        <source>Tilt now {tilt:.0f}°, not 0°: check the mounting.</source>
        <translation>当前倾角 {tilt:.0f}°，不是 0°：请检查安装。</translation>
    </message>
    <message>
        <source>Tilt now {tilt:.0f}°.</source>
        <translation>当前倾角 {tilt:.0f}°。</translation>
    </message>
    <message>
        <source>Tilt {tilt:.0f}° (threshold {threshold:.0f}°): it would fire at once.</source>
        <translation>倾角 {tilt:.0f}°（阈值 {threshold:.0f}°）：会立即开伞。</translation>
    </message>
    <message>
        <source>Tilt {tilt:.0f}°: lay it level (≤ {limit:.0f}°).</source>
        <translation>倾角 {tilt:.0f}°：请放平（≤ {limit:.0f}°）。</translation>
    </message>
    <message>
        <source>Tilt, acceleration, trigger and activation.</source>
        <translation>倾角、加速度、触发状态和激活状态。</translation>
    </message>
    <message>
        <source>Tilt: level</source>
        <translation>倾角：水平</translation>
    </message>
    <message>
        <source>Tilt: steady</source>
        <translation>倾角：稳定</translation>
    </message>
    <message>
        <source>Time</source>
        <translation>时间</translation>
    </message>
    <message>
        <source>Tolerance</source>
        <translation>允差</translation>
    </message>
    <message>
        <source>Too fast. Hold it level.</source>
        <translation>太快。请水平握住。</translation>
    </message>
    <message>
        <source>Too fast. Tilt it slowly {direction} until it fires</source>
        <translation>太快。{direction}缓慢倾斜，直到触发</translation>
    </message>
    <message>
        <source>Too few readings: measure again.</source>
        <translation>读数太少：请重新测量。</translation>
    </message>
    <message>
        <source>Too high, it fires in a descent; too low, it misses falls.</source>
        <translation>过高会在下降时触发，过低会漏掉坠落。</translation>
    </message>
    <message>
        <source>Too low, it fires in a turn; too high, it fires too late.</source>
        <translation>过小会在转弯时触发，过大则触发太晚。</translation>
    </message>
    <message>
        <source>Too short, it fires without need; too long, it costs height.</source>
        <translation>过短会误触发，过长会损失高度。</translation>
    </message>
    <message>
        <source>Traffic</source>
        <translation>通信记录</translation>
    </message>
    <message>
        <source>Treat it as ready to fire until it reports LOCKED.</source>
        <translation>在其上报“已锁定”之前，请视为随时可能开伞。</translation>
    </message>
    <message>
        <source>Treat the module as ACTIVE: it does not report LOCKED.</source>
        <translation>请将模块视为已激活：模块未上报锁定。</translation>
    </message>
    <message>
        <source>Trigger</source>
        <translation>触发状态</translation>
    </message>
    <message>
        <source>Trigger record: {what}</source>
        <translation>触发记录：{what}</translation>
    </message>
    <message>
        <source>Trigger records</source>
        <translation>触发记录</translation>
    </message>
    <message>
        <source>Trigger state is unknown after power-up. Enable the triggers to set it.</source>
        <translation>模块上电后触发开关状态未知。请启用触发以确定状态。</translation>
    </message>
    <message>
        <source>Triggered?</source>
        <translation>开伞状态</translation>
    </message>
    <message>
        <source>Triggers</source>
        <translation>触发记录</translation>
    </message>
    <message>
        <source>Triggers, cell</source>
        <translation>触发开关、电芯</translation>
    </message>
    <message>
        <source>Triggers: enabled in this conversation only. Whether a restart keeps them is not known.</source>
        <translation>触发开关：仅在本次通信中启用。重启后是否保留，尚不清楚。</translation>
    </message>
    <message>
        <source>Try again</source>
        <translation>重试</translation>
    </message>
    <message>
        <source>Try proposal</source>
        <translation>试用建议</translation>
    </message>
    <message>
        <source>Trying {rate} baud</source>
        <translation>正在尝试 {rate} 波特率</translation>
    </message>
    <message>
        <source>Two modules? Boot count {before} on {then}, {now} on {day}.</source>
        <translation>是两个模块吗？{then} 的开机次数为 {before}，{day} 为 {now}。</translation>
    </message>
    <message>
        <source>Type: {command}</source>
        <translation>请输入：{command}</translation>
    </message>
    <message>
        <source>Type: {command} — then log out and in again.</source>
        <translation>请输入：{command}，然后注销并重新登录。</translation>
    </message>
    <message>
        <source>UNPLUG, NEXT</source>
        <translation>请拔下，换下一个</translation>
    </message>
    <message>
        <source>UNSIGNED, missing: {missing}.</source>
        <translation>未签署，缺少：{missing}。</translation>
    </message>
    <message>
        <source>Unexpected error: {error}.</source>
        <translation>意外错误：{error}。</translation>
    </message>
    <message>
        <source>Unexpected error: {error}. Nothing is armed.</source>
        <translation>意外错误：{error}。没有任何操作处于预备状态。</translation>
    </message>
    <message>
        <source>Unjudged trigger records: {count}.</source>
        <translation>未复核的触发记录：{count} 条。</translation>
    </message>
    <message>
        <source>Unknown: ACTIVE or LOCKED.</source>
        <translation>未知：已激活还是已锁定。</translation>
    </message>
    <message>
        <source>Unknown: attitude threshold.</source>
        <translation>未知：姿态开伞阈值。</translation>
    </message>
    <message>
        <source>Unknown: tilt.</source>
        <translation>未知：倾角。</translation>
    </message>
    <message>
        <source>Unknown: whether it has fired.</source>
        <translation>未知：是否已触发。</translation>
    </message>
    <message>
        <source>Unknown: {what}.</source>
        <translation>未知：{what}。</translation>
    </message>
    <message>
        <source>Unlock this one write</source>
        <translation>仅为本次写入解锁</translation>
    </message>
    <message>
        <source>Unnamed</source>
        <translation>未命名</translation>
    </message>
    <message>
        <source>Unplug the adapter and plug it in again.</source>
        <translation>请拔下适配器后重新插入。</translation>
    </message>
    <message>
        <source>Unplug the external power.</source>
        <translation>断开外接供电。</translation>
    </message>
    <message>
        <source>Unplugged</source>
        <translation>已拔出</translation>
    </message>
    <message>
        <source>Unsaved edits.</source>
        <translation>有未保存的修改。</translation>
    </message>
    <message>
        <source>Use a device name, socket://HOST:PORT or rfc2217://HOST:PORT; dps-s FILE opens a file.</source>
        <translation>请使用设备名、socket://HOST:PORT 或 rfc2217://HOST:PORT；打开文件请用 dps-s FILE。</translation>
    </message>
    <message>
        <source>Use a shorter cable, connect ground, avoid motors and antennas.</source>
        <translation>请缩短线缆、接好地线，远离电机和天线。</translation>
    </message>
    <message>
        <source>Use another adapter or USB socket.</source>
        <translation>换用其他适配器或 USB 口。</translation>
    </message>
    <message>
        <source>Use in Settings</source>
        <translation>用到参数设置</translation>
    </message>
    <message>
        <source>Use the cable, or a quicker line. LOCK works.</source>
        <translation>请使用线缆或更快的线路。锁定仍可用。</translation>
    </message>
    <message>
        <source>Use this threshold</source>
        <translation>采用此阈值</translation>
    </message>
    <message>
        <source>User guide</source>
        <translation>用户指南</translation>
    </message>
    <message>
        <source>Valid now only; not monitored afterwards.</source>
        <translation>结论仅此刻有效；之后不再监视。</translation>
    </message>
    <message>
        <source>Vendor advises: {advice}</source>
        <translation>厂家建议：{advice}</translation>
    </message>
    <message>
        <source>Vendor defaults, not of a module: {names}.</source>
        <translation>厂家默认值，并非模块读数：{names}。</translation>
    </message>
    <message>
        <source>Vendor's advice</source>
        <translation>厂家建议</translation>
    </message>
    <message>
        <source>Verdict</source>
        <translation>结论</translation>
    </message>
    <message>
        <source>Verify a file…</source>
        <translation>验证文件…</translation>
    </message>
    <message>
        <source>Void: {why}</source>
        <translation>作废：{why}</translation>
    </message>
    <message>
        <source>Waiting some seconds: an answer may come twice</source>
        <translation>等待几秒：应答可能重复到达</translation>
    </message>
    <message>
        <source>Warning: {name}: {what}</source>
        <translation>警告：{name}：{what}</translation>
    </message>
    <message>
        <source>Warnings: {count}</source>
        <translation>警告：{count}</translation>
    </message>
    <message>
        <source>What is read twice and agrees is one module's.</source>
        <translation>两次读取一致，才是同一模块的数据。</translation>
    </message>
    <message>
        <source>What was done</source>
        <translation>维护内容</translation>
    </message>
    <message>
        <source>What was left ACTIVE is not known: the disk is too slow.</source>
        <translation>磁盘太慢，不知道哪些模块仍处于激活状态。</translation>
    </message>
    <message>
        <source>Whether external power charges it.</source>
        <translation>外接供电是否正在充电。</translation>
    </message>
    <message>
        <source>Whether the module has triggered.</source>
        <translation>模块是否已触发。</translation>
    </message>
    <message>
        <source>Who writes, and why</source>
        <translation>写入人及原因</translation>
    </message>
    <message>
        <source>Why</source>
        <translation>原因</translation>
    </message>
    <message>
        <source>Why?</source>
        <translation>为什么？</translation>
    </message>
    <message>
        <source>Windows has no pseudo-terminals: use {option}.</source>
        <translation>Windows 没有伪终端：请使用 {option}。</translation>
    </message>
    <message>
        <source>With external power it is the charging voltage.</source>
        <translation>接有外接供电时为充电电压。</translation>
    </message>
    <message>
        <source>Withdrawn in</source>
        <translation>撤回倒计时</translation>
    </message>
    <message>
        <source>Without a name the result counts for no check.</source>
        <translation>测试时模块未命名：此结果不计入任何检查。</translation>
    </message>
    <message>
        <source>Without a serial number its name identifies it</source>
        <translation>没有序列号，由名称识别</translation>
    </message>
    <message>
        <source>Without reply</source>
        <translation>无响应</translation>
    </message>
    <message>
        <source>Without stream</source>
        <translation>不含串口输出</translation>
    </message>
    <message>
        <source>Without the password</source>
        <translation>不含密码</translation>
    </message>
    <message>
        <source>Wobbles</source>
        <translation>晃动</translation>
    </message>
    <message>
        <source>Write</source>
        <translation>写入</translation>
    </message>
    <message>
        <source>Write ({count})</source>
        <translation>写入（{count}）</translation>
    </message>
    <message>
        <source>Write 1 change</source>
        <translation>写入 1 项更改</translation>
    </message>
    <message>
        <source>Write a setting</source>
        <translation>写入参数</translation>
    </message>
    <message>
        <source>Write and verify</source>
        <translation>写入并验证</translation>
    </message>
    <message>
        <source>Write anyway</source>
        <translation>仍然写入</translation>
    </message>
    <message>
        <source>Write it on the Settings page.</source>
        <translation>在“参数设置”页面写入。</translation>
    </message>
    <message>
        <source>Write the default</source>
        <translation>写入默认值</translation>
    </message>
    <message>
        <source>Write the profile's value</source>
        <translation>写入配置文件的值</translation>
    </message>
    <message>
        <source>Write what differs from the profile, or approve.</source>
        <translation>写入与配置文件不同之处，或批准。</translation>
    </message>
    <message>
        <source>Write {count} changes</source>
        <translation>写入 {count} 项更改</translation>
    </message>
    <message>
        <source>Write {example}. The password belongs into ~/.pgpass or a service file.</source>
        <translation>请写作 {example}。密码应保存在 ~/.pgpass 或服务文件中。</translation>
    </message>
    <message>
        <source>Writing: {what}</source>
        <translation>正在写入：{what}</translation>
    </message>
    <message>
        <source>Written {when}: {what}</source>
        <translation>写入于 {when}：{what}</translation>
    </message>
    <message>
        <source>Wrong rate?</source>
        <translation>波特率不对？</translation>
    </message>
    <message>
        <source>Zero the sensor</source>
        <translation>传感器置零</translation>
    </message>
    <message>
        <source>a condition is not met</source>
        <translation>某项条件不再满足</translation>
    </message>
    <message>
        <source>a number is needed</source>
        <translation>需要一个数</translation>
    </message>
    <message>
        <source>a person</source>
        <translation>人员</translation>
    </message>
    <message>
        <source>acknowledged</source>
        <translation>已应答</translation>
    </message>
    <message>
        <source>acknowledged (cannot be read back)</source>
        <translation>已应答（无法回读）</translation>
    </message>
    <message>
        <source>acknowledged {time} ago</source>
        <translation>{time}前应答</translation>
    </message>
    <message>
        <source>acknowledged, still at the old rate: restart the module</source>
        <translation>已应答，仍为原波特率：请重启模块</translation>
    </message>
    <message>
        <source>activate before the flight</source>
        <translation>模块锁定，飞行前须激活</translation>
    </message>
    <message>
        <source>activated</source>
        <translation>已激活</translation>
    </message>
    <message>
        <source>active</source>
        <translation>已激活</translation>
    </message>
    <message>
        <source>after the impact</source>
        <translation>已在撞击之后</translation>
    </message>
    <message>
        <source>all records reviewed</source>
        <translation>全部记录已复核</translation>
    </message>
    <message>
        <source>another module</source>
        <translation>另一个模块</translation>
    </message>
    <message>
        <source>another module?</source>
        <translation>是另一个模块吗？</translation>
    </message>
    <message>
        <source>another press</source>
        <translation>按住期间有其他按键</translation>
    </message>
    <message>
        <source>as read with the bay open</source>
        <translation>等于伞仓打开时的读数</translation>
    </message>
    <message>
        <source>at {time:.2f} s: {why}</source>
        <translation>{time:.2f} s：{why}</translation>
    </message>
    <message>
        <source>attitude</source>
        <translation>姿态</translation>
    </message>
    <message>
        <source>attitude, {tilt:.0f}°</source>
        <translation>姿态，{tilt:.0f}°</translation>
    </message>
    <message>
        <source>back</source>
        <translation>向后</translation>
    </message>
    <message>
        <source>baud</source>
        <translation>波特</translation>
    </message>
    <message>
        <source>baud rate changed</source>
        <translation>波特率已更改</translation>
    </message>
    <message>
        <source>bay closed</source>
        <translation>伞仓关闭</translation>
    </message>
    <message>
        <source>bay open</source>
        <translation>伞仓打开</translation>
    </message>
    <message>
        <source>before the restart</source>
        <translation>重启之前</translation>
    </message>
    <message>
        <source>being recorded</source>
        <translation>记录中</translation>
    </message>
    <message>
        <source>bench test</source>
        <translation>台架测试</translation>
    </message>
    <message>
        <source>boot count {now}, was {before}</source>
        <translation>开机次数为 {now}，原为 {before}</translation>
    </message>
    <message>
        <source>both off</source>
        <translation>均已禁用</translation>
    </message>
    <message>
        <source>both on</source>
        <translation>均已启用</translation>
    </message>
    <message>
        <source>broken off</source>
        <translation>帧不完整</translation>
    </message>
    <message>
        <source>built in</source>
        <translation>内置</translation>
    </message>
    <message>
        <source>buttons not in sight</source>
        <translation>按钮未完整显示</translation>
    </message>
    <message>
        <source>cancelled</source>
        <translation>已取消</translation>
    </message>
    <message>
        <source>cannot be read</source>
        <translation>无法读取</translation>
    </message>
    <message>
        <source>changed</source>
        <translation>已变化</translation>
    </message>
    <message>
        <source>changed: by itself, or another module?</source>
        <translation>已变化：自行变化，还是另一个模块？</translation>
    </message>
    <message>
        <source>charger unknown</source>
        <translation>充电状态未知</translation>
    </message>
    <message>
        <source>charging</source>
        <translation>充电中</translation>
    </message>
    <message>
        <source>checking…</source>
        <translation>检查中…</translation>
    </message>
    <message>
        <source>choose</source>
        <translation>选择</translation>
    </message>
    <message>
        <source>computer slept</source>
        <translation>电脑曾休眠</translation>
    </message>
    <message>
        <source>confirmed</source>
        <translation>已确认</translation>
    </message>
    <message>
        <source>connected</source>
        <translation>已连接</translation>
    </message>
    <message>
        <source>control lost (estimate)</source>
        <translation>失控（估计）</translation>
    </message>
    <message>
        <source>could not be read back</source>
        <translation>无法回读</translation>
    </message>
    <message>
        <source>cut off</source>
        <translation>中断</translation>
    </message>
    <message>
        <source>damaged</source>
        <translation>已损坏</translation>
    </message>
    <message>
        <source>damaged data left out</source>
        <translation>损坏的数据已略去</translation>
    </message>
    <message>
        <source>damaged, or encrypted</source>
        <translation>已损坏或已加密</translation>
    </message>
    <message>
        <source>days</source>
        <translation>天</translation>
    </message>
    <message>
        <source>device or socket://host:port</source>
        <translation>设备名或 socket://主机:端口</translation>
    </message>
    <message>
        <source>did you mean {name}?</source>
        <translation>是否指 {name}？</translation>
    </message>
    <message>
        <source>different</source>
        <translation>不同</translation>
    </message>
    <message>
        <source>do not fly</source>
        <translation>检查未通过</translation>
    </message>
    <message>
        <source>done</source>
        <translation>已完成</translation>
    </message>
    <message>
        <source>doubled</source>
        <translation>重复</translation>
    </message>
    <message>
        <source>echo</source>
        <translation>回显</translation>
    </message>
    <message>
        <source>edited</source>
        <translation>已修改</translation>
    </message>
    <message>
        <source>enabled</source>
        <translation>已启用</translation>
    </message>
    <message>
        <source>enabled in this conversation</source>
        <translation>在本次通信中启用</translation>
    </message>
    <message>
        <source>entries</source>
        <translation>填写内容</translation>
    </message>
    <message>
        <source>expected {expected}</source>
        <translation>应为 {expected}</translation>
    </message>
    <message>
        <source>failed</source>
        <translation>失败</translation>
    </message>
    <message>
        <source>fall off</source>
        <translation>失重已禁用</translation>
    </message>
    <message>
        <source>false trigger</source>
        <translation>误触发</translation>
    </message>
    <message>
        <source>fell (below {acceleration} for {seconds})</source>
        <translation>失重（低于 {acceleration} 达 {seconds}）</translation>
    </message>
    <message>
        <source>fired by {source}</source>
        <translation>触发来源：{source}</translation>
    </message>
    <message>
        <source>fires</source>
        <translation>触发</translation>
    </message>
    <message>
        <source>fit to fly</source>
        <translation>已激活，检查全部通过</translation>
    </message>
    <message>
        <source>flight controller</source>
        <translation>飞控</translation>
    </message>
    <message>
        <source>focus lost</source>
        <translation>键盘焦点移到别处</translation>
    </message>
    <message>
        <source>forward</source>
        <translation>向前</translation>
    </message>
    <message>
        <source>free fall</source>
        <translation>失重</translation>
    </message>
    <message>
        <source>holds for {time}</source>
        <translation>有效期剩余 {time}</translation>
    </message>
    <message>
        <source>impact</source>
        <translation>撞地</translation>
    </message>
    <message>
        <source>impossible value</source>
        <translation>数值不可能</translation>
    </message>
    <message>
        <source>interrupted</source>
        <translation>被中断</translation>
    </message>
    <message>
        <source>interrupted; may have been carried out</source>
        <translation>已中断，可能已执行</translation>
    </message>
    <message>
        <source>invalid</source>
        <translation>无效</translation>
    </message>
    <message>
        <source>it is closed</source>
        <translation>已关闭</translation>
    </message>
    <message>
        <source>it is still being opened</source>
        <translation>仍在打开</translation>
    </message>
    <message>
        <source>it needs a newer version of this program</source>
        <translation>需要本程序的更新版本</translation>
    </message>
    <message>
        <source>its times begin again, as of several flights in one table</source>
        <translation>时间重新开始，像是一个表格中有多次飞行</translation>
    </message>
    <message>
        <source>late</source>
        <translation>响应延迟</translation>
    </message>
    <message>
        <source>left</source>
        <translation>向左</translation>
    </message>
    <message>
        <source>limit {limit}</source>
        <translation>限值 {limit}</translation>
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
        <source>link lost</source>
        <translation>通信中断</translation>
    </message>
    <message>
        <source>locked</source>
        <translation>已锁定</translation>
    </message>
    <message>
        <source>longer than 48 hours</source>
        <translation>超过 48 小时</translation>
    </message>
    <message>
        <source>longer: fewer false triggers, more height lost</source>
        <translation>越长误触发越少，损失高度越多</translation>
    </message>
    <message>
        <source>lost</source>
        <translation>已丢失</translation>
    </message>
    <message>
        <source>low</source>
        <translation>电压低</translation>
    </message>
    <message>
        <source>may have fired</source>
        <translation>可能已触发</translation>
    </message>
    <message>
        <source>may have fired before the restart</source>
        <translation>重启前可能已触发</translation>
    </message>
    <message>
        <source>measuring… {done}</source>
        <translation>正在测量… {done}</translation>
    </message>
    <message>
        <source>module not named</source>
        <translation>模块未命名</translation>
    </message>
    <message>
        <source>more than one vehicle in one file</source>
        <translation>一个文件中有多架飞行器</translation>
    </message>
    <message>
        <source>must fire</source>
        <translation>必须触发</translation>
    </message>
    <message>
        <source>must not fire</source>
        <translation>不得触发</translation>
    </message>
    <message>
        <source>named</source>
        <translation>已命名</translation>
    </message>
    <message>
        <source>never</source>
        <translation>从未</translation>
    </message>
    <message>
        <source>no</source>
        <translation>否</translation>
    </message>
    <message>
        <source>no answer at any rate: switch the module off and on, then find its rate</source>
        <translation>任何波特率均无应答：请将模块断电再上电，然后查找其波特率</translation>
    </message>
    <message>
        <source>no attitude and no acceleration</source>
        <translation>没有姿态和加速度数据</translation>
    </message>
    <message>
        <source>no cause stated</source>
        <translation>未注明原因</translation>
    </message>
    <message>
        <source>no column names in the first line</source>
        <translation>第一行没有列名</translation>
    </message>
    <message>
        <source>no data</source>
        <translation>无数据</translation>
    </message>
    <message>
        <source>no earlier visit</source>
        <translation>没有历史记录</translation>
    </message>
    <message>
        <source>no external power</source>
        <translation>未接外接供电</translation>
    </message>
    <message>
        <source>no file in the archive</source>
        <translation>压缩包中没有文件</translation>
    </message>
    <message>
        <source>no frame</source>
        <translation>不是有效帧</translation>
    </message>
    <message>
        <source>no frame header</source>
        <translation>没有帧头</translation>
    </message>
    <message>
        <source>no interruption</source>
        <translation>无中断</translation>
    </message>
    <message>
        <source>no reply</source>
        <translation>无应答</translation>
    </message>
    <message>
        <source>no reply within {seconds:.1f} s, asked {attempts} times</source>
        <translation>{seconds:.1f} 秒内无应答，已询问 {attempts} 次</translation>
    </message>
    <message>
        <source>no reply within {seconds:.1f} s; may have been carried out</source>
        <translation>{seconds:.1f} s 内无应答；命令可能已执行</translation>
    </message>
    <message>
        <source>no reply: new, no records</source>
        <translation>无应答：新模块，无记录</translation>
    </message>
    <message>
        <source>no reply; had {count} on {date}</source>
        <translation>无应答；{date} 时有 {count} 条</translation>
    </message>
    <message>
        <source>no reply; may have been carried out</source>
        <translation>无应答，可能已执行</translation>
    </message>
    <message>
        <source>no rows</source>
        <translation>没有数据行</translation>
    </message>
    <message>
        <source>no serial number</source>
        <translation>无序列号</translation>
    </message>
    <message>
        <source>no status reports</source>
        <translation>没有状态上报</translation>
    </message>
    <message>
        <source>no trigger</source>
        <translation>漏触发</translation>
    </message>
    <message>
        <source>none</source>
        <translation>无</translation>
    </message>
    <message>
        <source>none approved</source>
        <translation>尚未批准</translation>
    </message>
    <message>
        <source>not TOML: {why}.</source>
        <translation>不是 TOML：{why}。</translation>
    </message>
    <message>
        <source>not a recording by this program</source>
        <translation>不是本程序的数据记录</translation>
    </message>
    <message>
        <source>not acknowledged</source>
        <translation>未得到正确应答</translation>
    </message>
    <message>
        <source>not asked</source>
        <translation>未询问</translation>
    </message>
    <message>
        <source>not charging</source>
        <translation>未充电</translation>
    </message>
    <message>
        <source>not checked</source>
        <translation>未检查</translation>
    </message>
    <message>
        <source>not confirmed</source>
        <translation>未确认</translation>
    </message>
    <message>
        <source>not enabled in this conversation</source>
        <translation>本次通信中未启用</translation>
    </message>
    <message>
        <source>not in the archive any more</source>
        <translation>压缩包中已没有此文件</translation>
    </message>
    <message>
        <source>not in the profile</source>
        <translation>配置文件中没有</translation>
    </message>
    <message>
        <source>not judged</source>
        <translation>未判断</translation>
    </message>
    <message>
        <source>not known</source>
        <translation>未知</translation>
    </message>
    <message>
        <source>not measured yet</source>
        <translation>尚未测量</translation>
    </message>
    <message>
        <source>not named</source>
        <translation>未填写</translation>
    </message>
    <message>
        <source>not possible</source>
        <translation>无效</translation>
    </message>
    <message>
        <source>not read</source>
        <translation>未读取</translation>
    </message>
    <message>
        <source>not read again</source>
        <translation>无法重新读取</translation>
    </message>
    <message>
        <source>not read yet</source>
        <translation>尚未读取</translation>
    </message>
    <message>
        <source>not reviewed</source>
        <translation>未复核</translation>
    </message>
    <message>
        <source>not sent</source>
        <translation>未发送</translation>
    </message>
    <message>
        <source>not sent: a condition is not met</source>
        <translation>未发送：有条件未满足</translation>
    </message>
    <message>
        <source>not sent: the module stopped answering</source>
        <translation>未发送：模块不再应答</translation>
    </message>
    <message>
        <source>not sent: {why}</source>
        <translation>未发送：{why}</translation>
    </message>
    <message>
        <source>not set</source>
        <translation>未写入</translation>
    </message>
    <message>
        <source>not sorted yet</source>
        <translation>未分类</translation>
    </message>
    <message>
        <source>not tested</source>
        <translation>未测试</translation>
    </message>
    <message>
        <source>not triggered</source>
        <translation>未触发</translation>
    </message>
    <message>
        <source>not up to {angle:.0f}°</source>
        <translation>到 {angle:.0f}° 仍未触发</translation>
    </message>
    <message>
        <source>not written (dry run)</source>
        <translation>未写入（试运行）</translation>
    </message>
    <message>
        <source>nothing overdue</source>
        <translation>无逾期</translation>
    </message>
    <message>
        <source>now</source>
        <translation>现在</translation>
    </message>
    <message>
        <source>offline</source>
        <translation>离线</translation>
    </message>
    <message>
        <source>on external power, {voltage}</source>
        <translation>接外接供电，{voltage}</translation>
    </message>
    <message>
        <source>open</source>
        <translation>未完成</translation>
    </message>
    <message>
        <source>optional</source>
        <translation>可选</translation>
    </message>
    <message>
        <source>other trigger records, another module?</source>
        <translation>触发记录不同，是另一个模块吗？</translation>
    </message>
    <message>
        <source>over {value}°</source>
        <translation>超过 {value}°</translation>
    </message>
    <message>
        <source>passed</source>
        <translation>通过</translation>
    </message>
    <message>
        <source>paused, {time} behind</source>
        <translation>已暂停，落后 {time}</translation>
    </message>
    <message>
        <source>port lost</source>
        <translation>串口断开</translation>
    </message>
    <message>
        <source>program error</source>
        <translation>程序出错</translation>
    </message>
    <message>
        <source>psycopg is not installed: {command}</source>
        <translation>未安装 psycopg：{command}</translation>
    </message>
    <message>
        <source>query</source>
        <translation>查询</translation>
    </message>
    <message>
        <source>read</source>
        <translation>已读取</translation>
    </message>
    <message>
        <source>read {time} ago</source>
        <translation>{time}前读取</translation>
    </message>
    <message>
        <source>readers: {count}</source>
        <translation>读取方：{count}</translation>
    </message>
    <message>
        <source>readings differ</source>
        <translation>多次读取不一致</translation>
    </message>
    <message>
        <source>real</source>
        <translation>真实触发</translation>
    </message>
    <message>
        <source>recorded</source>
        <translation>记录内容</translation>
    </message>
    <message>
        <source>refused</source>
        <translation>被拒绝</translation>
    </message>
    <message>
        <source>refused; the old value stands</source>
        <translation>被拒绝，保持原值</translation>
    </message>
    <message>
        <source>released too early</source>
        <translation>未按满 2 秒即松开</translation>
    </message>
    <message>
        <source>reply</source>
        <translation>应答</translation>
    </message>
    <message>
        <source>reports in 2 s: only {count}</source>
        <translation>2 秒内的上报：仅 {count} 条</translation>
    </message>
    <message>
        <source>required</source>
        <translation>必需</translation>
    </message>
    <message>
        <source>restarted</source>
        <translation>已重启</translation>
    </message>
    <message>
        <source>reviewed</source>
        <translation>已复核</translation>
    </message>
    <message>
        <source>right</source>
        <translation>向右</translation>
    </message>
    <message>
        <source>rows: {rows}</source>
        <translation>行数：{rows}</translation>
    </message>
    <message>
        <source>same</source>
        <translation>一致</translation>
    </message>
    <message>
        <source>seen once</source>
        <translation>仅一次</translation>
    </message>
    <message>
        <source>seen {time} ago</source>
        <translation>{time}前收到</translation>
    </message>
    <message>
        <source>sent</source>
        <translation>发送</translation>
    </message>
    <message>
        <source>separates</source>
        <translation>可区分</translation>
    </message>
    <message>
        <source>serial</source>
        <translation>串口</translation>
    </message>
    <message>
        <source>serial link connected</source>
        <translation>串口已连接</translation>
    </message>
    <message>
        <source>serial link not connected</source>
        <translation>串口未连接</translation>
    </message>
    <message>
        <source>serial number {number}</source>
        <translation>序列号 {number}</translation>
    </message>
    <message>
        <source>set</source>
        <translation>写入</translation>
    </message>
    <message>
        <source>settings kept</source>
        <translation>参数保持不变</translation>
    </message>
    <message>
        <source>several records</source>
        <translation>含多条记录</translation>
    </message>
    <message>
        <source>silent</source>
        <translation>无应答</translation>
    </message>
    <message>
        <source>simulated</source>
        <translation>模拟</translation>
    </message>
    <message>
        <source>skipped</source>
        <translation>已跳过</translation>
    </message>
    <message>
        <source>stale</source>
        <translation>已过时</translation>
    </message>
    <message>
        <source>stated {stated}, but the checks give {follows}</source>
        <translation>结论为 {stated}，但检查结果应为 {follows}</translation>
    </message>
    <message>
        <source>stream</source>
        <translation>串口输出</translation>
    </message>
    <message>
        <source>the aircraft</source>
        <translation>飞行器</translation>
    </message>
    <message>
        <source>the aircraft activates it</source>
        <translation>模块锁定，由飞行器激活</translation>
    </message>
    <message>
        <source>the disk is full</source>
        <translation>磁盘已满</translation>
    </message>
    <message>
        <source>the disk is too slow</source>
        <translation>磁盘太慢</translation>
    </message>
    <message>
        <source>the module answers</source>
        <translation>模块已应答</translation>
    </message>
    <message>
        <source>the records do not follow those of its last visit</source>
        <translation>触发记录与上次读取的不衔接</translation>
    </message>
    <message>
        <source>the same throughout; GO: active</source>
        <translation>检查期间不变；激活后才可以飞行</translation>
    </message>
    <message>
        <source>this line repeats answers: not known</source>
        <translation>此线路会重复应答：未知</translation>
    </message>
    <message>
        <source>this name is not possible</source>
        <translation>不能使用此名称</translation>
    </message>
    <message>
        <source>tilt off</source>
        <translation>倾角已禁用</translation>
    </message>
    <message>
        <source>time is up</source>
        <translation>十秒已过</translation>
    </message>
    <message>
        <source>tipped past {threshold}</source>
        <translation>倾斜超过 {threshold}</translation>
    </message>
    <message>
        <source>too high</source>
        <translation>过高</translation>
    </message>
    <message>
        <source>too large</source>
        <translation>过大</translation>
    </message>
    <message>
        <source>too late</source>
        <translation>过晚</translation>
    </message>
    <message>
        <source>trigger ended</source>
        <translation>触发结束</translation>
    </message>
    <message>
        <source>trigger not known</source>
        <translation>自动触发未知</translation>
    </message>
    <message>
        <source>trigger off</source>
        <translation>自动触发已禁用</translation>
    </message>
    <message>
        <source>triggered</source>
        <translation>已触发</translation>
    </message>
    <message>
        <source>triggers</source>
        <translation>自动触发</translation>
    </message>
    <message>
        <source>two modules?</source>
        <translation>两个模块？</translation>
    </message>
    <message>
        <source>unasked</source>
        <translation>主动</translation>
    </message>
    <message>
        <source>unchanged</source>
        <translation>未变</translation>
    </message>
    <message>
        <source>unclear</source>
        <translation>不明确</translation>
    </message>
    <message>
        <source>unknown</source>
        <translation>未知</translation>
    </message>
    <message>
        <source>unknown code</source>
        <translation>未知命令码</translation>
    </message>
    <message>
        <source>unknown kind of file</source>
        <translation>未知的文件类型</translation>
    </message>
    <message>
        <source>unknown: {why}</source>
        <translation>未知：{why}</translation>
    </message>
    <message>
        <source>verified</source>
        <translation>已验证</translation>
    </message>
    <message>
        <source>verified then, before the interruption</source>
        <translation>中断前已验证</translation>
    </message>
    <message>
        <source>void</source>
        <translation>作废</translation>
    </message>
    <message>
        <source>warning</source>
        <translation>警告</translation>
    </message>
    <message>
        <source>was ACTIVE</source>
        <translation>曾激活</translation>
    </message>
    <message>
        <source>window left</source>
        <translation>离开了窗口</translation>
    </message>
    <message>
        <source>window was busy</source>
        <translation>窗口繁忙</translation>
    </message>
    <message>
        <source>writing</source>
        <translation>写入中</translation>
    </message>
    <message>
        <source>written</source>
        <translation>已写入</translation>
    </message>
    <message>
        <source>written by a newer version</source>
        <translation>由更新版本的程序写入</translation>
    </message>
    <message>
        <source>written by another version</source>
        <translation>由其他版本写入</translation>
    </message>
    <message>
        <source>wrong checksum</source>
        <translation>校验错误</translation>
    </message>
    <message>
        <source>wrong control byte</source>
        <translation>控制字节错误</translation>
    </message>
    <message>
        <source>yes</source>
        <translation>是</translation>
    </message>
    <message>
        <source>{act}: {module} on {port}</source>
        <translation>{act}：{module}（{port}）</translation>
    </message>
    <message>
        <source>{code}: no reply.</source>
        <translation>{code}：无应答。</translation>
    </message>
    <message>
        <source>{code}: {answer}, status: {reported}.</source>
        <translation>{code}：{answer}，状态：{reported}。</translation>
    </message>
    <message>
        <source>{count} more</source>
        <translation>另有 {count} 条</translation>
    </message>
    <message>
        <source>{count} new</source>
        <translation>{count} 条新增</translation>
    </message>
    <message>
        <source>{count} of {total} fire</source>
        <translation>{total} 次中 {count} 次触发</translation>
    </message>
    <message>
        <source>{count} of {total} fire in time</source>
        <translation>{total} 次中 {count} 次及时触发</translation>
    </message>
    <message>
        <source>{count} of {total} not judged.</source>
        <translation>{total} 个中有 {count} 个未判断。</translation>
    </message>
    <message>
        <source>{count} of {total} not read.</source>
        <translation>{total} 个中有 {count} 个未读取。</translation>
    </message>
    <message>
        <source>{count} of {total} not read: no statement on the vendor's defaults.</source>
        <translation>{total} 个中有 {count} 个未读取：不对厂家默认值下结论。</translation>
    </message>
    <message>
        <source>{count} passed</source>
        <translation>{count} 项通过</translation>
    </message>
    <message>
        <source>{count} selected</source>
        <translation>已选 {count} 项</translation>
    </message>
    <message>
        <source>{delay:.2f} s after the loss of control</source>
        <translation>失控后 {delay:.2f} s</translation>
    </message>
    <message>
        <source>{file} cannot be read: {why}.</source>
        <translation>无法读取 {file}：{why}。</translation>
    </message>
    <message>
        <source>{file} cannot be used: {why}.</source>
        <translation>{file} 无法使用：{why}。</translation>
    </message>
    <message>
        <source>{file} cannot be written: {why}.</source>
        <translation>无法写入 {file}：{why}。</translation>
    </message>
    <message>
        <source>{file} exists and is another kind of file.</source>
        <translation>{file} 已存在且是其他类型的文件。</translation>
    </message>
    <message>
        <source>{file} exists. Replace it?</source>
        <translation>{file} 已存在，是否替换？</translation>
    </message>
    <message>
        <source>{file} exists: use {options}.</source>
        <translation>{file} 已存在：请使用 {options}。</translation>
    </message>
    <message>
        <source>{file} has other columns or is no recording.</source>
        <translation>{file} 的列不同，或不是数据记录。</translation>
    </message>
    <message>
        <source>{file} is damaged</source>
        <translation>{file} 已损坏</translation>
    </message>
    <message>
        <source>{file} is not a profile: {why}</source>
        <translation>{file} 不是配置文件：{why}</translation>
    </message>
    <message>
        <source>{file}: the name of a report ends in .pdf.</source>
        <translation>{file}：报告的文件名须以 .pdf 结尾。</translation>
    </message>
    <message>
        <source>{folder} cannot be made: {why}.</source>
        <translation>无法创建 {folder}：{why}。</translation>
    </message>
    <message>
        <source>{group}: {what} to spare ({name})</source>
        <translation>{group}：余量 {what}（{name}）</translation>
    </message>
    <message>
        <source>{hours} h {minutes} min {seconds} s</source>
        <translation>{hours} 小时 {minutes} 分 {seconds} 秒</translation>
    </message>
    <message>
        <source>{key}: expected {expected}.</source>
        <translation>{key}：应为 {expected}。</translation>
    </message>
    <message>
        <source>{key}: {why}.</source>
        <translation>{key}：{why}。</translation>
    </message>
    <message>
        <source>{limit} (assumed)</source>
        <translation>{limit}（假定）</translation>
    </message>
    <message>
        <source>{limit}, advised {advised}</source>
        <translation>{limit}，建议 {advised}</translation>
    </message>
    <message>
        <source>{limit}; module not named</source>
        <translation>{limit}；模块未命名</translation>
    </message>
    <message>
        <source>{limit}; {module}, named by a person</source>
        <translation>{limit}；{module}，由人员指定</translation>
    </message>
    <message>
        <source>{lost} of {asked}</source>
        <translation>{asked} 次中 {lost} 次</translation>
    </message>
    <message>
        <source>{lost} of {sent} lost, invalid bytes: {bytes}</source>
        <translation>{sent} 次中丢失 {lost} 次，无效字节：{bytes} 个</translation>
    </message>
    <message>
        <source>{low} to {high}</source>
        <translation>{low} 至 {high}</translation>
    </message>
    <message>
        <source>{low} to {high}, in steps of {step}</source>
        <translation>{low} 至 {high}，步长 {step}</translation>
    </message>
    <message>
        <source>{median:.1f} V ({low:.1f} to {high:.1f} V)</source>
        <translation>{median:.1f} V（{low:.1f} 至 {high:.1f} V）</translation>
    </message>
    <message>
        <source>{minutes} min {seconds} s</source>
        <translation>{minutes} 分 {seconds} 秒</translation>
    </message>
    <message>
        <source>{module} again? Read its label.</source>
        <translation>还是 {module} 吗？请看标签。</translation>
    </message>
    <message>
        <source>{module} is the name of another module: left out.</source>
        <translation>{module} 已是另一模块的名称：跳过。</translation>
    </message>
    <message>
        <source>{module} reported TRIGGERED before {time}.</source>
        <translation>{module} 在 {time} 之前报告过已触发。</translation>
    </message>
    <message>
        <source>{module} was left ACTIVE on {time}.</source>
        <translation>{module} 在 {time} 仍为激活状态。</translation>
    </message>
    <message>
        <source>{module}, interrupted {time}, not written: {what}.</source>
        <translation>{module}，{time} 中断，未写入：{what}。</translation>
    </message>
    <message>
        <source>{module}, {at}, checked by: {who}.</source>
        <translation>{module}，{at}，检查人：{who}。</translation>
    </message>
    <message>
        <source>{module}, {time}: {what}</source>
        <translation>{module}，{time}：{what}</translation>
    </message>
    <message>
        <source>{module}: LOCK not confirmed on {time}.</source>
        <translation>{module}：{time} 的锁定未确认。</translation>
    </message>
    <message>
        <source>{module}: {new} new; records: {count}.</source>
        <translation>{module}：新增 {new} 条；共有记录：{count} 条。</translation>
    </message>
    <message>
        <source>{names} and {count} more</source>
        <translation>{names} 及另外 {count} 项</translation>
    </message>
    <message>
        <source>{name} is also the name of other keys: {fingerprints}.</source>
        <translation>其他密钥也用 {name} 这个名称：{fingerprints}。</translation>
    </message>
    <message>
        <source>{name} is given twice.</source>
        <translation>{name} 给了两次。</translation>
    </message>
    <message>
        <source>{name} {now}, was {before}</source>
        <translation>{name}为 {now}，原为 {before}</translation>
    </message>
    <message>
        <source>{name}: at most {count} characters.</source>
        <translation>{name}：最多 {count} 个字符。</translation>
    </message>
    <message>
        <source>{name}: {value}</source>
        <translation>{name}：{value}</translation>
    </message>
    <message>
        <source>{new} of {total} not reviewed</source>
        <translation>{total} 条中有 {new} 条未复核</translation>
    </message>
    <message>
        <source>{option} takes one port only.</source>
        <translation>{option} 只能用于一个端口。</translation>
    </message>
    <message>
        <source>{path} holds no settings.</source>
        <translation>{path} 中没有设置。</translation>
    </message>
    <message>
        <source>{port} cannot be reached.</source>
        <translation>无法连接 {port}。</translation>
    </message>
    <message>
        <source>{port} does not open within {seconds:.0f} s.</source>
        <translation>{port} 在 {seconds:.0f} s 内未能打开。</translation>
    </message>
    <message>
        <source>{port} is in use by another program, perhaps ModemManager.</source>
        <translation>{port} 正被另一个程序占用，可能是 ModemManager。</translation>
    </message>
    <message>
        <source>{port} is in use by another program.</source>
        <translation>{port} 正被其他程序占用。</translation>
    </message>
    <message>
        <source>{port} is no serial port.</source>
        <translation>{port} 不是串口。</translation>
    </message>
    <message>
        <source>{port} was unplugged, or its driver failed.</source>
        <translation>{port} 已被拔出，或其驱动程序出错。</translation>
    </message>
    <message>
        <source>{port}, {rate} baud</source>
        <translation>{port}，{rate} 波特</translation>
    </message>
    <message>
        <source>{rate} baud</source>
        <translation>波特率 {rate}</translation>
    </message>
    <message>
        <source>{seconds:.2f} s of free fall is {height:.1f} m before it fires, at {speed:.0f} km/h.</source>
        <translation>失重 {seconds:.2f} 秒后开伞，此时已下落 {height:.1f} m，速度 {speed:.0f} km/h。</translation>
    </message>
    <message>
        <source>{setting} on the module: {value}</source>
        <translation>模块上的{setting}：{value}</translation>
    </message>
    <message>
        <source>{setting}: {before}, then {after}. Two modules on this line?</source>
        <translation>{setting}：先是 {before}，后是 {after}。此线路上有两个模块吗？</translation>
    </message>
    <message>
        <source>{slowest:.1f} ms, median {median:.1f} ms</source>
        <translation>{slowest:.1f} ms，中位数 {median:.1f} ms</translation>
    </message>
    <message>
        <source>{state} (assumed)</source>
        <translation>{state}（假定）</translation>
    </message>
    <message>
        <source>{station} wrote with a clock that is ahead: that counts for nothing.</source>
        <translation>{station} 写入时时钟超前：这些记录不计。</translation>
    </message>
    <message>
        <source>{test} within {days} days</source>
        <translation>{test}在 {days} 天内</translation>
    </message>
    <message>
        <source>{text} (implausible)</source>
        <translation>{text}（不可信）</translation>
    </message>
    <message>
        <source>{threshold:.1f} V: at least {margin:.1f} V from closed and from open.</source>
        <translation>{threshold:.1f} V：距关闭和打开状态均至少 {margin:.1f} V。</translation>
    </message>
    <message>
        <source>{time} ago</source>
        <translation>{time}前</translation>
    </message>
    <message>
        <source>{uptime} · boot {boot}</source>
        <translation>{uptime} · 第 {boot} 次开机</translation>
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
        <source>{value} (!) {fault}, limit {limit}</source>
        <translation>{value}（!）{fault}，限值 {limit}</translation>
    </message>
    <message>
        <source>{value} V threshold</source>
        <translation>{value} V 阈值</translation>
    </message>
    <message>
        <source>{value} V threshold?</source>
        <translation>{value} V 阈值？</translation>
    </message>
    <message>
        <source>{value} g free fall</source>
        <translation>{value} g 失重</translation>
    </message>
    <message>
        <source>{value} g free fall?</source>
        <translation>{value} g 失重？</translation>
    </message>
    <message>
        <source>{value} has too many digits</source>
        <translation>{value} 的位数过多</translation>
    </message>
    <message>
        <source>{value} is not one of {values}</source>
        <translation>{value} 不在 {values} 之中</translation>
    </message>
    <message>
        <source>{value} is outside {low} to {high}</source>
        <translation>{value} 超出 {low} 至 {high} 的范围</translation>
    </message>
    <message>
        <source>{value} s</source>
        <translation>{value} 秒</translation>
    </message>
    <message>
        <source>{value}, confirmed by a person</source>
        <translation>{value}，已由人员确认</translation>
    </message>
    <message>
        <source>{value}, {fault}</source>
        <translation>{value}，{fault}</translation>
    </message>
    <message>
        <source>{value}: the nearest steps are {low} and {high}</source>
        <translation>{value}：最近的步进值为 {low} 和 {high}</translation>
    </message>
    <message>
        <source>{value}: {why}</source>
        <translation>{value}：{why}</translation>
    </message>
    <message>
        <source>{value}° fires</source>
        <translation>{value}° 开伞</translation>
    </message>
    <message>
        <source>{value}° fires?</source>
        <translation>{value}° 开伞？</translation>
    </message>
    <message>
        <source>{value}° rearms</source>
        <translation>{value}° 复位</translation>
    </message>
    <message>
        <source>{value}° rearms?</source>
        <translation>{value}° 复位？</translation>
    </message>
    <message>
        <source>{verdict} (simulated)</source>
        <translation>{verdict}（模拟）</translation>
    </message>
    <message>
        <source>{verdict} (void)</source>
        <translation>{verdict}（作废）</translation>
    </message>
    <message>
        <source>{verdict} (void: fired since)</source>
        <translation>{verdict}（已作废：此后已触发）</translation>
    </message>
    <message>
        <source>{voltage} may be the charger's</source>
        <translation>{voltage} 可能是充电器的电压</translation>
    </message>
    <message>
        <source>{wanted} was sent: {why}.</source>
        <translation>已发送 {wanted}：{why}。</translation>
    </message>
    <message>
        <source>{wanted} was sent: {why}. It holds {stands}.</source>
        <translation>已发送 {wanted}：{why}。模块当前为 {stands}。</translation>
    </message>
    <message>
        <source>{what} ({done} of {total})</source>
        <translation>{what}（{done}/{total}）</translation>
    </message>
    <message>
        <source>{what} due on {date}, days left: {days}.</source>
        <translation>{what}将于 {date} 到期，剩余天数：{days}。</translation>
    </message>
    <message>
        <source>{what} on {date} by {who}, due again: {due}.</source>
        <translation>{what}：{date}，执行人 {who}，下次：{due}。</translation>
    </message>
    <message>
        <source>{what} overdue since {date}.</source>
        <translation>{what}已逾期（{date} 到期）。</translation>
    </message>
    <message>
        <source>{what} {uptime} after power-on of boot {boot}, {link}, {voltage}</source>
        <translation>第 {boot} 次开机后 {uptime}：{what}，{link}，{voltage}</translation>
    </message>
    <message>
        <source>{what}: confirmed.</source>
        <translation>{what}：已确认。</translation>
    </message>
    <message>
        <source>{what}: may have been carried out.</source>
        <translation>{what}：可能已执行。</translation>
    </message>
    <message>
        <source>{what}: not sent.</source>
        <translation>{what}：未发送。</translation>
    </message>
    <message>
        <source>{what}: refused.</source>
        <translation>{what}：被拒绝。</translation>
    </message>
    <message>
        <source>{why} Say which column holds what, in which unit: {cure} (columns: {columns}).</source>
        <translation>{why}请指明哪一列是什么、用什么单位：{cure}（列：{columns}）。</translation>
    </message>
    <message>
        <source>{why}.</source>
        <translation>{why}。</translation>
    </message>
    <message>
        <source>{word}: neither hex nor a file</source>
        <translation>{word}：既不是十六进制，也不是文件</translation>
    </message>
    <message>
        <source>“dps-s verify FILE” tells what this file says and who signed it. Keep it with the aircraft.</source>
        <translation>“dps-s verify FILE”说明此文件中记录的内容和签名者。请与飞行器文档一并保存。</translation>
    </message>
    <message>
        <source>“{cell}” can be {one} or {other}.</source>
        <translation>“{cell}”可以是 {one} 或 {other}。</translation>
    </message>
    <message>
        <source>“{name}” is in {unit}.</source>
        <translation>“{name}”的单位是 {unit}。</translation>
    </message>
    <message>
        <source>“{name}” is there twice.</source>
        <translation>“{name}”出现两次。</translation>
    </message>
    <message>
        <source>“{name}” is unknown.</source>
        <translation>“{name}”未知。</translation>
    </message>
    <message>
        <source>“{name}” is unknown; the columns are {columns}.</source>
        <translation>未知的“{name}”；有这些列：{columns}。</translation>
    </message>
    <message>
        <source>“{name}” reaches {value:.0f}°: its unit is another.</source>
        <translation>“{name}”达到 {value:.0f}°：单位不是度。</translation>
    </message>
    <message>
        <source>“{word}”: ROLE=COLUMN is needed, of {roles}.</source>
        <translation>“{word}”：应为 ROLE=COLUMN，可用 {roles}。</translation>
    </message>
    <message>
        <source>≥ last visit</source>
        <translation>≥ 上次连接</translation>
    </message>
    <message>
        <source>≥ {margin:.1f} V from {threshold:.1f} V</source>
        <translation>距 {threshold:.1f} V ≥ {margin:.1f} V</translation>
    </message>
</context>
</TS>
