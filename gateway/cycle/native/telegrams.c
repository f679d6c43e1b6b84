/* Telegrams of SERVODYN-GC drives between messages of the local bus and the values of the cycle, in C (AX-320).
 *
 *   collect(buses, actuals, missing, until_ns) -> (still missing, late ones, None or (place of a bus, a message of it or None))
 *   message(table, values) -> SYNC and the set values as one message for the bus, or None
 *
 * Twins: Cycle._collect with BusLink.receive and ServodynFamily.hear; ServodynFamily.burst with drivers.ports.can.wire.pack_records.  What is
 * not as it nearly always is goes to the twin: collect() hands it the whole message, nothing of it taken (no message: the bus is gone, the
 * port will say how); message() says None.  Records: struct can_frame, stamp, sequence (AX-092).
 */
#include "slots.h"

#include <errno.h>
#include <poll.h>
#include <stdint.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>

#define IDENTIFIERS 2048
#define MOST_AXES 12
#define MOST_RECORDS 64
#define MOST_BUSES 8
#define SECOND_NS 1000000000LL
#define LAST_LOOKS 4 /* messages taken behind the time: what is there came in time, a flood does not hold the cycle */
#define NUMBERS 3
#define FLAGS 8
#define SET_FLAGS 5

struct record {
    uint32_t identifier;
    uint8_t length, sender, spare[2];
    uint8_t data[8];
    uint64_t stamp_ns, sequence;
};

struct number { /* little endian, of its full range */
    int at, size, has_sign;
};

struct row { /* one axis */
    Py_ssize_t index; /* in the cell */
    unsigned set_identifier;
    int set_length, actual_length;
    uint8_t set_bits[SET_FLAGS], actual_bits[FLAGS]; /* place of each flag in byte 0 */
    struct number set_numbers[NUMBERS], actual_numbers[NUMBERS];
};

struct table {
    int count;
    int8_t of[IDENTIFIERS]; /* identifier of an actual value -> row, -1: none */
    struct row rows[MOST_AXES];
    unsigned sync; /* its identifier; it has no data */
};

static PyTypeObject *actual_type, *set_type;
static const char TABLE[] = "axisgate.telegrams";

static int64_t take(const uint8_t *data, struct number one)
{
    uint64_t raw = 0;
    for (int n = 0; n < one.size; n++)
        raw |= (uint64_t)data[one.at + n] << 8 * n;
    if (one.has_sign && raw >> (8 * one.size - 1))
        raw |= ~(uint64_t)0 << 8 * one.size;
    return (int64_t)raw;
}

/* 0: it fits. */
static int give(uint8_t *data, struct number one, int64_t value)
{
    int64_t low = one.has_sign ? -((int64_t)1 << (8 * one.size - 1)) : 0;
    if (value < low || value > low + (((int64_t)1 << 8 * one.size) - 1))
        return -1;
    for (int n = 0; n < one.size; n++)
        data[one.at + n] = (uint8_t)((uint64_t)value >> 8 * n);
    return 0;
}

static PyObject *actual_value(const struct row *row, const uint8_t *data)
{
    PyObject *made = new_record(actual_type, FLAGS + NUMBERS);
    for (int n = 0; made && n < FLAGS; n++)
        PyTuple_SET_ITEM(made, n, Py_NewRef(data[0] >> row->actual_bits[n] & 1 ? Py_True : Py_False));
    for (int n = 0; made && n < NUMBERS; n++) {
        PyObject *value = PyLong_FromLongLong(take(data, row->actual_numbers[n]));
        if (!value)
            Py_CLEAR(made);
        else
            PyTuple_SET_ITEM(made, FLAGS + n, value);
    }
    return made;
}

static struct table *table_of(PyObject *capsule)
{
    return PyCapsule_GetPointer(capsule, TABLE);
}

/* The actual values of one message into `actuals`; 1: done, 0: the twin has to, -1: exception. */
static int take_message(const struct table *table, const void *message, Py_ssize_t size, int64_t sent, PyObject *actuals, long *fresh, long *late)
{
    const struct record *records = message;
    Py_ssize_t count = size / (Py_ssize_t)sizeof *records;
    if (size <= 0 || size % (Py_ssize_t)sizeof *records)
        return 0;
    for (Py_ssize_t n = 0; n < count; n++) {
        int at = records[n].identifier < IDENTIFIERS ? table->of[records[n].identifier] : -1;
        if (at < 0 || records[n].length != table->rows[at].actual_length || table->rows[at].index >= PyList_GET_SIZE(actuals))
            return 0;
    }
    for (Py_ssize_t n = 0; n < count; n++) {
        const struct row *row = &table->rows[table->of[records[n].identifier]];
        if ((int64_t)records[n].stamp_ns < sent) {
            ++*late;
            continue;
        }
        PyObject *value = actual_value(row, records[n].data);
        if (!value)
            return -1;
        *fresh += PyList_GET_ITEM(actuals, row->index) == Py_None;
        PyList_SetItem(actuals, row->index, value);
    }
    return 1;
}

static int64_t now_ns(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return t.tv_sec * SECOND_NS + t.tv_nsec;
}

struct bus {
    struct table *table;
    int64_t sent;
};

/* One message of this bus; 1: done, 0: nothing waits, 2: the twin has to (`odd`: the message, NULL: the bus is gone), -1: exception. */
static int take_one(const struct bus *bus, int fd, PyObject *actuals, long *fresh, long *late, PyObject **odd)
{
    static _Alignas(8) char message[65536]; /* under the GIL */
    ssize_t size = recv(fd, message, sizeof message, MSG_DONTWAIT);
    if (size < 0 && (errno == EAGAIN || errno == EINTR))
        return 0;
    int done = size > 0 ? take_message(bus->table, message, size, bus->sent, actuals, fresh, late) : 0;
    if (done == 0 && size > 0 && !(*odd = PyBytes_FromStringAndSize(message, size)))
        return -1;
    return done == 0 ? 2 : done;
}

/* [(table, descriptor, stamp of the burst)] -> buses; how many, -1 with an exception. */
static int buses_of(PyObject *list, struct bus *buses, struct pollfd *fds)
{
    Py_ssize_t count = PyList_CheckExact(list) ? PyList_GET_SIZE(list) : -1;
    for (Py_ssize_t n = 0; n < count && count <= MOST_BUSES; n++) {
        PyObject *each = PyList_GET_ITEM(list, n);
        if (!PyTuple_CheckExact(each) || PyTuple_GET_SIZE(each) != 3)
            break;
        buses[n].table = table_of(PyTuple_GET_ITEM(each, 0));
        fds[n] = (struct pollfd){.fd = (int)PyLong_AsLong(PyTuple_GET_ITEM(each, 1)), .events = POLLIN};
        buses[n].sent = PyLong_AsLongLong(PyTuple_GET_ITEM(each, 2));
        if (PyErr_Occurred())
            return -1;
        if (n + 1 == count)
            return (int)count;
    }
    PyErr_Format(PyExc_TypeError, "1 to %d buses of table, descriptor and stamp expected", MOST_BUSES);
    return -1;
}

/* Waits until no axis is missing, the time is up, or something came that is for the twin.  What is there when the time is up is taken. */
static PyObject *collect(PyObject *self, PyObject *const *args, Py_ssize_t count)
{
    struct bus buses[MOST_BUSES];
    struct pollfd fds[MOST_BUSES];
    int known = count == 4 && PyList_CheckExact(args[1]) ? buses_of(args[0], buses, fds) : -1;
    if (known < 0)
        return PyErr_Occurred() ? NULL : PyErr_Format(PyExc_TypeError, "buses, actual values, a number and an instant expected");
    long missing = PyLong_AsLong(args[2]), late = 0;
    int64_t until = PyLong_AsLongLong(args[3]), left;
    PyObject *odd = NULL;
    int where = -1, looks = 0;
    while (!PyErr_Occurred() && missing > 0 && where < 0 && looks < LAST_LOOKS) {
        if ((left = until - now_ns()) <= 0) {
            left = 0;
            looks++;
        }
        struct timespec wait = {left / SECOND_NS, left % SECOND_NS};
        int ready;
        Py_BEGIN_ALLOW_THREADS
        ready = ppoll(fds, (nfds_t)known, &wait, NULL);
        Py_END_ALLOW_THREADS
        if (ready < 0 && PyErr_CheckSignals() < 0)
            return NULL;
        if (ready <= 0 && looks)
            break;
        for (int n = 0; n < known && ready > 0 && where < 0; n++) {
            long fresh = 0;
            int done = fds[n].revents ? take_one(&buses[n], fds[n].fd, args[1], &fresh, &late, &odd) : 0;
            if (done < 0)
                return NULL;
            missing -= fresh;
            where = done == 2 ? n : -1;
        }
    }
    if (PyErr_Occurred())
        return NULL;
    PyObject *rest = where < 0 ? Py_NewRef(Py_None) : Py_BuildValue("(iN)", where, odd ? odd : Py_NewRef(Py_None));
    return rest ? Py_BuildValue("(llN)", missing, late, rest) : NULL;
}

/* 1: done, 0: the twin has to. */
static int set_octets(const struct row *row, PyObject *values, uint8_t data[8])
{
    PyObject *value = row->index < PyList_GET_SIZE(values) ? PyList_GET_ITEM(values, row->index) : NULL;
    if (!value || Py_TYPE(value) != set_type)
        return 0;
    for (int n = 0; n < SET_FLAGS; n++) {
        PyObject *flag = PyTuple_GET_ITEM(value, n);
        if (flag != Py_True && flag != Py_False)
            return 0;
        data[0] |= (flag == Py_True) << row->set_bits[n];
    }
    for (int n = 0; n < NUMBERS; n++) {
        PyObject *item = PyTuple_GET_ITEM(value, SET_FLAGS + n);
        int over = 0;
        int64_t number = PyLong_CheckExact(item) ? PyLong_AsLongLongAndOverflow(item, &over) : INT64_MIN;
        if (over || give(data, row->set_numbers[n], number) < 0)
            return 0;
    }
    return 1;
}

static PyObject *message(PyObject *self, PyObject *const *args, Py_ssize_t count)
{
    struct table *table = count == 2 ? table_of(args[0]) : NULL;
    if (!table || !PyList_CheckExact(args[1]))
        return PyErr_Occurred() ? NULL : PyErr_Format(PyExc_TypeError, "table and a list of set values expected");
    struct record made[MOST_AXES + 1];
    memset(made, 0, sizeof made);
    made[0].identifier = table->sync;
    for (int n = 0; n < table->count; n++) {
        const struct row *row = &table->rows[n];
        if (!set_octets(row, args[1], made[n + 1].data))
            Py_RETURN_NONE;
        made[n + 1].identifier = row->set_identifier;
        made[n + 1].length = (uint8_t)row->set_length;
    }
    return PyBytes_FromStringAndSize((const char *)made, (table->count + 1) * (Py_ssize_t)sizeof *made);
}

static void forget(PyObject *capsule)
{
    PyMem_Free(table_of(capsule));
}

/* Three of (place in octets, octets, 1 for signed) out of a tuple of nine, inside a telegram of so many octets; 0, or -1. */
static int numbers_of(PyObject *tuple, int length, struct number *numbers)
{
    int good = PyArg_ParseTuple(tuple, "iiiiiiiii", &numbers[0].at, &numbers[0].size, &numbers[0].has_sign, &numbers[1].at,
                                &numbers[1].size, &numbers[1].has_sign, &numbers[2].at, &numbers[2].size, &numbers[2].has_sign);
    for (int n = 0; good && n < NUMBERS; n++)
        good = numbers[n].at >= 1 && numbers[n].size >= 1 && numbers[n].size <= 4 && numbers[n].at + numbers[n].size <= length;
    return good && length <= 8 ? 0 : -1;
}

/* table(identifier of SYNC, [(index, identifier, length, bits of the flags, numbers) of the set value + the same without index of the
 * actual value]); None when there are more axes than it has places for. */
static PyObject *make_table(PyObject *self, PyObject *args)
{
    PyObject *rows;
    unsigned sync;
    if (!PyArg_ParseTuple(args, "IO!", &sync, &PyList_Type, &rows))
        return NULL;
    if (PyList_GET_SIZE(rows) > MOST_AXES)
        Py_RETURN_NONE;
    struct table *table = PyMem_Calloc(1, sizeof *table);
    PyObject *capsule = table ? PyCapsule_New(table, TABLE, forget) : PyErr_NoMemory();
    if (!capsule)
        return NULL;
    memset(table->of, -1, sizeof table->of);
    table->sync = sync;
    for (; table->count < PyList_GET_SIZE(rows); table->count++) {
        struct row *row = &table->rows[table->count];
        PyObject *set_numbers, *actual_numbers;
        const char *set_bits, *actual_bits;
        Py_ssize_t set_count, actual_count;
        unsigned identifier;
        if (!PyArg_ParseTuple(PyList_GET_ITEM(rows, table->count), "nIiy#O!Iiy#O!", &row->index, &row->set_identifier, &row->set_length,
                              &set_bits, &set_count, &PyTuple_Type, &set_numbers, &identifier, &row->actual_length, &actual_bits,
                              &actual_count, &PyTuple_Type, &actual_numbers))
            break;
        if (set_count != SET_FLAGS || actual_count != FLAGS || identifier >= IDENTIFIERS || row->index < 0
            || numbers_of(set_numbers, row->set_length, row->set_numbers) < 0
            || numbers_of(actual_numbers, row->actual_length, row->actual_numbers) < 0) {
            if (!PyErr_Occurred())
                PyErr_SetString(PyExc_ValueError, "a row that is no telegram");
            break;
        }
        memcpy(row->set_bits, set_bits, SET_FLAGS);
        memcpy(row->actual_bits, actual_bits, FLAGS);
        table->of[identifier] = (int8_t)table->count;
    }
    if (PyErr_Occurred())
        Py_CLEAR(capsule);
    return capsule;
}

/* bind(SetValue, ActualValue) */
static PyObject *bind_classes(PyObject *self, PyObject *args)
{
    static const char *const actual_fields[] = {"ready", "power_on", "enabled", "fault", "warning", "limit_active", "reference_switch",
                                                "brake_open", "fault_code", "position_inc", "torque_permille", NULL};
    static const char *const set_fields[] = {"enable", "drive_on", "limit_switch", "fault_reset", "brake_open", "life", "position_inc",
                                             "speed_rpm", NULL};
    PyObject *set, *actual;
    if (!PyArg_ParseTuple(args, "OO", &set, &actual) || check_fields(set, set_fields) < 0 || check_fields(actual, actual_fields) < 0)
        return NULL;
    set_type = (PyTypeObject *)Py_NewRef(set);
    actual_type = (PyTypeObject *)Py_NewRef(actual);
    Py_RETURN_NONE;
}

static PyMethodDef methods[] = {
    {"bind", bind_classes, METH_VARARGS, NULL},
    {"table", make_table, METH_VARARGS, NULL},
    {"collect", (PyCFunction)(void (*)(void))collect, METH_FASTCALL, NULL},
    {"message", (PyCFunction)(void (*)(void))message, METH_FASTCALL, NULL},
    {NULL, NULL, 0, NULL},
};
static struct PyModuleDef module = {PyModuleDef_HEAD_INIT, "telegrams", NULL, -1, methods, NULL, NULL, NULL, NULL};

PyMODINIT_FUNC PyInit_telegrams(void)
{
    return PyModule_Create(&module);
}
