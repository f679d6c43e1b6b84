-- 3964R and RK512 in Wireshark and tshark, for captures made by `axisgate line export TRACE -o FILE.pcapng`.
--
--   tshark -X lua_script:axisgate_3964r.lua -r FILE.pcapng
--   Wireshark: copy this file into the folder "Personal Lua Plugins" (Help, About, Folders)
--
-- Link type USER0 (147); every packet begins with a pseudo header of 8 bytes: version 1, direction (0 = A to B), kind (1 STX, 2 DLE,
-- 3 NAK, 4 block, 5 broken block, 6 stray), flags, microseconds from first to last character (big endian).  docs/guide/trace.md.
-- Filters: p3964r.kind, p3964r.bcc.ok, rk512.command, rk512.error, ...  Runs with Lua 5.2 to 5.4: no bit library is used.

local p3964r = Proto("p3964r", "3964R")
local rk512 = Proto("rk512", "RK512 computer link")

local KINDS = { [1] = "STX", [2] = "DLE", [3] = "NAK", [4] = "block", [5] = "broken block", [6] = "stray characters" }
local FLAGS = { { 0x01, "parity" }, { 0x02, "framing" }, { 0x04, "overrun" }, { 0x08, "break" }, { 0x10, "did not arrive" },
                { 0x20, "arrived altered" }, { 0x40, "no block check" } }
local ERRORS = { [0x00] = "no error", [0x0A] = "access to the area not possible or not allowed", [0x0C] = "data type not valid",
                 [0x10] = "header error", [0x12] = "data type not served", [0x14] = "block missing or too short",
                 [0x16] = "command (byte 3) wrong", [0x2A] = "partner in STOP", [0x32] = "locked by coordination flag",
                 [0x34] = "length wrong", [0x36] = "sequence: follow-on without a first telegram" }
local COMMANDS = { [0x41] = "SEND", [0x4F] = "SEND (extended block)", [0x45] = "FETCH" }
local AREAS = { [0x44] = "D data block", [0x58] = "X extended data block", [0x45] = "E inputs", [0x41] = "A outputs", [0x4D] = "M flags",
                [0x54] = "T timers", [0x5A] = "Z counters", [0x50] = "P peripheral", [0x42] = "B memory", [0x53] = "S system" }
local IN_BYTES = { [0x45] = true, [0x41] = true, [0x4D] = true }

local f = {
  direction = ProtoField.string("p3964r.direction", "Direction"),
  kind = ProtoField.uint8("p3964r.kind", "Kind", base.DEC, KINDS),
  meaning = ProtoField.string("p3964r.meaning", "Meaning"),
  flags = ProtoField.uint8("p3964r.flags", "Flags", base.HEX),
  flag = ProtoField.string("p3964r.flag", "Flag"),
  time = ProtoField.uint32("p3964r.time_us", "First to last character [us]", base.DEC),
  characters = ProtoField.bytes("p3964r.characters", "Characters on the line"),
  data = ProtoField.bytes("p3964r.data", "Data, a doubled DLE once"),
  count = ProtoField.uint16("p3964r.count", "Data bytes", base.DEC),
  ending = ProtoField.string("p3964r.end", "End"),
  bcc = ProtoField.uint8("p3964r.bcc", "Block check", base.HEX),
  bcc_wanted = ProtoField.uint8("p3964r.bcc.computed", "Computed block check", base.HEX),
  bcc_ok = ProtoField.bool("p3964r.bcc.ok", "Block check right"),
}
p3964r.fields = { f.direction, f.kind, f.meaning, f.flags, f.flag, f.time, f.characters, f.data, f.count, f.ending, f.bcc, f.bcc_wanted, f.bcc_ok }
local damaged = ProtoExpert.new("p3964r.damaged", "Characters damaged, altered or lost", expert.group.MALFORMED, expert.severity.WARN)
local wrong_check = ProtoExpert.new("p3964r.bcc.wrong", "Block check wrong", expert.group.CHECKSUM, expert.severity.ERROR)
local with_stx = ProtoExpert.new("p3964r.bcc.with_stx", "Block check off by 02h: the sender counts STX in", expert.group.CHECKSUM, expert.severity.WARN)
local refused = ProtoExpert.new("p3964r.nak", "NAK", expert.group.SEQUENCE, expert.severity.WARN)
p3964r.experts = { damaged, wrong_check, with_stx, refused }

local r = {
  kind = ProtoField.string("rk512.telegram", "Telegram"),
  follow = ProtoField.bool("rk512.follow_on", "Follow-on telegram"),
  command = ProtoField.uint8("rk512.command", "Command", base.HEX, COMMANDS),
  area = ProtoField.uint8("rk512.area", "Area", base.HEX, AREAS),
  db = ProtoField.uint8("rk512.db", "Block number", base.DEC),
  word = ProtoField.uint8("rk512.word", "First word", base.DEC),
  offset = ProtoField.uint16("rk512.offset", "Offset", base.DEC),
  amount = ProtoField.uint16("rk512.amount", "Amount", base.DEC),
  unit = ProtoField.string("rk512.unit", "Amount in"),
  flag = ProtoField.string("rk512.coordination_flag", "Coordination flag"),
  error = ProtoField.uint8("rk512.error", "Error number", base.HEX),
  error_text = ProtoField.string("rk512.error.text", "Error"),
  data = ProtoField.bytes("rk512.data", "Data"),
  request = ProtoField.framenum("rk512.request", "Reaction to the telegram in", base.NONE, frametype.REQUEST),
}
rk512.fields = { r.kind, r.follow, r.command, r.area, r.db, r.word, r.offset, r.amount, r.unit, r.flag, r.error, r.error_text, r.data, r.request }
local failed = ProtoExpert.new("rk512.error.set", "Reaction with an error number", expert.group.RESPONSE_CODE, expert.severity.WARN)
rk512.experts = { failed }

local function has(value, bit) return math.floor(value / bit) % 2 == 1 end

local function xor(a, b)
  local result, bit = 0, 1
  while bit < 256 do
    if has(a, bit) ~= has(b, bit) then result = result + bit end
    bit = bit * 2
  end
  return result
end

-- What came before decides what a DLE, and what a block without a command means; kept for every frame in the first pass.
local seen, last, open = {}, {}, {}
function p3964r.init() seen, last, open = {}, {}, {} end

local function meaning_of(kind, from)
  if kind == 1 then return last.kind == 1 and last.from ~= from and "wish to send, against the partner's" or "wish to send" end
  if kind == 2 then
    if last.kind == 1 and last.from ~= from then return "ready" end
    if last.kind == 4 and last.from ~= from then return "block good" end
    return "DLE out of turn"
  end
  if kind == 3 then
    if last.kind == 1 and last.from ~= from then return "not ready" end
    if (last.kind == 4 or last.kind == 5) and last.from ~= from then return "block bad" end
    return "gave up, or idle"
  end
  return ""
end

-- An RK512 command has its letters at their places; a reaction has three zeros (or FF 00 00), and somebody waits for it.
local function telegram_of(data, from, number)
  local n = data:len()
  if n < 4 then return nil end
  local b0, b1, b2, b3 = data:get_index(0), data:get_index(1), data:get_index(2), data:get_index(3)
  if (b0 ~= 0 and b0 ~= 0xFF) or b1 ~= 0 then return nil end
  if COMMANDS[b2] and AREAS[b3] and (n >= 10 or b0 == 0xFF) then
    open[from] = { number = number, command = b2 }
    return { name = b0 == 0xFF and "follow-on" or "command" }
  end
  local request = open[1 - from]
  if b2 == 0 and request then
    open[1 - from] = nil
    return { name = "reaction", request = request.number, command = request.command }
  end
  return nil
end

local function show_rk512(tvb, pinfo, tree, what)
  local sub = tree:add(rk512, tvb())
  local first, said = tvb(0, 1):uint(), ""
  sub:add(r.follow, tvb(0, 1), first == 0xFF)
  if what.name == "reaction" then
    local number = tvb(3, 1):uint()
    local text = ERRORS[number] or "unknown number"
    said = string.format("reaction to %s, error %02Xh: %s", COMMANDS[what.command], number, text)
    if number == 0 then said = "reaction to " .. COMMANDS[what.command] .. ", no error" end
    sub:add(r.error, tvb(3, 1))
    sub:add(r.error_text, tvb(3, 1), text)
    sub:add(r.request, tvb(0, 0), what.request):set_generated()
    if number ~= 0 then sub:add_proto_expert_info(failed, text) end
    if tvb:len() > 4 then
      sub:add(r.data, tvb(4))
      said = said .. string.format(", %d bytes", tvb:len() - 4)
    end
  else
    local command, area = tvb(2, 1):uint(), tvb(3, 1):uint()
    said = COMMANDS[command] .. " " .. AREAS[area]:sub(1, 1)
    sub:add(r.command, tvb(2, 1))
    sub:add(r.area, tvb(3, 1))
    local at = 4
    if what.name == "follow-on" and not (command == 0x45 and tvb:len() >= 10) then
      said = "follow-on " .. said
    else
      at = 10
      if area == 0x44 or area == 0x58 then
        sub:add(r.db, tvb(4, 1))
        sub:add(r.word, tvb(5, 1))
        said = said .. string.format("B%d DW%d", tvb(4, 1):uint(), tvb(5, 1):uint())
      else
        sub:add(r.offset, tvb(4, 2))
        said = said .. string.format(" %d", tvb(4, 2):uint())
      end
      local unit = IN_BYTES[area] and "bytes" or "words"
      sub:add(r.amount, tvb(6, 2))
      sub:add(r.unit, tvb(6, 2), unit)
      said = said .. string.format(", %d %s", tvb(6, 2):uint(), unit)
      local byte, bit = tvb(8, 1):uint(), tvb(9, 1):uint()
      local flag = byte == 0xFF and "none" or string.format("%d.%d", byte, bit % 16)
      local cpu = math.floor(bit / 16)
      if byte ~= 0xFF and cpu >= 1 and cpu <= 4 then flag = flag .. string.format(", CPU %d", cpu) end
      sub:add(r.flag, tvb(8, 2), flag)
      if byte ~= 0xFF then said = said .. ", flag " .. flag end
    end
    if tvb:len() > at then
      sub:add(r.data, tvb(at))
      said = said .. string.format(", %d bytes of data", tvb:len() - at)
    end
  end
  sub:add(r.kind, tvb(0, 4), said):set_generated()
  sub:append_text(": " .. said)
  pinfo.cols.protocol = "RK512"
  return said
end

local function show_block(range, pinfo, tree, flags, from)
  local data, check, at, ended, closing = ByteArray.new(), 0, 0, nil, ""
  data:set_size(range:len())
  local count = 0
  while at < range:len() do
    local byte = range(at, 1):uint()
    check = xor(check, byte)
    at = at + 1
    if byte == 0x10 and at < range:len() then
      local second = range(at, 1):uint()
      check = xor(check, second)
      at = at + 1
      if second == 0x03 or second == 0x17 then
        ended, closing = at, second == 0x03 and "DLE ETX" or "DLE ETB"
        break
      end
      data:set_index(count, second)
    else
      data:set_index(count, byte)
    end
    count = count + 1
  end
  data:set_size(count)
  tree:add(f.count, range, count)
  local said, good = string.format("block, %d bytes", count), true
  if ended == nil then
    said, good = said .. ", no end", false
  else
    tree:add(f.ending, range(ended - 2, 2), closing)
    if not has(flags, 0x40) and ended < range:len() then
      local bcc = range(ended, 1):uint()
      good = bcc == check
      tree:add(f.bcc, range(ended, 1))
      tree:add(f.bcc_wanted, range(ended, 1), check):set_generated()
      tree:add(f.bcc_ok, range(ended, 1), good):set_generated()
      said = said .. string.format(", BCC %02X %s", bcc, good and "ok" or string.format("wrong (%02X expected)", check))
      if not good then tree:add_proto_expert_info(wrong_check) end
      if xor(bcc, check) == 0x02 then tree:add_proto_expert_info(with_stx) end
    end
  end
  if count == 0 then return said end
  local inner = data:tvb("Data of the block")
  tree:add(f.data, inner())
  local known = seen[pinfo.number]
  if known.telegram == nil then known.telegram = good and telegram_of(data, from, pinfo.number) or false end
  if known.telegram then said = show_rk512(inner, pinfo, known.root, known.telegram) .. "  [" .. said .. "]" end
  return said
end

function p3964r.dissector(tvb, pinfo, root)
  if tvb:len() < 8 or tvb(0, 1):uint() ~= 1 then return 0 end
  local from, kind, flags = tvb(1, 1):uint(), tvb(2, 1):uint(), tvb(3, 1):uint()
  pinfo.cols.protocol = "3964R"
  pinfo.cols.src = from == 0 and "A" or "B"
  pinfo.cols.dst = from == 0 and "B" or "A"
  if not seen[pinfo.number] then
    local now = tonumber(tostring(pinfo.abs_ts)) or 0
    if last.time and now - last.time > 5 then last = {} end  -- nobody waits that long for an answer
    seen[pinfo.number] = { meaning = meaning_of(kind, from) }
    last = { kind = kind, from = from, time = now }
  end
  local known = seen[pinfo.number]
  known.root = root
  local tree = root:add(p3964r, tvb())
  tree:add(f.direction, tvb(1, 1), from == 0 and "A to B" or "B to A")
  tree:add(f.kind, tvb(2, 1))
  if known.meaning ~= "" then tree:add(f.meaning, tvb(2, 1), known.meaning):set_generated() end
  local shown = tree:add(f.flags, tvb(3, 1))
  local marks = ""
  for _, flag in ipairs(FLAGS) do
    if has(flags, flag[1]) then
      shown:add(f.flag, tvb(3, 1), flag[2])
      marks = marks .. " [" .. flag[2] .. "]"
    end
  end
  if flags % 0x40 ~= 0 then tree:add_proto_expert_info(damaged, "Characters:" .. marks) end
  tree:add(f.time, tvb(4, 4))
  local said = KINDS[kind] or string.format("kind %d", kind)
  if tvb:len() > 8 then
    local range = tvb(8)
    tree:add(f.characters, range)
    if kind == 4 or kind == 5 then
      said = show_block(range, pinfo, tree, flags, from)
      if kind == 5 then said = "broken " .. said end
    elseif kind == 6 then
      said = string.format("%d stray characters", range:len())
    end
  end
  if kind == 3 then tree:add_proto_expert_info(refused, "NAK: " .. known.meaning) end
  if known.meaning ~= "" then said = said .. ": " .. known.meaning end
  tree:append_text(", " .. said)
  pinfo.cols.info = said .. marks
  return tvb:len()
end

DissectorTable.get("wtap_encap"):add(wtap.USER0, p3964r)
