"""The built-in instructions by name: results, parameters and the functions that carry them out.

A line is `result name(parameters) = function`; `~` in front: it can wait, its function is a generator.  Types: `num&` by reference,
`num[]` an array by reference, `num[*]` an array of any dimensions.  The function has the name of the instruction unless one is given.
"""

from dataclasses import dataclass

TABLE = """
num sin(num)
num asin(num)
num cos(num)
num acos(num)
num tan(num)
num atan(num)
num abs(num)
joint abs(joint) = abs_joint
num sqrt(num)
num exp(num)
num power(num,num)
num ln(num)
num log(num)
num roundUp(num)
num roundDown(num)
num round(num)
num min(num,num)
num max(num,num)
num limit(num,num,num)
num sel(bool,num,num)
num bNot(num)
num bAnd(num,num)
num bOr(num,num)
num bXor(num,num)
num toBinary(num[],num,string,num[])
num fromBinary(num[],num,string,num[])
string toString(string,num)
string toNum(string,num&,bool&)
string chr(num)
num asc(string,num)
string left(string,num)
string right(string,num)
string mid(string,num,num)
string insert(string,string,num) = insert_text
string delete(string,num,num) = delete_text
string replace(string,string,num,num)
num find(string,string)
num len(string)
num getDisplayLen(string) = len
void dioLink(dio&,dio)
void aioLink(aio&,aio)
void sioLink(sio&,sio)
num dioGet(dio[])
num dioSet(dio[],num)
num aioGet(aio)
num aioSet(aio,num)
num ioStatus(dio) = io_status
num ioStatus(aio) = io_status
num ioStatus(sio) = sio_status
num ioStatus(dio,string&,string&) = io_description
num ioStatus(aio,string&,string&) = io_description
num ioStatus(sio,string&,string&) = sio_description
num clearBuffer(sio)
~num sioGet(sio,num[])
~num sioSet(sio,num[])
~num sioSet(sio,num[],num)
num sioCtrl(sio,string,num)
num sioCtrl(sio,string,string)
num sioCtrl(sio,string,bool)
num userPage(string)
num userPage() = user_page_none
num userPage(bool) = user_page_text
num userPage(screen) = user_page_text
~void userPageAlert(string)
~bool userPageConfirm(string)
~bool userPagePrompt(string,string&)
~bool userPagePrompt(string,num&)
void popUpMsg(string)
void popUpMsg(string,num)
bool logMsg(string)
bool logMsg(string,num)
string getProfile()
~num setProfile(string,string)
string getLanguage()
bool setLanguage(string)
string getDate(string)
void cls() = screen_cls
void cls(screen) = screen_cls
void gotoxy(num,num) = screen_gotoxy
void gotoxy(screen,num,num) = screen_gotoxy_of
void put(string) = screen_put
void put(num) = screen_put
void put(screen,string) = screen_put_of
void put(screen,num) = screen_put_of
void putln(string) = screen_putln
void putln(num) = screen_putln
void putln(screen,string) = screen_putln_of
void putln(screen,num) = screen_putln_of
void title(string) = screen_title
void title(screen,string) = screen_title_of
~num get() = screen_get_key
~num get(screen) = screen_get_key
~num get(string&) = screen_get
~num get(num&) = screen_get
~num get(screen,string&) = screen_get_of
~num get(screen,num&) = screen_get_of
num getKey() = screen_key
num getKey(screen) = screen_key
bool isKeyPressed(num) = screen_pressed
bool isKeyPressed(screen,num) = screen_pressed_of
void setTextMode(num) = screen_mode
void setTextMode(screen,num) = screen_mode_of
~void taskSuspend(string)
~void taskResume(string,num)
~void taskKill(string)
num taskStatus(string)
string help(num)
~void setMutex(bool&)
~void delay(num)
num clock()
bool wdgRefresh()
~num libDelete(string)
~num libSave()
~num libSave(string)
string libPath()
~bool libList(string,string[])
~void disablePower()
void enablePower()
bool isPowered()
bool isCalibrated()
num workingMode()
num workingMode(num&)
num esStatus()
void setSafetyRestart()
num getMonitorSpeed()
num setMonitorSpeed(num)
string getVersion(string)
joint getJntRef(string)
num hibernateRobot()
num wakeUpRobot()
bool hasCpuExtPowerSupply()
void prepareCpuShutdown()
~num brakeTest(num[])
joint herej()
bool isInRange(joint)
void setLatch(dio)
bool getLatch(joint&)
num distance(trsf,trsf) = distance_trsf
num distance(point,point) = distance_point
trsf interpolateL(trsf,trsf,num)
trsf interpolateC(trsf,trsf,trsf,num)
trsf align(trsf,trsf)
num setFrame(point,point,point,frame&)
trsf position(frame,frame) = position_frame
trsf position(tool,tool) = position_tool
trsf position(point,frame) = position_point
void link(frame&,frame)
void link(tool&,tool)
void link(point&,frame)
~void open(tool)
~void close(tool)
point compose(point,frame,trsf)
point appro(point,trsf)
point here(tool,frame)
point jointToPoint(tool,frame,joint)
bool pointToJoint(tool,joint,point,joint&)
config config(joint)
~num movej(joint,tool,mdesc) = movej_joint
~num movej(point,tool,mdesc) = movej_point
~num movel(point,tool,mdesc)
~num movec(point,point,tool,mdesc)
~num alterMovej(joint,tool,mdesc) = alter_movej_joint
~num alterMovej(point,tool,mdesc) = alter_movej_point
~num alterMovel(point,tool,mdesc)
~num alterMovec(point,point,tool,mdesc)
void stopMove()
void restartMove()
void resetMotion()
void resetMotion(joint) = reset_motion_at
~void waitEndMove()
bool isEmpty()
bool isSettled()
bool isSettled(tool,num) = is_settled_tool
bool isSettled(tool,num,num,num) = is_settled_time
void autoConnectMove(bool)
bool autoConnectMove() = auto_connect
num getSpeed(tool)
joint getPositionErr()
void getJointForce(num[])
num getMoveId()
num setMoveId(num)
num setPayload(tool,num,trsf,num[*])
num getPayload(tool,num&,trsf&,num[*])
void getIds(num[])
num getEvents(num&,num[],num[],string[])
num alterBegin(frame,mdesc) = alter_begin_frame
num alterBegin(tool,mdesc) = alter_begin_tool
num alterEnd()
num alter(trsf)
num alterStopTime()
string getLicence(string,string)
void getDH(num[],num[],num[],num[],num[]) = get_dh
void getDH(num[],num[],num[],num[],num[],num[]) = get_dh
void getDefaultDH(num[],num[],num[],num[],num[]) = get_default_dh
void getDefaultDH(num[],num[],num[],num[],num[],num[]) = get_default_dh
bool setDH(num[],num[],num[],num[],num[],num[]) = set_dh
joint resetTurn(joint)
"""


@dataclass(frozen=True, slots=True)
class Signature:
    """One form of an instruction."""

    name: str
    result: str
    parameters: tuple[str, ...]
    function: str
    waits: bool


def snake(name: str) -> str:
    """taskKill -> task_kill."""
    return "".join(f"_{letter.lower()}" if letter.isupper() else letter for letter in name)


def _parsed(line: str) -> Signature:
    head, _, function = (part.strip() for part in line.partition(" = "))
    waits = head.startswith("~")
    result, rest = head.lstrip("~").split(" ", 1)
    name, inside = rest.rstrip(")").split("(", 1)
    return Signature(name, result, tuple(inside.split(",")) if inside else (), function or snake(name), waits)


def _table() -> dict[str, list[Signature]]:
    found: dict[str, list[Signature]] = {}
    for line in TABLE.strip().splitlines():
        made = _parsed(line)
        found.setdefault(made.name.lower(), []).append(made)
    return found


SIGNATURES = _table()
LIBRARY = {  # identifier:instruction
    "libload": [
        Signature("libLoad", "num", ("string",), "lib_load", True),
        Signature("libLoad", "num", ("string", "string"), "lib_load", True),
    ],
    "libsave": [Signature("libSave", "num", (), "lib_save_of", True), Signature("libSave", "num", ("string",), "lib_save_of", True)],
    "libpath": [Signature("libPath", "string", (), "lib_path_of", False)],
    "libexist": [Signature("libExist", "bool", ("string",), "lib_exist", False)],
}
SPECIAL = frozenset("wait watch size isdefined insert delete append resize first last next prev getdata opcuaexport".split())
PAGES = frozenset(
    "userpagebind userpageunbind userpageset userpagebindmouseup userpagebindmousedown userpagebindclick userpageunbindmouseup "
    "userpageunbindmousedown userpageunbindclick".split()
)
