/* The loops over the axes of a cycle in C; twin, and their meaning: gateway/pure/cycle/axis_loops.py (AX-320).
 *
 * They work on the very objects the Python code works on.  What holds in nearly every cycle is done here; whatever else an axis or a drive
 * may be in is left to the methods of its Python class, called before anything of it was changed.
 */
#include "slots.h"

#include <math.h>

#define AXIS(X) \
    X(plan) X(drive) X(tracking) X(scaling) X(wanted) X(referenced) X(run) X(led) X(by_drive) X(set) X(active_inc) X(received_inc) \
    X(sent_inc) X(epoch) X(speed) X(quiet) X(power) X(gap) X(power_number) X(limited) X(finding) X(behind)
#define PLAN(X) X(window)
#define SCALING(X) X(zero_inc) X(inc_per_unit) X(sent_per_unit) X(rpm_per_unit)
#define DRIVE(X) \
    X(_edges) X(_held) X(_life) X(_row) X(follows) X(position_inc) X(torque_permille) X(fault_code) X(warning) X(missing) X(epoch) X(events)
#define EDGES(X) X(on_before) X(reset_before) X(asked) X(reset_left)
#define HELD(X) X(inc) X(step) X(fresh) X(refused)
#define ROW(X) X(power) X(drive_on) X(enable)
#define TRACKING(X) X(lag) X(_standstill) X(_settle) X(_still) X(_last) X(number)
#define LAG(X) X(_warn) X(_trip) X(state) X(worst)
#define SHOWN(X) X(actual) X(set) X(speed) X(lag) X(torque) X(flags) X(fault_code) X(power) X(finding)
#define BOUND(X) X(AXIS, axis) X(PLAN, plan) X(SCALING, scaling) X(DRIVE, drive) X(EDGES, edges) X(HELD, held) X(ROW, row) \
    X(TRACKING, tracking) X(LAG, lag) X(SHOWN, shown)

#define PLACES(LIST, name) static struct { LIST(PLACE) } name##_at; static PyTypeObject *name##_type; \
    static const char *const name##_names[] = {LIST(TEXT) NULL};
BOUND(PLACES)

enum { ENABLED = 2, FAULT = 3, WARNING = 4, FAULT_CODE = 8, POSITION = 9, TORQUE = 10 }; /* in an actual value */
static const char *const actual_fields[] = {"ready", "power_on", "enabled", "fault", "warning", "limit_active", "reference_switch",
                                            "brake_open", "fault_code", "position_inc", "torque_permille", NULL};
static const char *const set_fields[] = {"enable", "drive_on", "limit_switch", "fault_reset", "brake_open", "life", "position_inc",
                                         "speed_rpm", NULL};
static const char *const demand_fields[] = {"on", "reset", "position_inc", "speed_rpm", "limit_switch", "home", NULL};
enum { IS_ENABLED = 1, IS_REFERENCED = 2, IS_IN_POSITION = 4, IS_FAULT = 8, IS_LOST = 16, IS_HOMING = 32, IS_WARNING = 64, IS_ON = 128,
       IS_UNCONFIGURED = 256 }; /* AxisFlag */
#define STANDSTILL 648
#define AT_REST_S 0.02
#define INT16_LAST 32767.0

static PyTypeObject *actual_type, *set_type, *demand_type;
static PyObject *lag_ok, *lag_warning, *power_enabled, *power_fault, *power_lost, *flag_table, *zero, *still;
static PyObject *word_step, *word_power, *word_follows, *word_epoch, *word_events, *word_set_inc, *word_position_inc, *word_value,
    *word_torque_permille, *word_fault_code, *word_configured, *word_check, *word_clear;

/* An attribute of a drive of any family; new reference. */
#define OF_DRIVE(drive, name) \
    (Py_TYPE(drive) == drive_type ? Py_XNewRef(SLOT(drive, drive_at.name)) : PyObject_GetAttr(drive, word_##name))

/* What a part of a drive holds: its power, its set value; new reference. */
#define OF_PART(drive, part, slot, word) \
    (Py_TYPE(drive) == drive_type && SLOT(drive, drive_at._##part) && Py_TYPE(SLOT(drive, drive_at._##part)) == part##_type \
         ? Py_XNewRef(SLOT(SLOT(drive, drive_at._##part), part##_at.slot)) \
         : PyObject_GetAttr(drive, word))

static int attribute_truth(PyObject *object, PyObject *word)
{
    PyObject *value = PyObject_GetAttr(object, word);
    int found = value ? truth(value) : -1;
    Py_XDECREF(value);
    return found;
}

static int drive_truth(PyObject *drive, Py_ssize_t place, PyObject *word)
{
    return Py_TYPE(drive) == drive_type ? truth(SLOT(drive, place)) : attribute_truth(drive, word);
}

static double drive_real(PyObject *drive, Py_ssize_t place, PyObject *word)
{
    if (Py_TYPE(drive) == drive_type)
        return real(SLOT(drive, place));
    PyObject *value = PyObject_GetAttr(drive, word);
    double found = value ? real(value) : -1.0;
    Py_XDECREF(value);
    return found;
}

/* The set value of a drive that follows and is to go on following; NULL without an exception: its own step decides. */
static PyObject *follow(PyObject *drive, PyObject *actual, PyObject *reset, PyObject *limit, double inc, double rpm)
{
    PyObject *edges = SLOT(drive, drive_at._edges), *held = SLOT(drive, drive_at._held), *row = SLOT(drive, drive_at._row),
             *events = SLOT(drive, drive_at.events);
    if (!edges || Py_TYPE(edges) != edges_type || !held || Py_TYPE(held) != held_type || !row || Py_TYPE(row) != row_type || !events
        || !PyList_CheckExact(events))
        return NULL;
    if (Py_TYPE(actual) != actual_type || SLOT(drive, drive_at.follows) != Py_True || SLOT(edges, edges_at.on_before) != Py_True
        || SLOT(edges, edges_at.reset_before) != reset || SLOT(edges, edges_at.asked) != Py_False
        || SLOT(edges, edges_at.reset_left) != zero || SLOT(held, held_at.fresh) != Py_False
        || PyTuple_GET_ITEM(actual, ENABLED) != Py_True || PyTuple_GET_ITEM(actual, FAULT) != Py_False)
        return NULL;
    double before = real(SLOT(held, held_at.inc)), window = real(SLOT(held, held_at.step));
    long life = PyLong_AsLong(SLOT(drive, drive_at._life));
    if (PyErr_Occurred() || !(fabs(inc - before) <= window) || !(inc >= INT32_MIN && inc <= INT32_MAX)
        || !(rpm >= -INT16_LAST && rpm <= INT16_LAST)) {
        PyErr_Clear();
        return NULL;
    }
    PyObject *enable = SLOT(row, row_at.enable), *values[8] = {Py_NewRef(enable), Py_NewRef(SLOT(row, row_at.drive_on)), Py_NewRef(limit),
        Py_NewRef(Py_False), Py_NewRef(enable), PyLong_FromLong((life + 1) & 0xFF), PyLong_FromLong((long)inc),
        PyLong_FromLong((long)rint(rpm))};
    PyObject *made = new_record(set_type, 8), *fresh = PyList_GET_SIZE(events) ? PyList_New(0) : NULL;
    if (!made || !values[5] || !values[6] || !values[7] || (PyList_GET_SIZE(events) && !fresh)) {
        for (int n = 0; n < 8; n++)
            Py_XDECREF(values[n]);
        Py_XDECREF(made);
        Py_XDECREF(fresh);
        return PyErr_NoMemory();
    }
    for (int n = 0; n < 8; n++)
        PyTuple_SET_ITEM(made, n, values[n]);
    if (fresh)
        put(drive, drive_at.events, fresh);
    put_known(drive, drive_at.missing, zero);
    put_known(drive, drive_at.position_inc, PyTuple_GET_ITEM(actual, POSITION));
    put_known(drive, drive_at.torque_permille, PyTuple_GET_ITEM(actual, TORQUE));
    put_known(drive, drive_at.fault_code, PyTuple_GET_ITEM(actual, FAULT_CODE));
    put_known(drive, drive_at.warning, PyTuple_GET_ITEM(actual, WARNING));
    put_known(drive, drive_at._life, values[5]);
    put_known(held, held_at.inc, values[6]);
    put_known(held, held_at.refused, Py_False);
    return made;
}

/* drive.step(actual, Demand(...)) */
static PyObject *step(PyObject *drive, PyObject *actual, PyObject *axis, PyObject *reset, PyObject *limit, double inc, double rpm)
{
    PyObject *demand = new_record(demand_type, 6), *position = PyLong_FromDouble(inc), *speed = PyFloat_FromDouble(rpm), *value = NULL;
    if (demand && position && speed) {
        PyObject *items[6] = {SLOT(axis, axis_at.wanted), reset, position, speed, limit, SLOT(axis, axis_at.by_drive)};
        for (int n = 0; n < 6; n++)
            PyTuple_SET_ITEM(demand, n, Py_NewRef(items[n]));
        value = PyObject_CallMethodObjArgs(drive, word_step, actual, demand, NULL);
    }
    Py_XDECREF(demand);
    Py_XDECREF(position);
    Py_XDECREF(speed);
    return value;
}

/* How the axis stands after its drive's step: power, settled, eventful, behind; 0, or -1. */
static int look(PyObject *axis, PyObject *drive, PyObject *scaling, int *settled, int *eventful)
{
    PyObject *power = OF_PART(drive, row, power, word_power), *epoch = OF_DRIVE(drive, epoch), *events = OF_DRIVE(drive, events), *number = NULL;
    int follows = drive_truth(drive, drive_at.follows, word_follows), same = -1, some = -1;
    double asked = real(SLOT(axis, axis_at.active_inc)), place = drive_real(drive, drive_at.position_inc, word_position_inc);
    double per_unit = real(SLOT(scaling, scaling_at.inc_per_unit));
    if (power && epoch && events && follows >= 0 && !PyErr_Occurred()) {
        same = SLOT(axis, axis_at.epoch) == epoch ? 1 : PyObject_RichCompareBool(epoch, SLOT(axis, axis_at.epoch), Py_EQ);
        some = truth(events);
        if (power != SLOT(axis, axis_at.power) && (number = PyObject_GetAttr(power, word_value))) {
            put_known(axis, axis_at.power, power);
            put(axis, axis_at.power_number, number);
        }
        PyObject *behind = PyFloat_FromDouble((asked - place) / per_unit);
        if (behind)
            put(axis, axis_at.behind, behind);
    }
    *settled &= follows > 0 && same > 0;
    *eventful |= some > 0;
    Py_XDECREF(power);
    Py_XDECREF(epoch);
    Py_XDECREF(events);
    return PyErr_Occurred() || same < 0 || some < 0 ? -1 : 0;
}

static PyObject *drive_axis(PyObject *axis, PyObject *actual, PyObject *q, PyObject *speed, PyObject *reset, int *settled, int *eventful)
{
    PyObject *drive = SLOT(axis, axis_at.drive), *scaling = SLOT(axis, axis_at.scaling);
    if (!drive || !scaling || Py_TYPE(scaling) != scaling_type) {
        PyErr_SetString(PyExc_TypeError, "an axis without drive or scaling");
        return NULL;
    }
    int led = truth(SLOT(axis, axis_at.led)), by_drive = truth(SLOT(axis, axis_at.by_drive));
    int follows = drive_truth(drive, drive_at.follows, word_follows), wanted = truth(SLOT(axis, axis_at.wanted));
    int referenced = truth(SLOT(axis, axis_at.referenced)), limited = truth(SLOT(axis, axis_at.limited));
    PyObject *last = OF_PART(drive, held, inc, word_set_inc);
    if (!last || led < 0 || by_drive < 0 || follows < 0 || wanted < 0 || referenced < 0 || limited < 0) {
        Py_XDECREF(last);
        return NULL;
    }
    put_known(axis, axis_at.active_inc, SLOT(axis, axis_at.received_inc));
    put_known(axis, axis_at.received_inc, SLOT(axis, axis_at.sent_inc));
    put(axis, axis_at.sent_inc, last);
    if (led) {
        put_known(axis, axis_at.led, Py_False);
    } else if (follows && !by_drive) {
        put_known(axis, axis_at.set, q);
        put_known(axis, axis_at.speed, speed);
    } else {
        put_known(axis, axis_at.speed, still);
    }
    double per_unit = real(SLOT(scaling, scaling_at.sent_per_unit)), from = real(SLOT(scaling, scaling_at.zero_inc));
    double inc = rint(from + real(SLOT(axis, axis_at.set)) * per_unit);
    double rpm = real(SLOT(axis, axis_at.speed)) * real(SLOT(scaling, scaling_at.rpm_per_unit));
    if (PyErr_Occurred())
        return NULL;
    PyObject *limit = referenced && limited ? Py_True : Py_False;
    PyObject *value = Py_TYPE(drive) == drive_type && wanted ? follow(drive, actual, reset, limit, inc, rpm) : NULL;
    if (!value && !PyErr_Occurred())
        value = step(drive, actual, axis, reset, limit, inc, rpm);
    if (value && look(axis, drive, scaling, settled, eventful) < 0)
        Py_CLEAR(value);
    return value;
}

/* drive_axes(axes, actuals, q, qd, reset) -> (set values, settled, eventful) */
static PyObject *drive_axes(PyObject *self, PyObject *const *args, Py_ssize_t count)
{
    int settled = 1, eventful = 0;
    if (count != 5 || !PyList_CheckExact(args[0]) || !PyBool_Check(args[4]))
        return PyErr_Format(PyExc_TypeError, "a list of axes, actual values, positions, speeds, and a bool expected");
    for (int n = 1; n < 4; n++) {
        if (!PyList_Check(args[n]) && !PyTuple_Check(args[n]))
            return PyErr_Format(PyExc_TypeError, "%R is no list and no tuple", args[n]);
        if (PySequence_Fast_GET_SIZE(args[n]) != PyList_GET_SIZE(args[0]))
            return PyErr_Format(PyExc_ValueError, "not as many values as axes");
    }
    PyObject *axes = args[0];
    Py_ssize_t axis_count = PyList_GET_SIZE(axes);
    PyObject *values = PyList_New(axis_count);
    for (Py_ssize_t n = 0; values && n < axis_count; n++) {
        PyObject *axis = PyList_GET_ITEM(axes, n);
        PyObject *value = Py_TYPE(axis) == axis_type
            ? drive_axis(axis, PySequence_Fast_GET_ITEM(args[1], n), PySequence_Fast_GET_ITEM(args[2], n),
                         PySequence_Fast_GET_ITEM(args[3], n), args[4], &settled, &eventful)
            : PyErr_Format(PyExc_TypeError, "%R is no axis", axis);
        if (value)
            PyList_SET_ITEM(values, n, value);
        else
            Py_CLEAR(values);
    }
    return values ? Py_BuildValue("(NOO)", values, settled ? Py_True : Py_False, eventful ? Py_True : Py_False) : NULL;
}

/* Tracking.check in nearly every case; -1 without an exception: its own method decides. */
static long tracked(PyObject *tracking, PyObject *active, PyObject *behind)
{
    if (Py_TYPE(tracking) != tracking_type || SLOT(tracking, tracking_at.number) != zero)
        return -1;
    PyObject *lag = SLOT(tracking, tracking_at.lag), *last = SLOT(tracking, tracking_at._last);
    if (!lag || Py_TYPE(lag) != lag_type || SLOT(lag, lag_at.state) != lag_ok || !last)
        return -1;
    double size = fabs(real(behind)), warn = real(SLOT(lag, lag_at._warn)), trip = real(SLOT(lag, lag_at._trip));
    double worst = real(SLOT(lag, lag_at.worst)), standstill = real(SLOT(tracking, tracking_at._standstill));
    long still_for = PyLong_AsLong(SLOT(tracking, tracking_at._still)), settle = PyLong_AsLong(SLOT(tracking, tracking_at._settle));
    int same = active == last ? 1 : PyObject_RichCompareBool(active, last, Py_EQ);
    if (PyErr_Occurred()) {
        PyErr_Clear();
        return -1;
    }
    if (!(size <= warn && size <= trip))
        return -1;
    still_for = same ? still_for + 1 : 0;
    int left = still_for >= settle && !(size <= standstill);
    PyObject *counted = PyLong_FromLong(still_for), *number = left ? PyLong_FromLong(STANDSTILL) : NULL;
    PyObject *most = size > worst ? PyFloat_FromDouble(size) : NULL;
    if (counted)
        put(tracking, tracking_at._still, counted);
    if (!same)
        put_known(tracking, tracking_at._last, active);
    if (most)
        put(lag, lag_at.worst, most);
    if (number)
        put(tracking, tracking_at.number, number);
    return left ? STANDSTILL : 0;
}

/* 1: this axis was found out; 0, or -1 with an exception. */
static int watch_axis(PyObject *axis, PyObject *actual)
{
    PyObject *drive = SLOT(axis, axis_at.drive), *tracking = SLOT(axis, axis_at.tracking), *answer = NULL;
    int gap = truth(SLOT(axis, axis_at.gap)), by_drive = truth(SLOT(axis, axis_at.by_drive));
    int follows = drive ? drive_truth(drive, drive_at.follows, word_follows) : -1;
    if (!tracking || gap < 0 || by_drive < 0 || follows < 0)
        return -1;
    put_known(axis, axis_at.gap, actual == Py_None ? Py_True : Py_False);
    if (gap || actual == Py_None || by_drive || !follows) {
        answer = PyObject_CallMethodNoArgs(tracking, word_clear);
        Py_XDECREF(answer);
        return answer ? 0 : -1;
    }
    long number = tracked(tracking, SLOT(axis, axis_at.active_inc), SLOT(axis, axis_at.behind));
    if (number < 0) {
        answer = PyObject_CallMethodObjArgs(tracking, word_check, SLOT(axis, axis_at.active_inc), SLOT(axis, axis_at.behind), NULL);
        number = answer ? PyLong_AsLong(answer) : -1;
        Py_XDECREF(answer);
    }
    if (PyErr_Occurred())
        return -1;
    if (number)
        put(axis, axis_at.finding, PyLong_FromLong(number));
    return number != 0;
}

/* watch_axes(axes, actuals, first) -> index of the first axis from there on that was found out, -1: none */
static PyObject *watch_axes(PyObject *self, PyObject *const *args, Py_ssize_t count)
{
    if (count != 3 || !PyList_CheckExact(args[0]) || (!PyList_Check(args[1]) && !PyTuple_Check(args[1]))
        || PyList_GET_SIZE(args[0]) != PySequence_Fast_GET_SIZE(args[1]))
        return PyErr_Format(PyExc_TypeError, "axes, as many actual values, and an index expected");
    for (Py_ssize_t n = PyLong_AsSsize_t(args[2]); n >= 0 && n < PyList_GET_SIZE(args[0]); n++) {
        PyObject *axis = PyList_GET_ITEM(args[0], n);
        if (Py_TYPE(axis) != axis_type)
            return PyErr_Format(PyExc_TypeError, "%R is no axis", axis);
        int found = watch_axis(axis, PySequence_Fast_GET_ITEM(args[1], n));
        if (found)
            return found < 0 ? NULL : PyLong_FromSsize_t(n);
    }
    return PyErr_Occurred() ? NULL : PyLong_FromLong(-1);
}

/* The bits of AxisFlag; -1 with an exception. */
static long show_axis(PyObject *out, PyObject *axis, int at_rest, double period)
{
    PyObject *drive = SLOT(axis, axis_at.drive), *scaling = SLOT(axis, axis_at.scaling), *plan = SLOT(axis, axis_at.plan);
    PyObject *tracking = SLOT(axis, axis_at.tracking), *power = SLOT(axis, axis_at.power);
    if (!drive || !scaling || Py_TYPE(scaling) != scaling_type || !plan || Py_TYPE(plan) != plan_type || !tracking
        || Py_TYPE(tracking) != tracking_type || Py_TYPE(SLOT(tracking, tracking_at.lag)) != lag_type) {
        PyErr_SetString(PyExc_TypeError, "an axis of unknown parts");
        return -1;
    }
    double place = drive_real(drive, drive_at.position_inc, word_position_inc), from = real(SLOT(scaling, scaling_at.zero_inc));
    double actual = (place - from) / real(SLOT(scaling, scaling_at.inc_per_unit)), set = real(SLOT(axis, axis_at.set));
    double torque = drive_real(drive, drive_at.torque_permille, word_torque_permille) / 1000.0, window = real(SLOT(plan, plan_at.window));
    int configured = attribute_truth(drive, word_configured), referenced = truth(SLOT(axis, axis_at.referenced));
    int wanted = truth(SLOT(axis, axis_at.wanted)), by_drive = truth(SLOT(axis, axis_at.by_drive));
    long quiet = PyLong_AsLong(SLOT(axis, axis_at.quiet)), flags = 0;
    PyObject *code = OF_DRIVE(drive, fault_code);
    if (PyErr_Occurred() || !code) {
        Py_XDECREF(code);
        return -1;
    }
    quiet = power == power_enabled && at_rest && fabs(set - actual) <= window ? quiet + 1 : 0;
    if (power == power_enabled)
        flags = quiet && (double)quiet * period >= AT_REST_S ? IS_ENABLED | IS_IN_POSITION : IS_ENABLED;
    else
        flags = power == power_fault ? IS_FAULT : power == power_lost ? IS_LOST : 0;
    flags |= (referenced ? IS_REFERENCED : 0) | (wanted ? IS_ON : 0) | (configured ? 0 : IS_UNCONFIGURED);
    flags |= SLOT(axis, axis_at.run) != Py_None || by_drive ? IS_HOMING : 0;
    flags |= SLOT(SLOT(tracking, tracking_at.lag), lag_at.state) == lag_warning ? IS_WARNING : 0;
    put(axis, axis_at.quiet, PyLong_FromLong(quiet));
    put(out, shown_at.actual, PyFloat_FromDouble(actual));
    put(out, shown_at.torque, PyFloat_FromDouble(torque));
    put_known(out, shown_at.set, SLOT(axis, axis_at.set));
    put_known(out, shown_at.speed, SLOT(axis, axis_at.speed));
    put_known(out, shown_at.lag, SLOT(axis, axis_at.behind));
    put_known(out, shown_at.flags, PyTuple_GET_ITEM(flag_table, flags));
    put(out, shown_at.fault_code, code);
    put_known(out, shown_at.power, SLOT(axis, axis_at.power_number));
    put_known(out, shown_at.finding, SLOT(axis, axis_at.finding));
    return PyErr_Occurred() ? -1 : flags;
}

/* show_axes(states, axes, at_rest, period_s) -> (flags of any, flags of all, in position, referenced); the last two by axis */
static PyObject *show_axes(PyObject *self, PyObject *const *args, Py_ssize_t count)
{
    if (count != 4 || !PyList_CheckExact(args[0]) || !PyList_CheckExact(args[1]) || PyList_GET_SIZE(args[0]) < PyList_GET_SIZE(args[1]))
        return PyErr_Format(PyExc_TypeError, "lists of states and of axes, a bool and a float expected");
    long any = 0, all = IS_ENABLED, in_position = 0, referenced = 0;
    int at_rest = truth(args[2]);
    double period = real(args[3]);
    for (Py_ssize_t n = 0; n < PyList_GET_SIZE(args[1]); n++) {
        PyObject *out = PyList_GET_ITEM(args[0], n), *axis = PyList_GET_ITEM(args[1], n);
        if (Py_TYPE(out) != shown_type || Py_TYPE(axis) != axis_type)
            return PyErr_Format(PyExc_TypeError, "%R and %R are no state and axis", out, axis);
        long flags = show_axis(out, axis, at_rest, period);
        if (flags < 0)
            return NULL;
        any |= flags;
        all &= flags;
        in_position |= flags & IS_IN_POSITION ? 1L << n : 0;
        referenced |= flags & IS_REFERENCED ? 1L << n : 0;
    }
    return PyErr_Occurred() ? NULL : Py_BuildValue("(llll)", any, all, in_position, referenced);
}

/* Class attribute of an enumeration; kept for good. */
static int member(PyObject *kind, const char *name, PyObject **kept)
{
    Py_XSETREF(*kept, PyObject_GetAttrString(kind, name));
    return *kept ? 0 : -1;
}

#define BIND(LIST, name) \
    if (!PyType_Check(args[n]) || find_places(args[n], name##_names, (Py_ssize_t *)&name##_at) < 0) \
        return NULL; \
    name##_type = (PyTypeObject *)Py_NewRef(args[n++]);

/* bind(HeldAxis, CoreAxis, Scaling, Drive, DemandEdges, HeldPosition, Row, Tracking, LagMonitor, AxisState, SetValue, ActualValue,
 * Demand, Power, LagState, FLAGS): once, before anything else; TypeError when one of them is not built as this module knows it. */
static PyObject *bind(PyObject *self, PyObject *const *args, Py_ssize_t count)
{
    int n = 0;
    if (count != 16)
        return PyErr_Format(PyExc_TypeError, "16 classes and tables expected, %zd given", count);
    BOUND(BIND)
    if (check_fields(args[10], set_fields) < 0 || check_fields(args[11], actual_fields) < 0 || check_fields(args[12], demand_fields) < 0)
        return NULL;
    set_type = (PyTypeObject *)Py_NewRef(args[10]);
    actual_type = (PyTypeObject *)Py_NewRef(args[11]);
    demand_type = (PyTypeObject *)Py_NewRef(args[12]);
    if (member(args[13], "ENABLED", &power_enabled) < 0 || member(args[13], "FAULT", &power_fault) < 0
        || member(args[13], "LOST", &power_lost) < 0 || member(args[14], "OK", &lag_ok) < 0 || member(args[14], "WARNING", &lag_warning) < 0)
        return NULL;
    if (!PyTuple_CheckExact(args[15]) || PyTuple_GET_SIZE(args[15]) != 2 * IS_UNCONFIGURED)
        return PyErr_Format(PyExc_TypeError, "a table of %d flags expected", 2 * IS_UNCONFIGURED);
    Py_XSETREF(flag_table, Py_NewRef(args[15]));
    Py_RETURN_NONE;
}

static PyMethodDef methods[] = {
    {"bind", (PyCFunction)(void (*)(void))bind, METH_FASTCALL, NULL},
    {"drive_axes", (PyCFunction)(void (*)(void))drive_axes, METH_FASTCALL, NULL},
    {"watch_axes", (PyCFunction)(void (*)(void))watch_axes, METH_FASTCALL, NULL},
    {"show_axes", (PyCFunction)(void (*)(void))show_axes, METH_FASTCALL, NULL},
    {NULL, NULL, 0, NULL},
};
static struct PyModuleDef module = {PyModuleDef_HEAD_INIT, "axes", NULL, -1, methods, NULL, NULL, NULL, NULL};

PyMODINIT_FUNC PyInit_axes(void)
{
    static const struct { PyObject **kept; const char *text; } words[] = {
        {&word_step, "step"}, {&word_power, "power"}, {&word_follows, "follows"}, {&word_epoch, "epoch"}, {&word_events, "events"},
        {&word_set_inc, "set_inc"}, {&word_position_inc, "position_inc"}, {&word_value, "value"},
        {&word_torque_permille, "torque_permille"}, {&word_fault_code, "fault_code"}, {&word_configured, "configured"},
        {&word_check, "check"}, {&word_clear, "clear"}};
    for (size_t n = 0; n < sizeof words / sizeof *words; n++)
        if (!(*words[n].kept = PyUnicode_InternFromString(words[n].text)))
            return NULL;
    zero = PyLong_FromLong(0);
    still = PyFloat_FromDouble(0.0);
    return zero && still ? PyModule_Create(&module) : NULL;
}
